"""A small capture with every field off its default, as tests/unit/capture_fixture.hpp has it."""
import os
import struct
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "python"))
import subpixel_capture as spcap  # noqa: E402

BINARY = os.environ.get("SUBPIXEL_BINARY", os.path.join(ROOT, "build", "release", "subpixel"))


def subpixel(*arguments):
    """Exit code, output and errors of the program."""
    done = subprocess.run([BINARY] + list(arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True)
    return done.returncode, done.stdout, done.stderr


def folder():
    return tempfile.TemporaryDirectory(prefix="subpixel-python.")


def small_capture():
    vertices = b"".join(struct.pack("<3f4bHH", i % 2, i // 2, -2, 0, 0, 127, 0, 0, 65535) for i in range(4))
    moved = spcap.IDENTITY[:12] + (3.0, 0.0, 0.0, 1.0)
    more = b"".join(struct.pack("<2f4B", i, 0.5, 255, 0, i, 9) for i in range(4))
    leaf = spcap.Material(
        name="leaf \u2013 green", roughness=0.75, base_colour=(0.25, 0.5, 0.125, 1.0), base_colour_texture=0,
        normal_texture=1,
        alpha_mode=spcap.AlphaMode.TEST, alpha_cutoff=0.25, emissive=(0.0, 1.5, 20.0), two_sided=True,
        normal_scale=-0.5, unlit=True, base_colour_uv=spcap.UvMapping(set=1, matrix=(2.0, 0.0, 0.25, 0.0, 3.0, -1.0)))
    indexed = spcap.Draw(
        name="indexed", material=1, position=spcap.VertexStream(buffer=0, stride=20),
        normal=spcap.VertexStream(buffer=0, format=spcap.VertexFormat.SNORM8X4, offset=12, stride=20),
        uv=spcap.VertexStream(buffer=3, format=spcap.VertexFormat.UNORM16X2, offset=16, stride=20),
        index_type=spcap.IndexType.UINT16, index_buffer=1, index_offset=2, index_count=6, vertex_count=4,
        instance_buffer=2, instance_count=2, uv2=spcap.VertexStream(buffer=4, format=0, stride=12),
        colour=spcap.VertexStream(buffer=4, format=spcap.VertexFormat.UNORM8X4, offset=8, stride=12))
    plain = spcap.Draw(name="list", position=spcap.VertexStream(buffer=0, stride=20), index_count=3, base_vertex=1,
                       vertex_count=4, transform=moved)
    first = spcap.Frame(
        name="first", time_s=0.5, sky=(0.0, 0.5, 2.0), ambient=(0.25, 0.0, 0.0),
        projection=(1.0, 0, 0, 0, 0, -1.0, 0, 0, 0, 0, 0, -1.0, 0, 0, 0.125, 0), width=64,
        height=48, sun=spcap.DirectionalLight(), draws=[indexed, plain],
        point_lights=[spcap.PointLight(), spcap.PointLight(
            position=(1.0, 2.0, 3.0), range=7.0,
            cone=spcap.SpotCone(direction=(0.0, 0.0, -2.0), inner_cosine=0.875, outer_cosine=-0.25))])
    second = spcap.Frame(name="empty", clip_depth=spcap.ClipDepth.MINUS_ONE_TO_ONE, clip_y_up=True,
                         sky=(0.5, 0.25, 0.125), ambient=(0.0, 0.0, 1.0))
    return spcap.Capture(
        metadata=spcap.Metadata(title="Small", application="a test", tool="a recorder 1", licence="CC0-1.0 \u2013 dash",
                                metres_per_unit=0.25, notices=["ignored: decals", ""]),
        buffers=[spcap.Buffer(name="vertices", bytes=vertices),
                 spcap.Buffer(name="indices", bytes=struct.pack("<7H", 9, 0, 1, 2, 2, 1, 3)),
                 spcap.Buffer(name="placements", bytes=struct.pack("<32f", *(spcap.IDENTITY + moved))),
                 spcap.Buffer(name="vertices again", bytes=vertices), spcap.Buffer(name="more", bytes=more),
                 spcap.Buffer(name="nothing"), spcap.Buffer(name="many", bytes=b"compress me " * 200)],
        textures=[spcap.Texture(name="dots", srgb=True, width=2, height=1, bytes=b"\x4d" * 8,
                                sampler=spcap.Sampler(wrap_u=1, wrap_v=2, magnify=1, minify=1, mip=2)),
                  spcap.Texture(name="file", encoding=spcap.TextureEncoding.IMAGE_FILE, bytes=b"\3" * 5)],
        materials=[spcap.Material(name="plain", roughness=0.25), leaf], frames=[first, second])


def strip_capture():
    """A strip, a fan and a strip with restarts, of packed formats, levels of means: what version 3 brought."""
    capture = small_capture()
    capture.textures[0].sampler.mip = spcap.MipFilter.NEAREST_OF_MEANS
    capture.textures[1].sampler.mip = spcap.MipFilter.LINEAR_OF_MEANS
    capture.buffers.append(spcap.Buffer(name="packed", bytes=struct.pack(
        "<6sbbII2xbbhhI", struct.pack("<3e", 1, 0, 0), 127, 127, 511 << 10 | 513 << 20 | 1 << 30,
        15 << 6 | (15 << 6 | 1 << 5) << 11 | 14 << 5 << 22, 127, 0, 32767, -32768, 1023 | 341 << 20 | 3 << 30)))
    capture.buffers.append(spcap.Buffer(name="bytes", bytes=bytes([0, 1, 2, 3, 255, 255, 0, 1, 2, 255, 1, 2, 3])))
    packed, indices = len(capture.buffers) - 2, len(capture.buffers) - 1

    def value(vertex_format, offset):
        return spcap.VertexStream(buffer=packed, format=vertex_format, offset=offset, stride=0)

    form, topology = spcap.VertexFormat, spcap.Topology
    common = {"vertex_count": 4, "index_type": spcap.IndexType.UINT8, "index_buffer": indices}
    position = spcap.VertexStream(buffer=0, stride=20)
    capture.frames[0].draws = [
        spcap.Draw(name="strip", position=position, topology=topology.TRIANGLE_STRIP, index_count=4,
                   normal=value(form.OCTAHEDRAL_SNORM8, 6), **common),
        spcap.Draw(name="fan", position=position, topology=topology.TRIANGLE_FAN, index_count=3, index_offset=0,
                   normal=value(form.SNORM10X3_2, 8), colour=value(form.FLOAT11X2_10, 12),
                   **dict(common, base_vertex=1)),
        spcap.Draw(name="restarted", position=position, topology=topology.TRIANGLE_STRIP, restart=True, index_offset=4,
                   index_count=9, normal=value(form.FLOAT16X3, 0), uv=value(form.SNORM16X2, 20),
                   colour=value(form.UNORM10X3_2, 24), **common)]
    return capture


def plain_capture():
    """The same with nothing that is new in version 2."""
    capture = small_capture()
    capture.metadata.notices = []
    capture.textures[0].sampler = spcap.Sampler()
    leaf = capture.materials[1]
    leaf.normal_scale, leaf.unlit, leaf.base_colour_uv = 1.0, False, spcap.UvMapping()
    frame = capture.frames[0]
    frame.point_lights[1].cone = None
    frame.draws[0].uv2 = frame.draws[0].colour = spcap.VertexStream()
    frame.draws[0].colour = spcap.VertexStream()
    return capture
