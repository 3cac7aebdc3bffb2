"""Which draws are a frame's main view and what of a shader counts, without RenderDoc: by actions and states made up."""
import os
import random
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "python"))

import subpixel_capture as spcap  # noqa: E402
from subpixel_renderdoc import camera, depth, export, geometry, glsl, record, textures  # noqa: E402
from subpixel_renderdoc.builder import Builder  # noqa: E402
from subpixel_renderdoc.replay import DrawState  # noqa: E402


class Made:
    def __init__(self, **values):
        self.__dict__.update(values)


class MadeReplay:
    """Draws of (target, corners, instances, whether depth is written, topology), a colour target each."""

    rd, null = None, "none"

    def __init__(self, draws, sizes):
        self.asked = []
        self.made = [Made(eventId=number + 1, outputs=["colour"], depthOut=target, numIndices=corners,
                          numInstances=instances, depth_write=writes, topology=topology)
                     for number, (target, corners, instances, writes, topology) in enumerate(draws)]
        self.textures = dict((key, Made(width=width, height=height)) for key, (width, height) in sizes.items())

    def draws(self):
        return self.made

    def name(self, action):
        return "draw()"

    def go_to(self, action):
        self.current = action
        self.asked.append(action.eventId)

    def state(self):
        state = DrawState()
        state.depth_write, state.topology = self.current.depth_write, self.current.topology
        return state


class MainView(unittest.TestCase):
    def chosen(self, draws, sizes, **options):
        replay = MadeReplay(draws, sizes)
        work = export.FrameExport(replay, Builder(), export.Options(**options))
        work._look = lambda entries: self.look(replay, work, entries)
        entries = work._main_view()
        self.notices = list(work.notices.draws)
        return work.depth_target, [e.action.eventId for e in entries], replay.asked

    @staticmethod
    def look(replay, work, entries):
        for entry in entries:
            replay.go_to(entry.action)
            entry.state = replay.state()
            work.notices.draw("looked at " + entry.action.depthOut, entry.name)

    SIZES = {"scene": (1280, 720), "mirror": (1280, 720), "shadow": (4096, 4096), "icon": (64, 64)}

    def test_is_the_target_that_most_triangles_are_written_to_depth_of(self):
        # More corners go to the mirror, whose particles write no depth.
        draws = [("mirror", 9000, 1, False, "list"), ("mirror", 300, 1, True, "list"), ("scene", 3000, 1, True, "list")]
        self.assertEqual(self.chosen(draws, self.SIZES), ("scene", [3], [1, 2, 3]))  # a replay each
        self.assertEqual(self.notices, ["looked at scene"])
        draws = [("scene", 9000, 1, False, "list"), ("scene", 3000, 1, True, "list"), ("mirror", 2700, 1, True, "list")]
        self.assertEqual(self.chosen(draws, self.SIZES), ("scene", [1, 2], [1, 2, 3]))
        self.assertEqual(self.notices, ["looked at scene"])

    def test_instances_and_strips_count_by_their_triangles(self):
        draws = [("mirror", 1500, 1, True, "list"), ("scene", 102, 6, True, "strip")]
        self.assertEqual(self.chosen(draws, self.SIZES)[0], "scene")

    def test_small_targets_are_none(self):
        draws = [("icon", 90000, 1, True, "list"), ("scene", 300, 1, True, "list")]
        self.assertEqual(self.chosen(draws, self.SIZES)[0], "scene")

    def test_draws_are_looked_at_only_where_they_may_decide(self):
        draws = [("scene", 9000, 1, True, "list"), ("mirror", 2000, 1, True, "list")]
        self.assertEqual(self.chosen(draws, self.SIZES)[2], [1])
        self.assertEqual(self.chosen(draws[:1], self.SIZES)[2], [1])

    def test_a_target_by_its_number_is_taken_whatever_it_holds(self):
        draws = [("id:1", 9000, 1, True, "list"), ("id:2", 30, 1, True, "list")]
        self.assertEqual(self.chosen(draws, {}, target="2")[:2], ("id:2", [2]))


