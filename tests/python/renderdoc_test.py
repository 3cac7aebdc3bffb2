"""What python/subpixel_renderdoc works out by itself; replays are in tests/recording."""
import math
import os
import struct
import subprocess
import sys
import unittest

from capture_fixture import ROOT, folder, spcap
from subpixel_renderdoc import camera, depth, geometry, linear, textures, topology
from subpixel_renderdoc.builder import Builder
from subpixel_renderdoc.export import Notices, Options


def turned(angle, axis):
    c, s = math.cos(angle), math.sin(angle)
    return {"x": ((1, 0, 0), (0, c, -s), (0, s, c)), "y": ((c, 0, s), (0, 1, 0), (-s, 0, c))}[axis]


def rigid(angle_x, angle_y, move):
    a, b = turned(angle_x, "x"), turned(angle_y, "y")
    rows = [tuple(sum(a[r][k] * b[k][c] for k in range(3)) for c in range(3)) for r in range(3)]
    return tuple(row + (m,) for row, m in zip(rows, move))


VIEW = rigid(0.4, 0.7, (1.0, -2.0, -9.0))
MODEL = tuple(tuple(2.5 * x for x in row[:3]) + (row[3],) for row in rigid(1.1, -0.3, (3.0, 0.5, 2.0)))
LAST = ((0.0, 0.0, 0.0, 1.0),)


class Topologies(unittest.TestCase):
    def test_lists_strips_and_fans(self):
        self.assertEqual(list(topology.triangles("list", 8)), [0, 1, 2, 3, 4, 5])
        self.assertEqual(topology.triangles("strip", 5), [0, 1, 2, 2, 1, 3, 2, 3, 4])
        self.assertEqual(topology.triangles("fan", 4), [0, 1, 2, 0, 2, 3])
        for kind in ("list", "strip", "fan"):
            self.assertEqual(list(topology.triangles(kind, 2)), [])

    def test_a_restart_begins_anew_with_the_same_winding(self):
        self.assertEqual(topology.triangles("strip", 8, [4]), [0, 1, 2, 2, 1, 3, 5, 6, 7])
        self.assertEqual(topology.triangles("strip", 4, [0]), [1, 2, 3])
        self.assertEqual(topology.triangles("fan", 3, [1]), [])


class Cameras(unittest.TestCase):
    def matrices(self, y_up=True):
        made = camera.Projection(1.2, 1.7 if y_up else -1.7, 0.1, -0.05, 1.02, -0.4)
        view_projection = linear.multiplied(made.rows(), VIEW + LAST)
        return made, view_projection, linear.multiplied(view_projection, MODEL + LAST)

    def test_the_projection_shows_in_every_matrix_that_ends_with_it(self):
        for y_up in (True, False):
            made, view_projection, whole = self.matrices(y_up)
            for matrix in (made.rows(), view_projection, whole):
                found = camera.projection_of(matrix, y_up)
                for a, b in zip(found.numbers(), made.numbers()):
                    self.assertAlmostEqual(a, b, places=9)

    def test_other_matrices_have_none(self):
        stretched = linear.multiplied(self.matrices()[1], ((3.0, 0, 0, 0), (0, 1.0, 0, 0), (0, 0, 1.0, 0)) + LAST)
        for matrix in (VIEW + LAST, stretched, ((0.0,) * 4,) * 4, ((float("nan"),) * 4,) * 4):
            self.assertIsNone(camera.projection_of(matrix, True))

    def test_the_view_is_a_rotation(self):
        made, view_projection, whole = self.matrices()
        for got, expected in zip(camera.rigid_view(made.view_rows(view_projection)), VIEW):
            for a, b in zip(got, expected):
                self.assertAlmostEqual(a, b, places=9)
        mirrored = tuple((-row[0],) + row[1:] for row in VIEW)
        self.assertGreater(linear.determinant(camera.rigid_view(mirrored)), 0)
        self.assertIsNone(camera.rigid_view(((2.0, 0, 0, 0), (0, 1.0, 0, 0), (0, 0, 1.0, 0))))

    def test_world_and_clip_are_inverse(self):
        made = camera.Camera(self.matrices()[0], VIEW)
        for point in ((0.0, 0.0, 0.0), (3.0, -2.0, 1.0)):
            for a, b in zip(made.world(made.clip(point)), point):
                self.assertAlmostEqual(a, b, places=9)

    def test_most_triangles_decide(self):
        first, second = self.matrices()[0], camera.Projection(3.0, 3.0, 0.0, 0.0, 1.0, -1.0)
        self.assertTrue(camera.dominant([(first, 5.0), (second, 8.0), (first, 5.0)]).is_near(first))
        self.assertIsNone(camera.dominant([]))


