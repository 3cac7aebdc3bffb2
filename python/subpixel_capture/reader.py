"""Bytes to captures, every rule of SPEC.md on the way. The file is not trusted."""
import struct

from . import codecs, layout
from .checks import Checker
from .errors import CaptureError
from .model import (Buffer, Capture, DirectionalLight, Draw, Frame, IndexType, Material, Metadata, MipFilter, PointLight,
                    Sampler, SpotCone, Texture, UvMapping, VertexStream)

_WHAT = "the capture can't be read"


def _fail(why, offset, chunk="", field=""):
    where = "byte {}".format(offset)
    if chunk:
        where += ", chunk " + chunk
    if field:
        where += ", field " + field
    raise CaptureError(_WHAT, why, where)


class _Chunk:
    def __init__(self, offset, kind, number, codec, stored_bytes, decoded_bytes, checksum):
        self.offset, self.kind, self.number, self.codec = offset, kind, number, codec
        self.stored_bytes, self.decoded_bytes, self.checksum = stored_bytes, decoded_bytes, checksum

    @property
    def name(self):
        return "{} {}".format("".join(chr(c) if 32 <= c < 127 else "?" for c in self.kind), self.number)


class _File:
    """The chunks of a file, all that is outside payloads checked."""

    def __init__(self, data, verify):
        self.data, self.verify = memoryview(data), verify
        size = len(data)
        if data[:8] != layout.MAGIC:
            _fail("this is no .spcap capture", 0, "header", "magic")
        if size < 16 + layout.CHUNK_BYTES + 32:
            _fail("the file is truncated to {} bytes".format(size), size)
        _, self.version, self.flags = layout.HEADER.unpack_from(data, 0)
        if self.version not in layout.FORMATS_OF:
            _fail("version {}, this module reads 1 to 3".format(self.version), 8, "header", "version")
        if self.flags > (1 if self.version >= 2 else 0):
            _fail("{} is no checksum of version {}".format(self.flags, self.version), 12, "header", "flags")
        self.footer = size - 32
        index_offset, file_bytes, checksum, end = layout.FOOTER.unpack_from(data, self.footer)
        if end != layout.END_MAGIC:
            _fail("the end is missing: the file is truncated or has bytes after its end", self.footer + 24, "footer",
                  "end_magic")
        if file_bytes != size:
            _fail("differs from the file's {} bytes".format(size), self.footer + 8, "footer", "file_bytes")
        self._verify(checksum, self.footer + 16, "footer", self.data[:16], self.data[self.footer:self.footer + 16])
        if index_offset % 8 or not 16 <= index_offset <= self.footer - layout.CHUNK_BYTES:
            _fail("{} is outside the file's chunks".format(index_offset), self.footer, "footer", "index_offset")
        self.chunks = self._chunks(index_offset)
        self._check_index(index_offset)

    def _verify(self, expected, offset, name, *parts):
        if not self.verify:
            return
        found = codecs.checksum(self.flags, *parts)
        if found is None:
            _fail("its checksums are XXH3-64, and neither libxxhash nor the module xxhash is installed here (read "
                  "with verify=False to go on without)", offset, name, "checksum")
        if found != expected:
            _fail("the bytes are damaged", offset, name, "checksum")

    def _header(self, offset, end):
        kind, number, codec, reserved, stored, decoded = layout.CHUNK.unpack_from(self.data, offset)
        chunk = _Chunk(offset, kind, number, codec, stored, decoded,
                       struct.unpack_from("<Q", self.data, offset + 32)[0])
        known = kind in layout.ORDER
        if not known and self.version < 3:
            _fail("unknown chunk type", offset, chunk.name, "type")
        if known and codec > (layout.ZLIB if self.version >= 2 else layout.ZSTD):
            _fail("unknown codec", offset + 8, chunk.name, "codec")
        if reserved:
            _fail("not 0", offset + 12, chunk.name, "reserved")
        available = end - offset - layout.CHUNK_BYTES
        if stored > available:
            _fail("{} bytes are said to follow, {} do".format(stored, available), offset + 16, chunk.name,
                  "stored_bytes")
        if codec == layout.STORED and decoded != stored:
            _fail("differs from stored_bytes of an uncompressed chunk", offset + 24, chunk.name, "decoded_bytes")
        if codec == layout.ZLIB and decoded // layout.MOST_INFLATION > stored:
            _fail("more than zlib can make of {} bytes".format(stored), offset + 24, chunk.name, "decoded_bytes")
        return chunk

    def _chunks(self, end):
        chunks, offset, decoded, numbers = [], 16, 0, dict.fromkeys(layout.ORDER, 0)
        while offset < end:
            if end - offset < layout.CHUNK_BYTES:
                _fail("no room for a chunk header", offset)
            chunk = self._header(offset, end)
            before = chunks[-1] if chunks else None
            if self.version < 3 and before and layout.ORDER.index(chunk.kind) < layout.ORDER.index(before.kind):
                _fail("stands after a later kind of chunk", offset, chunk.name, "type")
            if chunk.kind in numbers:
                if chunk.number != numbers[chunk.kind]:
                    _fail("out of sequence", offset + 4, chunk.name, "id")
                numbers[chunk.kind] += 1
                decoded += chunk.decoded_bytes
            if decoded > layout.MOST_BYTES:
                _fail("more than {} bytes in all".format(layout.MOST_BYTES), offset + 24, chunk.name, "decoded_bytes")
            stop = offset + layout.CHUNK_BYTES + chunk.stored_bytes
            if any(self.data[stop:layout.aligned(stop)]):
                _fail("not 0", stop, chunk.name, "padding")
            chunks.append(chunk)
            offset = layout.aligned(stop)
        return chunks

    def _check_index(self, offset):
        index = self._header(offset, self.footer)
        if index.kind != b"INDX" or index.number != 0 or index.codec != layout.STORED:
            _fail("not an index that is stored as it is", offset, index.name, "type")
        if layout.aligned(offset + layout.CHUNK_BYTES + index.stored_bytes) != self.footer:
            _fail("the index does not end at the footer", offset + 16, index.name, "stored_bytes")
        expected = b"".join(layout.INDEX_ENTRY.pack(c.kind, c.number, c.offset) for c in self.chunks)
        stop = offset + layout.CHUNK_BYTES + index.stored_bytes
        if self.payload(index) != expected:
            _fail("differs from the chunks that are there", offset + layout.CHUNK_BYTES, index.name, "entries")
        if any(self.data[stop:self.footer]):
            _fail("not 0", stop, index.name, "padding")

    def verify_chunk(self, chunk):
        """The stored payload, its checksum verified."""
        begin = chunk.offset + layout.CHUNK_BYTES
        stored = self.data[begin:begin + chunk.stored_bytes]
        self._verify(chunk.checksum, chunk.offset + 32, chunk.name, self.data[chunk.offset:chunk.offset + 32], stored)
        return stored

    def payload(self, chunk):
        """Decoded bytes of a chunk, its checksum verified."""
        begin = chunk.offset + layout.CHUNK_BYTES
        stored = self.verify_chunk(chunk)
        if chunk.codec == layout.STORED:
            return bytes(stored)
        try:
            decode = codecs.inflate if chunk.codec == layout.ZLIB else codecs.unzstd
            return decode(stored, chunk.decoded_bytes)
        except ValueError as error:
            _fail(str(error), begin, chunk.name, "payload")