class Scene(unittest.TestCase):
    def test_skies_and_pictures_on_the_screen_are_at_no_place(self):
        projection = camera.Projection(1.0, 1.0, 0.0, 0.0, 1.002, -2.002)
        places = [(0.0, 0.0, 1.002 * w - 2.002, w) for w in (2.0, 5.0, 9.0)]
        self.assertIsNone(geometry.off_scene(places, projection, False, True))
        sky = [(x, 0.0, 1.0, 1.0) for x in (-1.0, 3.0)]
        self.assertIn("far plane", geometry.off_scene(sky, projection, False, True))
        sky = [(0.0, 0.0, 0.0, w) for w in (1.0, 3.0)]
        self.assertIn("far plane", geometry.off_scene(sky, projection, True, False))
        self.assertIn("screen", geometry.off_scene([(x, 0.0, 0.2, 1.0) for x in (-1.0, 3.0)], projection, False, True))
        # A weapon before all else has a depth range of its own and stands where its w says.
        self.assertIsNone(geometry.off_scene([(0.0, 0.0, 0.0, w) for w in (1.0, 3.0)], projection, False, True))

    def test_equal_projections_are_counted_together(self):
        a, b = camera.Projection(1, 1, 0, 0, 1, -1), camera.Projection(2, 1, 0, 0, 1, -1)
        held = camera.merged([(a, 1.0), (b, 1.5), (a, 1.0)])
        self.assertEqual([(p.a, w) for p, w in held], [(1, 2.0), (2, 1.5)])


def image(*texels):
    """A texture of one row, clamped."""
    return spcap.Texture(width=len(texels), height=1, bytes=bytes(v for texel in texels for v in texel), srgb=True,
                         sampler=spcap.Sampler(wrap_u=1, wrap_v=1))


