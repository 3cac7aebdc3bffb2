"""python/subpixel_capture against the program: each reads what the other wrote, and both refuse the same files."""
import json
import os
import struct
import unittest
import zlib
from unittest import mock

from capture_fixture import BINARY, folder, plain_capture, strip_capture, small_capture, spcap, subpixel
from subpixel_capture import codecs, layout, streams


def bytes_of(path):
    with open(path, "rb") as file:
        return file.read()


def write_bytes(path, data):
    with open(path, "wb") as file:
        file.write(data)


def refusal(data, **options):
    """The message with which the reader refuses the bytes; empty when it takes them."""
    try:
        spcap.decode(data, **options)
        return ""
    except spcap.CaptureError as error:
        return str(error)


class Forgery:
    """A file whose chunks can be changed and signed again."""

    def __init__(self, capture=None, level=0):
        self.data = bytearray(spcap.encode(capture or small_capture(), level))

    def chunk(self, kind, number=0):
        offset = 16
        while self.data[offset:offset + 8] != kind + struct.pack("<I", number):
            offset = layout.aligned(offset + 40 + struct.unpack_from("<Q", self.data, offset + 16)[0])
        return offset

    def set(self, letters, offset, *values):
        struct.pack_into("<" + letters, self.data, offset, *values)

    def sign(self, offset):
        stored = struct.unpack_from("<Q", self.data, offset + 16)[0]
        crc = zlib.crc32(self.data[offset + 40:offset + 40 + stored], zlib.crc32(self.data[offset:offset + 32]))
        self.set("Q", offset + 32, crc)

    def header(self, kind, field, letters, value, number=0):
        at = self.chunk(kind, number)
        self.set(letters, at + field, value)
        self.sign(at)
        return self

    def payload(self, kind, field, letters, value, number=0):
        at = self.chunk(kind, number)
        self.set(letters, at + 40 + field, value)
        self.sign(at)
        return self

    def refused(self):
        return refusal(bytes(self.data))


class RoundTrip(unittest.TestCase):
    def test_what_is_written_is_read(self):
        for capture in (small_capture(), plain_capture(), spcap.Capture()):  # of numbers that 32 bits hold
            for level in (0, 1, 9):
                data = spcap.encode(capture, level)
                self.assertEqual(spcap.decode(data), capture)
                self.assertEqual(spcap.encode(spcap.decode(data), level), data)

    def test_equal_bytes_are_stored_once(self):
        data = spcap.encode(small_capture())
        self.assertEqual(data.count(b"DATA"), 2 * 8)  # a header and an index entry each; 9 resources

    def test_a_failed_write_leaves_the_file_as_it_was(self):
        with folder() as path:
            target = os.path.join(path, "out.spcap")
            spcap.write(small_capture(), target)
            before = bytes_of(target)
            broken = small_capture()
            broken.frames[0].draws[0].material = 9
            with self.assertRaisesRegex(spcap.CaptureError, "frame 0, draw 0, field material"):
                spcap.write(broken, target)
            self.assertEqual(bytes_of(target), before)
            self.assertEqual(os.listdir(path), ["out.spcap"])

    def test_records_say_what_they_hold(self):
        self.assertEqual(repr(spcap.Buffer(name="b", bytes=b"x" * 17)), "Buffer(name='b', bytes=<17 bytes>)")
        with self.assertRaises(TypeError):
            spcap.Draw(matreial=1)


