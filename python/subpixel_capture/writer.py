"""Captures to bytes: version 2 or 3, CRC-32, each chunk deflated where that makes it smaller."""
import hashlib
import io
import os
import struct
import uuid
import zlib

from . import codecs, layout
from .checks import check_capture
from .errors import CaptureError
from .model import NONE, IndexType, MipFilter, Topology

_NO_STREAM = struct.pack("<IIQI", 0xFFFFFFFF, 1, 0, 0)


class _Fields:
    """A payload, field after field."""

    def __init__(self):
        self.out = io.BytesIO()

    def text(self, value):
        data = value.encode("utf-8")
        self.out.write(struct.pack("<I", len(data)))
        self.out.write(data)

    def put(self, letters, *values):
        self.out.write(struct.pack("<" + letters, *values))

    def bytes(self):
        return self.out.getvalue()


def _metadata(metadata):
    out = _Fields()
    for text in (metadata.title, metadata.application, metadata.tool, metadata.licence):
        out.text(text)
    out.put("fI", metadata.metres_per_unit, len(metadata.notices))
    for notice in metadata.notices:
        out.text(notice)
    return out.bytes()


def _buffer(held, data):
    out = _Fields()
    out.text(held.name)
    out.put("I", data)
    return out.bytes()


def _texture(texture, data):
    out = _Fields()
    out.text(texture.name)
    out.put("5I", texture.encoding, int(texture.srgb), texture.width, texture.height, data)
    sampler = texture.sampler
    out.put("5I", sampler.wrap_u, sampler.wrap_v, sampler.magnify, sampler.minify, sampler.mip)
    return out.bytes()


def _materials(materials):
    out = _Fields()
    out.put("I", len(materials))
    for material in materials:
        out.text(material.name)
        out.put("4fIIfffII3fII", *(tuple(material.base_colour) + (
            material.base_colour_texture, material.alpha_mode, material.alpha_cutoff, material.metallic,
            material.roughness, material.metallic_roughness_texture, material.normal_texture)
            + tuple(material.emissive) + (material.emissive_texture, int(material.two_sided))))
        out.put("fI", material.normal_scale, int(material.unlit))
        for mapping in (material.base_colour_uv, material.metallic_roughness_uv, material.normal_uv,
                        material.emissive_uv):
            out.put("I6f", mapping.set, *mapping.matrix)
    return out.bytes()


def _stream(out, stream):
    if stream.buffer == 0xFFFFFFFF:
        out.out.write(_NO_STREAM)
    else:
        out.put("IIQI", stream.buffer, stream.format, stream.offset, stream.stride)


def _needed_version(capture):
    """2, or 3 where a draw is a strip or fan, has indices of 8 bits or a format that version 2 lacks, or the levels of
    a texture are means."""
    if any(texture.sampler.mip > MipFilter.NONE for texture in capture.textures):
        return 3
    for frame in capture.frames:
        for draw in frame.draws:
            streams = (draw.position, draw.normal, draw.uv, draw.tangent, draw.uv2, draw.colour)
            if (draw.topology != Topology.TRIANGLE_LIST or draw.index_type == IndexType.UINT8 or
                    any(s.buffer != NONE and s.format >= layout.FORMATS_OF[2] for s in streams)):
                return 3
    return 2


def _draw(out, draw, version):
    out.text(draw.name)
    out.put("I", draw.material)
    for stream in (draw.position, draw.normal, draw.uv, draw.tangent):
        _stream(out, stream)
    out.put("IIQIiI", draw.index_type, draw.index_buffer, draw.index_offset, draw.index_count, draw.base_vertex,
            draw.vertex_count)
    out.put("16f", *draw.transform)
    out.put("IQI", draw.instance_buffer, draw.instance_offset, draw.instance_count)
    _stream(out, draw.uv2)
    _stream(out, draw.colour)
    if version >= 3:
        out.put("II", draw.topology, int(draw.restart))


