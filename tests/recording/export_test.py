"""Which draws are a frame's main view and what of a shader counts, without RenderDoc: by actions and states made up."""
import os
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "python"))

from subpixel_renderdoc import camera, export, geometry, glsl, record  # noqa: E402
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
        work._look = lambda entries: None
        entries = work._main_view()
        return work.depth_target, [e.action.eventId for e in entries], replay.asked

    SIZES = {"scene": (1280, 720), "mirror": (1280, 720), "shadow": (4096, 4096), "icon": (64, 64)}

    def test_is_the_target_that_most_triangles_are_written_to_depth_of(self):
        # More corners go to the mirror, whose particles write no depth.
        draws = [("mirror", 9000, 1, False, "list"), ("mirror", 300, 1, True, "list"), ("scene", 3000, 1, True, "list")]
        self.assertEqual(self.chosen(draws, self.SIZES)[:2], ("scene", [3]))

    def test_instances_and_strips_count_by_their_triangles(self):
        draws = [("mirror", 1500, 1, True, "list"), ("scene", 102, 6, True, "strip")]
        self.assertEqual(self.chosen(draws, self.SIZES)[0], "scene")

    def test_small_targets_are_none(self):
        draws = [("icon", 90000, 1, True, "list"), ("scene", 300, 1, True, "list")]
        self.assertEqual(self.chosen(draws, self.SIZES)[0], "scene")

    def test_states_are_asked_only_where_they_may_decide(self):
        draws = [("scene", 9000, 1, True, "list"), ("mirror", 2000, 1, True, "list")]
        self.assertEqual(self.chosen(draws, self.SIZES)[2], [1])
        self.assertEqual(self.chosen(draws[:1], self.SIZES)[2], [])

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


class Shaders(unittest.TestCase):
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