class Streams(unittest.TestCase):
    def check_values(self):
        capture = small_capture()
        draw = capture.frames[0].draws[0]
        self.assertEqual([tuple(v) for v in spcap.stream_values(capture, draw.position, 4)],
                         [(0, 0, -2), (1, 0, -2), (0, 1, -2), (1, 1, -2)])
        self.assertEqual(tuple(spcap.stream_values(capture, draw.normal, 4)[3]), (0, 0, 1, 0))
        self.assertEqual(tuple(spcap.stream_values(capture, draw.uv, 4)[0]), (0, 1))
        self.assertEqual(list(spcap.draw_indices(capture, draw)), [0, 1, 2, 2, 1, 3])
        self.assertEqual(list(spcap.draw_indices(capture, capture.frames[0].draws[1])), [1, 2, 3])
        self.assertIsNone(spcap.stream_values(capture, spcap.VertexStream(), 4))

    def check_packed_values(self):
        capture = spcap.decode(spcap.encode(strip_capture()))
        strip, fan, some = capture.frames[0].draws
        self.assertEqual(list(spcap.draw_indices(capture, strip)), [0, 1, 2, 1, 3, 2])
        self.assertEqual(list(spcap.draw_indices(capture, fan)), [2, 3, 1])
        self.assertEqual(list(spcap.draw_indices(capture, some)), [0, 1, 2, 1, 2, 3])
        self.assertEqual(spcap.triangle_count(capture, some), 2)
        for got, expected in (
                (spcap.stream_values(capture, strip.normal, 1)[0], (0, 0, -1)),
                (spcap.stream_values(capture, fan.normal, 1)[0], (0, 1, -1, 1)),
                (spcap.stream_values(capture, fan.colour, 1)[0], (1, 1.5, 0.5)),
                (spcap.stream_values(capture, some.normal, 1)[0], (1, 0, 0)),
                (spcap.stream_values(capture, some.colour, 1)[0], (1, 0, 341 / 1023, 1)),
                (spcap.stream_values(capture, some.uv, 1)[0], (1, -1))):
            self.assertEqual(len(got), len(expected))
            for a, b in zip(got, expected):
                self.assertAlmostEqual(float(a), b, 6)

    def test_strips_and_packed_formats(self):
        self.check_packed_values()
        with mock.patch.object(streams, "numpy", None):
            self.check_packed_values()

    def test_with_whatever_is_installed(self):
        self.check_values()

    def test_without_numpy(self):
        with mock.patch.object(streams, "numpy", None):
            self.check_values()
            self.assertEqual(refusal(spcap.encode(small_capture())), "")


@unittest.skipUnless(os.path.exists(BINARY), "the program is not built")
class AgainstTheProgram(unittest.TestCase):
    def assert_info(self, path, capture):
        code, out, errors = subpixel("info", path, "--json")
        self.assertEqual((code, errors), (0, ""))
        said = json.loads(out)
        for key, value in spcap.summarize(capture).items():
            self.assertEqual(said[key], value, key)

    def test_the_program_takes_what_is_written(self):
        with folder() as path:
            for i, capture in enumerate((small_capture(), plain_capture(), strip_capture())):
                for level in (0, 6):
                    name = os.path.join(path, "{}-{}.spcap".format(i, level))
                    capture.textures[1].bytes = PNG  # validate decodes image files
                    spcap.write(capture, name, level)
                    code, out, errors = subpixel("validate", name)
                    self.assertEqual(code, 0, out + errors)
                    self.assert_info(name, capture)

    def test_what_the_program_writes_is_read(self):
        if codecs.xxh3_64(b"") is None:
            self.skipTest("no libxxhash")
        for scene in ("grass", "foliage", "quads", "hard_bad_vertices"):
            with folder() as path:
                name = os.path.join(path, "scene.spcap")
                code, _, errors = subpixel("generate", scene, name, "--frames", "2", "--density", "0.05")
                self.assertEqual(code, 0, errors)
                capture = spcap.read(name)
                self.assert_info(name, capture)
                again = os.path.join(path, "again.spcap")
                spcap.write(capture, again)
                if scene != "hard_bad_vertices":  # a NaN does not equal itself
                    self.assertEqual(spcap.read(again), capture)
                self.assert_info(again, capture)

    def test_a_replay_of_both_is_the_same(self):
        with folder() as path:
            name, again = os.path.join(path, "scene.spcap"), os.path.join(path, "again.spcap")
            code, _, errors = subpixel("generate", "grass", name, "--frames", "1", "--size", "64x48", "--density",
                                       "0.02")
            self.assertEqual(code, 0, errors)
            spcap.write(spcap.read(name), again)
            images = []
            for capture in (name, again):
                out = capture + ".out"
                code, _, errors = subpixel("replay", capture, "--techniques", "noaa", "--reference-samples", "0",
                                           "--repeat", "1", "--out", out)
                if code == 4:
                    self.skipTest("no Vulkan device: " + errors)
                self.assertEqual(code, 0, errors)
                images.append({file: bytes_of(os.path.join(out, file))
                               for file in sorted(os.listdir(out)) if file.endswith(".png")})
            self.assertTrue(images[0])
            self.assertEqual(images[0], images[1])