def _frame(frame, version):
    out = _Fields()
    out.text(frame.name)
    out.put("d", frame.time_s)
    out.put("16f", *frame.view)
    out.put("16f", *frame.projection)
    out.put("4I", frame.clip_depth, int(frame.clip_y_up), frame.width, frame.height)
    out.put("f3f3f", frame.exposure, *(tuple(frame.sky) + tuple(frame.ambient)))
    out.put("I", int(frame.sun is not None))
    if frame.sun is not None:
        out.put("3f3fI", *(tuple(frame.sun.direction) + tuple(frame.sun.irradiance) + (int(frame.sun.shadows),)))
    out.put("I", len(frame.point_lights))
    for light in frame.point_lights:
        out.put("3f3ff", *(tuple(light.position) + tuple(light.intensity) + (light.range,)))
        out.put("I", int(light.cone is not None))
        if light.cone is not None:
            out.put("3fff", *(tuple(light.cone.direction) + (light.cone.inner_cosine, light.cone.outer_cosine)))
    out.put("I", len(frame.draws))
    for draw in frame.draws:
        _draw(out, draw, version)
    return out.bytes()


class FileWriter:
    """Chunks to an open binary file, one after the other, as SPEC.md has them. Nothing is held but the index."""

    def __init__(self, out, level=6, version=2):
        self.out, self.level = out, level
        self.offset = 0
        self.index = []
        self.header = layout.HEADER.pack(layout.MAGIC, version, layout.CRC32)
        self._put(self.header)

    def _put(self, data):
        self.out.write(data)
        self.offset += len(data)

    def chunk(self, kind, number, payload):
        self.index.append(layout.INDEX_ENTRY.pack(kind, number, self.offset))
        self._chunk(kind, number, payload, self.level)

    def _chunk(self, kind, number, payload, level):
        codec, stored = layout.STORED, payload
        if level > 0 and len(payload) > 64:
            packed = zlib.compress(payload, level)
            if len(packed) < len(payload):
                codec, stored = layout.ZLIB, packed
        head = layout.CHUNK.pack(kind, number, codec, 0, len(stored), len(payload))
        self._put(head)
        self._put(struct.pack("<Q", codecs.crc32(head, stored)))
        self._put(stored)
        self._put(b"\0" * (layout.aligned(self.offset) - self.offset))

    def finish(self):
        """Index and footer. The file is whole after this."""
        index_offset = self.offset
        self._chunk(b"INDX", 0, b"".join(self.index), 0)
        head = struct.pack("<QQ", index_offset, self.offset + layout.FOOTER.size)
        self._put(head + struct.pack("<Q8s", codecs.crc32(self.header, head), layout.END_MAGIC))


class _Data:
    """Each different byte string once, in the order of first use."""

    def __init__(self, file):
        self.file, self.numbers = file, {}

    def number(self, data):
        key = (len(data), hashlib.sha256(data).digest())
        if key not in self.numbers:
            self.numbers[key] = len(self.numbers)
            self.file.chunk(b"DATA", self.numbers[key], data)
        return self.numbers[key]


def write_to(capture, out, level=6):
    """Writes to an open binary file. `level` is zlib's, 0 (stored) to 9. Raises CaptureError before anything is
    written when the capture breaks a rule of SPEC.md."""
    check_capture(capture)
    try:
        version = _needed_version(capture)
        file = FileWriter(out, level, version)
        file.chunk(b"META", 0, _metadata(capture.metadata))
        data = _Data(file)
        numbers = [data.number(held.bytes) for held in capture.buffers]
        texture_numbers = [data.number(texture.bytes) for texture in capture.textures]
        for i, held in enumerate(capture.buffers):
            file.chunk(b"BUFR", i, _buffer(held, numbers[i]))
        for i, texture in enumerate(capture.textures):
            file.chunk(b"TEXR", i, _texture(texture, texture_numbers[i]))
        file.chunk(b"MATL", 0, _materials(capture.materials))
        for i, frame in enumerate(capture.frames):
            file.chunk(b"FRAM", i, _frame(frame, version))
        file.finish()
    except (struct.error, OverflowError) as error:
        raise CaptureError("can't write the capture", str(error), "a field is out of its range")


def encode(capture, level=6):
    """The bytes of a .spcap file."""
    out = io.BytesIO()
    write_to(capture, out, level)
    return out.getvalue()


def write(capture, path, level=6):
    """Writes a .spcap file, which is there when it is whole, else as it was before. Raises CaptureError, OSError."""
    folder = os.path.dirname(os.path.abspath(path))
    part = os.path.join(folder, "{}.{}".format(os.path.basename(path), uuid.uuid4().hex))
    out = open(part, "xb")
    try:
        with out:
            write_to(capture, out, level)
            out.flush()
            os.fsync(out.fileno())
        os.replace(part, path)
    except BaseException:
        os.unlink(part)
        raise