class Maps(unittest.TestCase):
    def setUp(self):
        self.camera = camera.Camera(camera.Projection(1.2, 1.7, 0.0, 0.0, 1.02, -0.4), VIEW)
        self.points = [(math.sin(i), math.cos(2 * i), 0.3 * math.sin(5 * i)) for i in range(20)]

    def clips(self, points, rows=MODEL):
        # As a vertex shader's outputs: 32 bits.
        return [struct.unpack("<4f", struct.pack("<4f", *self.camera.clip(linear.apply(rows, p)))) for p in points]

    def test_a_placement_is_found(self):
        rows = geometry.world_map(self.points, self.clips(self.points), self.camera, 1080)
        for got, expected in zip(rows, MODEL):
            for a, b in zip(got, expected):
                self.assertAlmostEqual(a, b, places=4)

    def test_a_plane_keeps_its_scale_across(self):
        flat = [(p[0], p[1], 0.25) for p in self.points]
        rows = geometry.world_map(flat, self.clips(flat), self.camera, 1080)
        self.assertAlmostEqual(abs(linear.determinant(rows)), 2.5 ** 3, places=2)

    def test_skinned_vertices_have_none(self):
        bent = self.clips(self.points[:10]) + self.clips(self.points[10:], VIEW)
        self.assertIsNone(geometry.world_map(self.points, bent, self.camera, 1080))
        self.assertIsNone(geometry.clip_map(self.points, bent))
        line = [(float(i), 0.0, 0.0) for i in range(20)]
        self.assertIsNone(geometry.world_map(line, self.clips(line), self.camera, 1080))

    def test_normals_of_a_quad(self):
        corners = [0, 1, 2, 2, 1, 3]
        normals = geometry.smooth_normals({0: (0, 0, 0), 1: (1, 0, 0), 2: (0, 1, 0), 3: (1, 1, 0)}, corners)
        self.assertEqual(set(normals.values()), {(0.0, 0.0, 1.0)})


class Textures(unittest.TestCase):
    class Described:
        cubemap, depth, arraysize = False, 1, 1

    def choose(self, *names, **options):
        bound = [(name, slot, slot) for slot, name in enumerate(names)]
        held = dict((str(slot), self.Described()) for slot in range(len(names)))
        chosen = textures.choose(bound, held, options.get("mapping", {}), lambda resource: False)
        return dict((role, entry[0]) for role, entry in chosen.items())

    def test_names_decide_and_then_slots(self):
        self.assertEqual(self.choose("shadow_map", "u_normalMap", "albedoTex", "emissiveMap"),
                         {"normal": "u_normalMap", "base_colour": "albedoTex", "emissive": "emissiveMap"})
        self.assertEqual(self.choose("lightmap_tex", "something", "other"), {"base_colour": "something"})
        self.assertEqual(self.choose("shadowMap"), {})
        self.assertEqual(self.choose(), {})

    def test_a_mapping_is_asked_first(self):
        self.assertEqual(self.choose("albedo", "grass", mapping={"base_colour": ["^gr"]}), {"base_colour": "grass"})
        self.assertEqual(self.choose("albedo", "grass", mapping={"base_colour": [1]}), {"base_colour": "grass"})
        self.assertEqual(self.choose("albedo", "grass", mapping={"base_colour": []}), {})

    def test_cutoffs(self):
        known = {"settings.x": 0.0, "on": 1, "off": 0}
        for source, expected in (
                ("void main() { }", (False, None)),
                ("if (c.a < 0.3) discard;", (True, 0.3)),
                ("if (object.settings.x > 0 && c.a < 0.5) discard;", (False, None)),
                ("if (off && c.a < 0.5) discard;", (False, None)),
                ("if (on && c.a < 0.5) discard;", (True, 0.5)),
                ("if (off || c.a < 0.5) discard;", (True, 0.5)),
                ("discard;", (True, None)),
                ("clip(c.a - 0.25f);", (True, 0.25))):
            self.assertEqual(textures.cutoff(source, known), expected, source)

    def test_cutoffs_of_disassembled_modules(self):
        source = """SPIR-V 1.0 module
          int* _29 = &uniforms.alphaTest;
          int _30 = *_29;
          bool _32 = _30 != 0;
          if(_32) {
            float* _38 = &diffuse.w;
            float _39 = *_38;
            bool _41 = _39 <= 0.4000;
          }
          bool _42 = Phi(_32, _41);
          if(_42) {
            Kill();
          }"""
        self.assertEqual(textures.cutoff(source, {"uniforms.alphaTest": 0}), (False, None))
        self.assertEqual(textures.cutoff(source, {"uniforms.alphaTest": 1}), (True, 0.4))
        self.assertEqual(textures.cutoff(source, {}), (True, 0.4))

    def test_texels(self):
        self.assertEqual(textures._rgba(b"\1\2\3\4\5\6", 3, False), b"\1\2\3\xff\4\5\6\xff")
        self.assertEqual(textures._rgba(b"\1\2\3\4", 4, True), b"\3\2\1\4")
        self.assertEqual(textures._rgba(b"\1\2", 2, False), b"\1\2\0\xff")
        self.assertEqual(textures._rgba(b"\7", 1, False), b"\7\7\7\xff")

    def test_packed_texels(self):
        self.assertEqual(textures._unpacked([0xF800, 0x07E0, 0x001F], (5, 6, 5, 0), False),
                         b"\xff\0\0\xff\0\xff\0\xff\0\0\xff\xff")
        self.assertEqual(textures._unpacked([0xF800, 0x0001], (5, 5, 5, 1), False), b"\xff\0\0\0\0\0\0\xff")
        self.assertEqual(textures._unpacked([0x7C00, 0x8000], (5, 5, 5, 1), True), b"\xff\0\0\0\0\0\0\xff")

    def test_dds_files(self):
        data = textures._dds(5, 4, (8, b"DXT1", 0), False, b"x" * 99)
        self.assertEqual((len(data), data[:4], data[84:88]), (128 + 16, b"DDS ", b"DXT1"))
        self.assertEqual(struct.unpack_from("<I", textures._dds(4, 4, (16, b"DX10", 98), False, b"x" * 16), 128)[0], 98)