@unittest.skipIf(export.numpy is None, "no numpy")
class Layers(unittest.TestCase):
    """One triangle that fills most of a view of 64x64 pixels, drawn several times."""

    CORNERS = ((-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0))

    def setUp(self):
        self.work = export.FrameExport(Made(rd=None, null="none"), Builder(), export.Options())
        self.work.viewport, self.work.typical = (0, 0, 64, 64, 0, 1), DrawState()
        self.entries = []

    def draw(self, role, texture=None, colours=((1.0,) * 4,) * 3, blend=None, turn=0):
        number = len(self.entries)
        entry = export.Entry(number, Made(eventId=number), DrawState(), "event {}".format(number))
        entry.role, entry.attributes, entry.outputs = role, [], [("p", 4, 0), ("colour", 4, 16), ("uv", 2, 32)]
        entry.state.blends, entry.state.blend = blend is not None, blend
        entry.mesh = geometry.Mesh()
        entry.mesh.count, entry.mesh.post = 3, {0: 0, 1: 1, 2: 2}
        entry.mesh.corners = [turn, (turn + 1) % 3, (turn + 2) % 3]
        entry.mesh.outputs = b"".join(struct.pack("<10f", x, y, 0.5, 1.0, *colour, (x + 1) / 2, (y + 1) / 2)
                                      for (x, y), colour in zip(self.CORNERS, colours)), 40
        if texture is not None:
            self.work.builder.capture.textures.append(texture)
            entry.textures["base_colour"] = (len(self.work.builder.capture.textures) - 1, None)
        self.entries.append(entry)
        return entry

    def composed(self):
        """(entries that are drawn as they are, a function from a place in the triangle to its colour)."""
        frame = spcap.Frame()
        left = self.work._layers(self.entries)
        view = camera.Camera(camera.Projection(1, 1, 0, 0, 1, -0.5), ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0)))
        self.work._composed(view, frame)
        if not frame.draws:
            return left, None
        made, capture = frame.draws[0], self.work.builder.capture
        texture = capture.textures[capture.materials[made.material].base_colour_texture]
        places = [tuple(map(float, p)) for p in spcap.stream_values(capture, made.position, 3)]
        uvs = [tuple(map(float, p)) for p in spcap.stream_values(capture, made.uv, 3)]

        def colour(x, y):
            at = {self.CORNERS[0]: 1 - x - y, self.CORNERS[1]: x, self.CORNERS[2]: y}
            weights = [at[place[:2]] for place in places]
            u, v = (sum(w * uv[i] for w, uv in zip(weights, uvs)) for i in (0, 1))
            begin = 4 * (int(v * texture.height) * texture.width + int(u * texture.width))
            return tuple(texture.bytes[begin:begin + 3])
        return left, colour

    def expect(self, colour, place, wanted):
        for got, want in zip(colour(*place), wanted):
            self.assertLessEqual(abs(got - want), 5, (place, colour(*place), wanted))

    def test_what_blended_layers_leave_together_is_composed(self):
        left_red = [(1, 1, 1, a) for a in (1.0, 0.0, 1.0)]
        self.draw("prepass")
        self.draw("layer", image((200, 0, 0, 255)), left_red, ("SrcAlpha", "One"), turn=1)
        right_blue = [(1, 1, 1, 1 - c[3]) for c in left_red]
        self.draw("layer", image((0, 0, 200, 255)), right_blue, ("SrcAlpha", "One"), turn=2)
        # A decal: opaque where u is above one half.
        self.draw("layer", image(*[(0, 240, 0, 0)] * 8, *[(0, 240, 0, 255)] * 8), blend=("SrcAlpha", "InvSrcAlpha"))
        left, colour = self.composed()
        self.assertEqual(left, [])
        for x, y in ((0.1, 0.1), (0.4, 0.2), (0.2, 0.6), (0.4, 0.55)):
            self.expect(colour, (x, y), (200 * (1 - x), 0, 200 * x))
        for x, y in ((0.6, 0.1), (0.8, 0.1), (0.6, 0.3)):
            self.expect(colour, (x, y), (0, 240, 0))

    def test_a_decal_is_composed_over_a_surface_and_light_is_not(self):
        self.draw("surface", image((100, 80, 60, 255)))
        self.draw("layer", image((250, 250, 250, 255)), blend=("One", "One"))
        left, colour = self.composed()
        self.assertEqual((left, colour), (self.entries[:1], None))
        self.draw("layer", image((0, 0, 200, 128)), blend=("SrcAlpha", "InvSrcAlpha"))
        left, colour = self.composed()
        self.assertEqual(left, [])
        self.expect(colour, (0.3, 0.3), (50, 40, 130))

    def test_one_opaque_draw_over_depth_alone_stays_itself_and_the_same_again_is_light(self):
        self.draw("prepass")
        self.draw("layer", image((9, 9, 9, 255)))
        again = self.draw("layer", blend=("One", "One"))
        again.textures = self.entries[1].textures
        left, colour = self.composed()
        self.assertEqual((left, colour), (self.entries[1:2], None))

    def test_alpha_tests_of_the_depth_pass_cut_the_colour(self):
        bed = self.draw("prepass")
        bed.discards, bed.cutoff = True, 0.3
        colour = self.draw("layer", image((9, 9, 9, 100)))
        self.assertEqual(self.composed(), ([colour], None))
        self.assertEqual((colour.discards, colour.cutoff), (True, 0.3))

    def test_triangles_behind_the_eye_do_not_swell_the_texture(self):
        wide = export.bake.Image(textures.texels(image(*[(1, 2, 3, 255)] * 64)).repeat(64, axis=0), (1, 1), False)
        layer = (0, ((0, 0), (1, 0), (0, 1)), ((1.0,) * 4,) * 3, None)
        cells = [export.bake.Cell(((0, 0, 0, -1), (1, 0, 0, 2), (0, 1, 0, 3)), True, [layer])] * 200
        held, export.bake.HIGHEST = export.bake.HIGHEST, 256
        try:
            width, height, data, uvs = export.bake.bake(cells, [wide], (64, 64), False)
        finally:
            export.bake.HIGHEST = held
        self.assertLessEqual(height, 256)
        self.assertEqual((len(data), uvs.shape), (4 * width * height, (200, 3, 2)))

    def test_without_numpy_the_strongest_layer_shows(self):
        self.draw("prepass")
        for weight in (0.3, 0.6, 0.1):
            self.draw("layer", image((int(200 * weight),) * 3 + (255,)), [(1, 1, 1, weight)] * 3, ("SrcAlpha", "One"))
        held, export.numpy = export.numpy, None
        try:
            self.assertEqual(self.composed(), (self.entries[2:3], None))
        finally:
            export.numpy = held

    def test_textures_that_nothing_shows_are_dropped(self):
        builder = Builder()
        for value in range(3):
            builder.texture(image((value,) * 4))
        builder.material(base_colour_texture=2, emissive_texture=0)
        builder.drop_unused_textures()
        self.assertEqual([t.bytes[0] for t in builder.capture.textures], [0, 2])
        material = builder.capture.materials[0]
        self.assertEqual((material.base_colour_texture, material.emissive_texture), (1, 0))

    def test_texels_of_blocks(self):
        random.seed(7)
        for name, code, size in (("BC1", b"DXT1", 8), ("BC2", b"DXT3", 16), ("BC3", b"DXT5", 16), ("BC4", b"ATI1", 8),
                                 ("BC5", b"ATI2", 16)):
            data = bytes(random.randrange(256) for _ in range(256 * size))
            texture = spcap.Texture(encoding=spcap.TextureEncoding.IMAGE_FILE,
                                    bytes=textures._dds(64, 64, (size, code, 0), False, data))
            texels = textures.texels(texture)
            for block in range(256):
                held = data[size * block:size * (block + 1)]
                for i in range(16):
                    got = texels[block // 16 * 4 + i // 4, block % 16 * 4 + i % 4]
                    self.assertEqual(tuple(got), block_texel(name, held, i), (name, block, i))

    def test_texels_of_bptc_are_those_of_another_decoder(self):
        random.seed(8)
        data = bytearray(random.randrange(256) for _ in range(256 * 16))
        for block in range(256):  # of all modes alike
            data[16 * block] = data[16 * block] & ~((2 << block % 8) - 1) & 255 | 1 << block % 8
        texture = spcap.Texture(encoding=spcap.TextureEncoding.IMAGE_FILE,
                                bytes=textures._dds(64, 64, (16, b"DX10", 98), False, data))
        # CRC-32 of what OpenImageIO 2.4 reads from the same file.
        self.assertEqual(zlib.crc32(textures.texels(texture).tobytes()), BPTC_CRC)


class MadeShader:
    """A fragment shader that reads "Texture" and "TextureNormal", of 2x2 texels of 8 bits."""

    class rd:
        ResourceFormatType = Made(Regular="regular")
        CompType = Made(UNorm="unorm", UNormSRGB="srgb")

        @staticmethod
        def Subresource(*place):
            return place

    def __init__(self, colours, normals):
        self.texels, self.controller = {"1": colours, "2": normals}, self
        form = Made(type="regular", compByteWidth=1, compType="unorm", compCount=4, BGRAOrder=lambda: False)
        self.textures = dict((key, Made(width=2, height=2, format=form, cubemap=False, depth=1, arraysize=1))
                             for key in self.texels)

    def GetTextureData(self, resource, place):
        return self.texels[resource]

    def fragment_source(self):
        return "", "colour = texture(Texture, uv);"

    def fragment_constants(self):
        return {}

    def fragment_textures(self):
        return [("Texture", 0, "1"), ("TextureNormal", 1, "2")]

    def sampler(self, slot, name):
        return None


class NormalMaps(unittest.TestCase):
    def taken(self, colours, normals):
        work = export.FrameExport(MadeShader(colours, normals), Builder(), export.Options())
        work.target_ids = set()
        entries = [export.Entry(number, None, None, "draw {}".format(number)) for number in range(2)]
        for entry in entries:
            work._shading(entry)
        return [sorted(entry.textures) for entry in entries], work.notices.draws, work.builder.capture.textures

    def test_of_one_colour_are_none(self):
        # What Vulkan wants bound where Warzone has no normal map; both draws are told of.
        taken, notices, kept = self.taken(bytes(16), bytes(12) + bytes((0, 0, 0, 255)))
        self.assertEqual(taken, [["base_colour"]] * 2)  # a colour may well be one
        self.assertEqual(notices, {"left out: a normal map of one colour": ["draw 0", "draw 1"]})
        self.assertEqual([texture.name for texture in kept], ["Texture 1"])

    def test_of_two_are_taken(self):
        taken, notices, _ = self.taken(bytes(16), bytes(12) + bytes((0, 0, 1, 0)))
        self.assertEqual((taken, notices), ([["base_colour", "normal"]] * 2, {}))


@unittest.skipUnless("SUBPIXEL" in os.environ, "SUBPIXEL does not name the program")
class Replayed(unittest.TestCase):
    def test_normals_of_two_channels_have_a_third(self):
        capture = spcap.Capture(metadata=spcap.Metadata(title="a normal map"))
        block = bytes((200, 200, 0, 0, 0, 0, 0, 0, 100, 100, 0, 0, 0, 0, 0, 0))
        capture.textures.append(spcap.Texture(encoding=spcap.TextureEncoding.IMAGE_FILE,
                                              bytes=textures._dds(4, 4, (16, b"ATI2", 0), False, block)))
        capture.materials.append(spcap.Material(unlit=True, two_sided=True, base_colour_texture=0))
        capture.buffers.append(spcap.Buffer(bytes=struct.pack("<9f", -9, -9, -2, 9, -9, -2, 0, 9, -2)))
        capture.frames.append(spcap.Frame(
            view=spcap.IDENTITY, projection=(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1.1, -1, 0, 0, -0.21, 0), width=16,
            height=16, clip_depth=spcap.ClipDepth.ZERO_TO_ONE))
        capture.frames[0].draws.append(spcap.Draw(
            name="all", material=0, vertex_count=3, index_count=3,
            position=spcap.VertexStream(buffer=0, format=spcap.VertexFormat.FLOAT32X3, stride=12)))
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "normals.spcap")
            spcap.write(capture, path)
            subprocess.run([os.environ["SUBPIXEL"], "replay", path, "--techniques", "noaa", "--reference-samples", "0",
                            "--repeat", "1", "--out", folder], check=True, stdout=subprocess.DEVNULL)
            exr = [os.path.join(at, name) for at, _, names in os.walk(folder) for name in names
                   if name.endswith("_noaa.exr")]
            found = [depth.read_exr(exr[0], (channel,))[2][8][8] for channel in "RGB"]
        x, y = 200 / 255, 100 / 255
        wanted = (x, y, 0.5 + 0.5 * (1 - (2 * x - 1) ** 2 - (2 * y - 1) ** 2) ** 0.5)
        for a, b in zip(found, wanted):
            self.assertAlmostEqual(a, b, delta=0.01, msg="{} {}".format(found, wanted))