class _Fields:
    """A payload read field by field."""

    def __init__(self, payload, chunk, version):
        self.payload, self.chunk, self.version = payload, chunk, version
        self.at = 0
        self.record = ""

    def fail(self, field, why):
        name = "{}, decoded byte {}{}".format(self.chunk.name, self.at, self.record and ", " + self.record)
        _fail(why, self.chunk.offset, name, field)

    def get(self, letters, field):
        shape = struct.Struct("<" + letters)
        if shape.size > len(self.payload) - self.at:
            self.fail(field, "the chunk ends before it")
        values = shape.unpack_from(self.payload, self.at)
        self.at += shape.size
        return values

    def number(self, field, letter="I"):
        return self.get(letter, field)[0]

    def flag(self, field):
        value = self.number(field)
        if value > 1:
            self.fail(field, "{} is neither 0 nor 1".format(value))
        return value == 1

    def text(self, field):
        size = self.number(field)
        if size > layout.MOST_TEXT_BYTES:
            self.fail(field, "longer than {} bytes".format(layout.MOST_TEXT_BYTES))
        if size > len(self.payload) - self.at:
            self.fail(field, "the chunk ends before it")
        data = self.payload[self.at:self.at + size]
        self.at += size
        try:
            return data.decode("utf-8")
        except UnicodeDecodeError:
            self.fail(field, "not UTF-8")

    def count(self, field, most, record_bytes):
        value = self.number(field)
        if value > most:
            self.fail(field, "{} is more than {}".format(value, most))
        if value > (len(self.payload) - self.at) // record_bytes:
            self.fail(field, "{} records do not fit the chunk".format(value))
        return value

    def finish(self):
        if self.at != len(self.payload):
            self.fail("end", "{} bytes follow the last field".format(len(self.payload) - self.at))