class Whole(unittest.TestCase):
    def test_equal_resources_are_held_once(self):
        builder = Builder()
        self.assertEqual([builder.buffer(b"a"), builder.buffer(b"b"), builder.buffer(b"a")], [0, 1, 0])
        self.assertEqual([builder.material(name="x"), builder.material(name="y"), builder.material(two_sided=True)],
                         [0, 0, 1])

    def test_notices_have_each_draw(self):
        notices = Notices()
        notices.draw("left out: blended", "event 3")
        notices.draw("left out: blended", "event 4")
        self.assertEqual(notices.lines(2), ["frame 2: left out: blended (2 draws): event 3, event 4"])

    def test_options_are_checked(self):
        with self.assertRaises(TypeError):
            Options(evnets=None)

    def test_depths_are_compared(self):
        counts, picture = depth.compare([[1.0, 2.0, 0.0, 3.0, 0.0]], [[1.004, 2.1, 4.0, 0.0, 0.0]])
        self.assertEqual(counts, {"agree": 1, "differ": 1, "only_capture": 1, "only_application": 1, "neither": 1})
        self.assertEqual(len(picture[0]), 5)

    def test_a_capture_of_distances(self):
        capture = spcap.Capture(
            buffers=[spcap.Buffer(bytes=struct.pack("<9f", 0, 0, -2, 1, 0, -4, 0, 1, -8))],
            materials=[spcap.Material()],
            frames=[spcap.Frame(draws=[spcap.Draw(position=spcap.VertexStream(buffer=0, stride=12), index_count=3,
                                                  vertex_count=3)])])
        made, furthest = depth.distance_capture(capture, 0)
        self.assertEqual(furthest, 8.0)
        self.assertEqual([tuple(c) for c in spcap.stream_values(made, made.frames[0].draws[0].colour, 3)],
                         [(0.25, 0.25, 0.25, 1.0), (0.5, 0.5, 0.5, 1.0), (1.0,) * 4])
        self.assertTrue(spcap.encode(made))

    def test_alphas_that_are_tested_stay_with_the_distances(self):
        # A triangle that reaches behind the eye is cut there: two corners of the cut lie half way to the third.
        for depths, wanted in (((-2, -4, -8), [0.5, 0.25, 1.0]), ((-2, -4, 4), [0.5, 0.25, 0.625, 0.5, 0.625, 0.667])):
            data = struct.pack("<9f12f", 0, 0, depths[0], 1, 0, depths[1], 0, 1, depths[2], 1, 1, 1, 0.5, 1, 1, 1, 0.25,
                               1, 1, 1, 1)
            colour = spcap.VertexStream(buffer=0, format=spcap.VertexFormat.FLOAT32X4, offset=36, stride=16)
            draw = spcap.Draw(position=spcap.VertexStream(buffer=0, stride=12), colour=colour, index_count=3, vertex_count=3)
            capture = spcap.Capture(
                buffers=[spcap.Buffer(bytes=data)], textures=[spcap.Texture(width=1, height=1, bytes=b"\xff" * 4)],
                materials=[spcap.Material(alpha_mode=spcap.AlphaMode.TEST, base_colour_texture=0)],
                frames=[spcap.Frame(draws=[draw])])
            made, _ = depth.distance_capture(capture, 0)
            copy = made.frames[0].draws[0]
            alphas = [c[3] for c in spcap.stream_values(made, copy.colour, copy.vertex_count)]
            self.assertEqual([round(float(a), 3) for a in alphas], wanted)

    def test_errors_are_one_line(self):
        with folder() as path:
            mapping = os.path.join(path, "textures.json")
            with open(mapping, "w") as file:
                file.write('{"colour": []}')
            done = subprocess.run(
                [sys.executable, "-m", "subpixel_renderdoc", "--textures", mapping, "x.rdc", os.path.join(path, "y")],
                stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True,
                env=dict(os.environ, PYTHONPATH=os.path.join(ROOT, "python")))
            self.assertEqual(done.returncode, 3)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertEqual(os.listdir(path), ["textures.json"])


if __name__ == "__main__":
    unittest.main()