def block_texel(name, held, i):
    """One texel by the specification's formulas, in whole numbers."""
    def rounded(value, divisor):
        return int(value / divisor + 0.5)

    def channel(part):
        a, b = part[0], part[1]
        code = int.from_bytes(part[2:8], "little") >> 3 * i & 7
        if code < 2:
            return (a, b)[code]
        if a > b:
            return rounded((8 - code) * a + (code - 1) * b, 7)
        return (0, 255)[code - 6] if code > 5 else rounded((6 - code) * a + (code - 1) * b, 5)

    if name == "BC4":
        return (channel(held),) * 3 + (255,)
    if name == "BC5":
        return (channel(held), channel(held[8:]), 0, 255)
    first, second, codes = struct.unpack("<HHI", held[-8:])
    code = codes >> 2 * i & 3
    ends = [(word >> 11, word >> 5 & 63, word & 31) for word in (first, second)]
    three = name == "BC1" and first <= second
    weights, parts = [((1, 0), 1), ((0, 1), 1), ((1, 1), 2) if three else ((2, 1), 3), ((0, 0), 1) if three else
                      ((1, 2), 3)][code]
    colour = tuple(rounded(255 * (weights[0] * a + weights[1] * b), parts * most)
                   for a, b, most in zip(ends[0], ends[1], (31, 63, 31)))
    if name == "BC2":
        return colour + ((held[i // 2] >> 4 * (i % 2) & 15) * 17,)
    if name == "BC3":
        return colour + (channel(held),)
    return colour + (0 if three and code == 3 else 255,)


BPTC_CRC = 0xb13182a0


class Shaders(unittest.TestCase):
    def test_which_uv_a_texture_is_read_at(self):
        source = "vec4 a = texture2D(lightmap, uv2, 0.0) * texture(tex , input.uv1.xy, -0.5);"
        self.assertEqual(textures.read_at(source, "tex"), "uv1")
        self.assertEqual(textures.read_at(source, "lightmap"), "uv2")
        self.assertIsNone(textures.read_at("texture(tex, uv1 * 2.0)", "tex"))
        source = "  SampledImage<float2D> _17 = *tex;\n  float2 _21 = *uv1;\n  SampledImage<float2D> _26 = *mask;\n" \
                 "  float4 _23 = ImageSampleImplicitLod(_17, _21, Bias(0.0));\n"
        self.assertEqual(textures.read_at(source, "tex"), "uv1")
        self.assertIsNone(textures.read_at(source, "mask"))

    def test_lines_that_conditions_leave_out_do_not_count(self):
        for source, left in (("#define A\n#ifdef A\nx\n#else\ny\n#endif", "x"), ("#ifndef A\nx\n#else\ny\n#endif", "x"),
                             ("#if defined(B) || !(2 > 1)\nx\n#elif 0x10 == 16\ny\n#else\nz\n#endif", "y"),
                             ("#define N 3\n#if N >= 2 && defined N\nx\n#endif", "x"),
                             ("#if 0\n#if 1\nx\n#else\ny\n#endif\n#else\nz\n#endif", "z"),
                             ("#define A\n#undef A\n#ifdef A\nx\n#endif\ny", "y"),
                             ("/* discard;\n*/ x // discard", "x"), ("#if (1\nx\n#endif", "x"),
                             ("#if 1 / 0\nx\n#endif", "x"),
                             ("#endif\n#else\nx", "x")):
            lines = [line.strip() for line in glsl.active(source).split("\n")]
            self.assertEqual([line for line in lines if line and line[0] != "#"], [left], source)

    def test_constants_named_so_are_the_base_colour(self):
        constants = dict(("m_albedo." + c, v) for c, v in zip("xyzw", (0.5, 2.0, 0.25, 1.0)))
        self.assertEqual(export._base_colour(constants), (0.5, 1.0, 0.25))
        self.assertIsNone(export._base_colour({"sun_colour.x": 1.0, "sun_colour.z": 1.0, "albedo.x": 1.0}))

    def test_the_view_is_known_by_its_name(self):
        for name in ("u_view_matrix", "ViewMatrix", "camera_inverse_matrix", "worldToCamera"):
            self.assertTrue(export._names_view(name), name)
        for name in ("u_projection_view_matrix", "u_inverse_view_matrix", "camera_matrix", "ModelViewMatrix"):
            self.assertFalse(export._names_view(name), name)


class Recording(unittest.TestCase):
    def test_why_no_frame_came(self):
        self.assertIn("no interface", record._shown_by({}))
        self.assertIn("can't capture it: glBegin", record._shown_by({"OpenGL": (True, False, "glBegin")}))
        self.assertIn("shows no frames", record._shown_by({"Vulkan": (False, True, "")}))


if __name__ == "__main__":
    unittest.main()