def _metadata(fields):
    metadata = Metadata(title=fields.text("title"), application=fields.text("application"), tool=fields.text("tool"),
                        licence=fields.text("licence"), metres_per_unit=fields.number("metres_per_unit", "f"))
    if fields.version >= 2:
        count = fields.count("notices", layout.MOST_NOTICES, 4)
        metadata.notices = [fields.text("notices") for _ in range(count)]
    return metadata


def _material(fields):
    material = Material(name=fields.text("name"), base_colour=fields.get("4f", "base_colour"))
    material.base_colour_texture, material.alpha_mode = fields.get("II", "alpha_mode")
    material.alpha_cutoff, material.metallic, material.roughness = fields.get("fff", "roughness")
    material.metallic_roughness_texture, material.normal_texture = fields.get("II", "normal_texture")
    material.emissive = fields.get("3f", "emissive")
    material.emissive_texture = fields.number("emissive_texture")
    material.two_sided = fields.flag("two_sided")
    if fields.version >= 2:
        material.normal_scale = fields.number("normal_scale", "f")
        material.unlit = fields.flag("unlit")
        for name in ("base_colour_uv", "metallic_roughness_uv", "normal_uv", "emissive_uv"):
            setattr(material, name, UvMapping(set=fields.number(name), matrix=fields.get("6f", name)))
    return material


def _stream(fields, name):
    buffer, form, offset, stride = fields.get("IIQI", name)
    if buffer != 0xFFFFFFFF and form >= layout.FORMATS_OF[fields.version]:
        fields.fail(name + ".format", "{} is no vertex format of version {}".format(form, fields.version))
    if buffer == 0xFFFFFFFF:
        return VertexStream()
    return VertexStream(buffer=buffer, format=form, offset=offset, stride=stride)


def _draw(fields):
    draw = Draw(name=fields.text("name"), material=fields.number("material"))
    for name in ("position", "normal", "uv", "tangent"):
        setattr(draw, name, _stream(fields, name))
    draw.index_type, draw.index_buffer, draw.index_offset, draw.index_count, draw.base_vertex, draw.vertex_count = \
        fields.get("IIQIiI", "index_type")
    if fields.version < 3 and draw.index_type == IndexType.UINT8:
        fields.fail("index_type", "3 is no index type of version {}".format(fields.version))
    draw.transform = fields.get("16f", "transform")
    draw.instance_buffer, draw.instance_offset, draw.instance_count = fields.get("IQI", "instance_buffer")
    if fields.version >= 2:
        draw.uv2, draw.colour = _stream(fields, "uv2"), _stream(fields, "colour")
    if fields.version >= 3:
        draw.topology, draw.restart = fields.number("topology"), fields.flag("restart")
    return draw


def _point_light(fields):
    light = PointLight(position=fields.get("3f", "point_lights"), intensity=fields.get("3f", "point_lights"),
                       range=fields.number("point_lights", "f"))
    if fields.version >= 2 and fields.flag("point_lights.has_cone"):
        light.cone = SpotCone(direction=fields.get("3f", "point_lights.cone.direction"))
        light.cone.inner_cosine, light.cone.outer_cosine = fields.get("ff", "point_lights.cone.inner_cosine")
    return light


def _frame(fields, check):
    frame = Frame(name=fields.text("name"), time_s=fields.number("time_s", "d"), view=fields.get("16f", "view"),
                  projection=fields.get("16f", "projection"), clip_depth=fields.number("clip_depth"),
                  clip_y_up=fields.flag("clip_y_up"))
    frame.width, frame.height = fields.get("II", "width")
    frame.exposure = fields.number("exposure", "f")
    frame.sky, frame.ambient = fields.get("3f", "sky"), fields.get("3f", "ambient")
    if fields.flag("has_sun"):
        frame.sun = DirectionalLight(direction=fields.get("3f", "sun.direction"),
                                     irradiance=fields.get("3f", "sun.irradiance"), shadows=fields.flag("sun.shadows"))
    newer = fields.version >= 2
    lights = fields.count("point_lights", layout.MOST_LIGHTS, 32 if newer else 28)
    frame.point_lights = [_point_light(fields) for _ in range(lights)]
    for i in range(fields.count("draws", layout.MOST_DRAWS, {1: 196, 2: 236, 3: 244}[fields.version])):
        fields.record = "draw {}".format(i)
        frame.draws.append(_draw(fields))
        check(frame.draws[-1])
    fields.record = ""
    return frame