class Refusals(unittest.TestCase):
    def assert_refused(self, forgery, text):
        said = forgery.refused() if isinstance(forgery, Forgery) else refusal(forgery)
        self.assertIn(text, said)
        self.assertNotIn("\n", said)

    def test_every_truncation(self):
        data = spcap.encode(small_capture())
        for size in range(len(data)):
            self.assertTrue(refusal(data[:size]), size)

    def test_every_flipped_bit(self):
        for level in (0, 6):
            data = bytearray(spcap.encode(small_capture(), level))
            for bit in range(0, 8 * len(data), 31):
                data[bit // 8] ^= 1 << bit % 8
                self.assertTrue(refusal(bytes(data)), bit)
                data[bit // 8] ^= 1 << bit % 8

    def test_headers(self):
        self.assert_refused(b"PNG", "this is no .spcap capture: byte 0, chunk header, field magic")
        newer = Forgery()
        newer.set("I", 8, 4)
        self.assert_refused(newer, "version 4, this module reads 1 to 3")
        other = Forgery()
        other.set("I", 12, 2)
        self.assert_refused(other, "2 is no checksum")
        older = Forgery()
        older.set("I", 8, 1)
        self.assert_refused(older, "1 is no checksum of version 1")
        self.assert_refused(Forgery().header(b"BUFR", 0, "4s", b"AAAA"), "unknown chunk type")
        self.assert_refused(Forgery().header(b"BUFR", 0, "4s", b"META"), "stands after a later kind")
        self.assert_refused(Forgery().header(b"BUFR", 4, "I", 7, 1), "out of sequence")
        self.assert_refused(Forgery().header(b"BUFR", 8, "I", 3), "unknown codec")
        self.assert_refused(Forgery().header(b"BUFR", 12, "I", 1), "field reserved")
        self.assert_refused(Forgery().header(b"BUFR", 16, "Q", 1 << 40), "field stored_bytes")
        self.assert_refused(Forgery().header(b"BUFR", 24, "Q", 0), "field decoded_bytes")

    def test_draws_that_lie(self):
        for field, value in (("topology", 3), ("restart", True), ("index_type", 4)):
            capture = strip_capture()
            setattr(capture.frames[0].draws[0], field, value)
            if field == "restart":
                capture.frames[0].draws[0].topology = spcap.Topology.TRIANGLE_LIST
                capture.frames[0].draws[0].index_count = 3
            with self.assertRaisesRegex(spcap.CaptureError, "field " + field):
                spcap.encode(capture)

    def test_levels_of_means_need_version_3(self):
        capture = small_capture()
        for mip in (spcap.MipFilter.LINEAR_OF_MEANS, spcap.MipFilter.NEAREST_OF_MEANS):
            capture.textures[0].sampler.mip = mip
            data = spcap.encode(capture)
            self.assertEqual(struct.unpack_from("<I", data, 8)[0], 3)
            self.assertEqual(spcap.decode(data).textures[0].sampler.mip, mip)
        self.assert_refused(Forgery().payload(b"TEXR", 44, "I", 3), "3 is no mip filter of version 2")
        capture.textures[0].sampler.mip = 5
        with self.assertRaisesRegex(spcap.CaptureError, "field sampler.mip"):
            spcap.encode(capture)

    def test_streams_that_lie(self):
        number = 5  # the bytes of buffer "many": equal ones are stored once
        for value, text in ((2399, "decodes to more"), (2401, "decodes to 2400 bytes"), (1 << 40, "more than zlib")):
            self.assert_refused(Forgery(level=6).header(b"DATA", 24, "Q", value, number), text)
        self.assertEqual(Forgery(level=6).header(b"DATA", 24, "Q", 2400, number).refused(), "")
        self.assert_refused(Forgery(level=6).payload(b"DATA", 0, "B", 0, number), "zlib: ")
        with self.assertRaisesRegex(ValueError, "does not end"):
            codecs.inflate(zlib.compress(b"abc")[:-1], 3)
        with self.assertRaisesRegex(ValueError, "1 bytes follow"):
            codecs.inflate(zlib.compress(b"abc") + b"x", 3)
        self.assertEqual(codecs.inflate(zlib.compress(b"abc"), 3), b"abc")
        self.assertEqual(codecs.inflate(zlib.compress(b""), 0), b"")

    def test_records_that_lie(self):
        self.assert_refused(Forgery().payload(b"META", 0, "I", 0xFFFFFFF0), "longer than 65536 bytes")
        self.assert_refused(Forgery().payload(b"BUFR", 4, "B", 0xFF, 1), "not UTF-8")
        self.assert_refused(Forgery().payload(b"BUFR", 4 + 7, "I", 99, 1), "chunk BUFR 1, decoded byte 15, field data")
        self.assert_refused(Forgery().payload(b"MATL", 0, "I", 3), "chunk MATL 0")
        self.assert_refused(Forgery().payload(b"MATL", 0, "I", 1), "bytes follow the last field")

    def test_values_that_lie_are_refused_by_reader_and_writer(self):
        lies = [
            ("sampler.wrap_u", lambda c: setattr(c.textures[0].sampler, "wrap_u", 3)),
            ("normal_scale", lambda c: setattr(c.materials[1], "normal_scale", float("inf"))),
            ("base_colour_uv.set", lambda c: setattr(c.materials[1].base_colour_uv, "set", 2)),
            ("normal_texture", lambda c: setattr(c.materials[1], "normal_texture", 2)),
            ("base_colour", lambda c: setattr(c.materials[0], "base_colour", (2.0, 0, 0, 0))),
            ("view", lambda c: setattr(c.frames[0], "view", (float("nan"),) * 16)),
            ("width", lambda c: setattr(c.frames[0], "width", 0)),
            ("clip_depth", lambda c: setattr(c.frames[0], "clip_depth", 3)),
            ("cone.inner_cosine", lambda c: setattr(c.frames[0].point_lights[1].cone, "inner_cosine", -0.5)),
            ("position.offset", lambda c: setattr(c.frames[0].draws[0].position, "offset", 9)),
            ("position.stride", lambda c: setattr(c.frames[0].draws[0].position, "stride", 0)),
            ("uv.format", lambda c: setattr(c.frames[0].draws[0].uv, "format", 17)),
            ("colour.format", lambda c: setattr(c.frames[0].draws[0].colour, "format", 5)),
            ("index_count", lambda c: setattr(c.frames[0].draws[0], "index_count", 5)),
            ("index_offset", lambda c: setattr(c.frames[0].draws[0], "index_offset", 4)),
            ("index_buffer", lambda c: setattr(c.frames[0].draws[0], "base_vertex", 1)),
            ("instance_offset", lambda c: setattr(c.frames[0].draws[0], "instance_offset", 1)),
            ("instance_count", lambda c: setattr(c.frames[0].draws[1], "instance_count", 2)),
        ]
        for field, tell in lies:
            lying = small_capture()
            tell(lying)
            with self.assertRaisesRegex(spcap.CaptureError, field):
                spcap.encode(lying)
            with mock.patch("subpixel_capture.writer.check_capture"):
                data = spcap.encode(lying)
            self.assert_refused(data, "field ")
            self.assert_refused(data, field)
            if os.path.exists(BINARY):
                with folder() as path:
                    name = os.path.join(path, "lying.spcap")
                    write_bytes(name, data)
                    code, _, errors = subpixel("validate", name)
                    self.assertEqual(code, 3, errors)
                    self.assertIn(field, errors)

    def test_missing_libraries_are_named(self):
        data = bytearray(spcap.encode(small_capture()))
        struct.pack_into("<I", data, 12, 0)
        with mock.patch.object(codecs, "xxh3_64", lambda *parts: None):
            self.assert_refused(bytes(data), "neither libxxhash nor the module xxhash")
        self.assertEqual(refusal(bytes(data), verify=False), "")
        with mock.patch.object(codecs, "_zstd", False):
            with self.assertRaisesRegex(ValueError, "neither libzstd"):
                codecs.unzstd(b"", 0)

    def test_a_file_error_names_the_file(self):
        with folder() as path:
            name = os.path.join(path, "x.spcap")
            write_bytes(name, b"nothing")
            with self.assertRaisesRegex(spcap.CaptureError, "x.spcap: the capture can't be read: this is no"):
                spcap.read(name)


def _png():
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(b"\0\x80\x80\xff")) + chunk(b"IEND", b""))


PNG = _png()

if __name__ == "__main__":
    unittest.main()