class _CaptureReader:
    def __init__(self, file):
        self.file = file
        self.capture = Capture()
        self.data = []
        self.skipped = set()
        self.payloads = {}
        self.bytes_left = layout.MOST_BYTES
        self.checker = Checker(_WHAT)

    def _take(self, fields):
        number = fields.number("data")
        if number >= len(self.data):
            fields.fail("data", "{} is not below {}".format(number, len(self.data)))
        self.bytes_left -= self.data[number].decoded_bytes
        if self.bytes_left < 0:
            fields.fail("data", "too many bytes in all buffers and textures")
        if number not in self.payloads:
            self.payloads[number] = self.file.payload(self.data[number])
        return self.payloads[number]

    def _texture(self, fields):
        texture = Texture(name=fields.text("name"), encoding=fields.number("encoding"), srgb=fields.flag("srgb"))
        texture.width, texture.height = fields.get("II", "width")
        texture.bytes = self._take(fields)
        if self.file.version >= 2:
            names = ("wrap_u", "wrap_v", "magnify", "minify", "mip")
            texture.sampler = Sampler(**dict(zip(names, fields.get("5I", "sampler"))))
            if self.file.version < 3 and texture.sampler.mip > MipFilter.NONE:
                fields.fail("sampler.mip", "{} is no mip filter of version 2".format(texture.sampler.mip))
        return texture

    def read(self):
        capture, checker, seen = self.capture, self.checker, set()
        for chunk in self.file.chunks:
            if chunk.kind not in layout.ORDER:
                self.file.verify_chunk(chunk)
                self.skipped.add(chunk.name.split(" ")[0])
                continue
            if self.file.version >= 3 and not seen and chunk.kind != b"META":
                _fail("stands before META", chunk.offset, chunk.name, "type")
            if chunk.kind == b"DATA":
                self.data.append(chunk)
                continue
            once = (b"META", b"MATL") if self.file.version < 3 else (b"META",)
            if chunk.kind == b"INDX" or (chunk.kind in once and chunk.number > 0):
                _fail("not expected here", chunk.offset, chunk.name, "type")
            seen.add(chunk.kind)
            fields = _Fields(self.file.payload(chunk), chunk, self.file.version)

            def fail_here(field, why, at=fields):
                at.fail(field, why)

            checker.fail = fail_here
            if chunk.kind == b"META":
                capture.metadata = _metadata(fields)
                checker.metadata(capture.metadata)
            elif chunk.kind == b"BUFR":
                checker.require(len(capture.buffers) < layout.MOST_OF["buffers"], "id", "too many")
                capture.buffers.append(Buffer(name=fields.text("name"), bytes=self._take(fields)))
            elif chunk.kind == b"TEXR":
                checker.require(len(capture.textures) < layout.MOST_OF["textures"], "id", "too many")
                capture.textures.append(self._texture(fields))
                checker.texture(capture.textures[-1])
            elif chunk.kind == b"MATL":
                least_bytes = 188 if fields.version >= 2 else 68
                most = layout.MOST_OF["materials"] - len(capture.materials)
                for i in range(fields.count("materials", most, least_bytes)):
                    fields.record = "material {}".format(i)
                    capture.materials.append(_material(fields))
                    checker.material(capture.materials[-1], len(capture.textures))
                fields.record = ""
            else:
                checker.require(len(capture.frames) < layout.MOST_OF["frames"], "id", "too many")
                frame = _frame(fields, lambda draw: checker.draw(capture, draw))
                checker.frame(frame)
                checker.frame_draws(frame)
                capture.frames.append(frame)
            fields.finish()
        for kind in (b"META", b"MATL"):
            if kind not in seen:
                _fail("chunk {} is missing".format(kind.decode("ascii")), 0)
        for number, chunk in enumerate(self.data):
            if number not in self.payloads:
                _fail("no buffer or texture refers to it", chunk.offset, chunk.name, "id")
        if self.skipped:
            capture.metadata.notices.append(
                "skipped on reading, of kinds that this program does not know: chunks " + " ".join(sorted(self.skipped)))
        return capture


def decode(data, verify=True):
    """The capture in the bytes of a .spcap file. `verify` False: checksums are not looked at. Raises CaptureError."""
    return _CaptureReader(_File(bytes(data), verify)).read()


def read(path, verify=True):
    """The capture in a .spcap file. Raises CaptureError that begins with the path, and OSError."""
    with open(path, "rb") as file:
        data = file.read(layout.MOST_BYTES + 1)
    if len(data) > layout.MOST_BYTES:
        raise CaptureError(str(path), _WHAT, "larger than {} bytes".format(layout.MOST_BYTES))
    try:
        return decode(data, verify)
    except CaptureError as error:
        raise CaptureError(str(path), str(error))
