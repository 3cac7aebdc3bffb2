"""Values of vertex streams and indices: numpy arrays where numpy is installed, else lists of tuples and arrays."""
import array
import struct

from .model import NONE, IndexType, VertexFormat

try:
    import numpy
except ImportError:
    numpy = None

# format -> struct letter, components, divisor of the integer (0: a float), whether it is signed
_FORMATS = {
    VertexFormat.FLOAT32X2: ("f", 2, 0), VertexFormat.FLOAT32X3: ("f", 3, 0), VertexFormat.FLOAT32X4: ("f", 4, 0),
    VertexFormat.FLOAT16X2: ("e", 2, 0), VertexFormat.FLOAT16X4: ("e", 4, 0),
    VertexFormat.SNORM8X4: ("b", 4, 127.0), VertexFormat.SNORM16X4: ("h", 4, 32767.0),
    VertexFormat.UNORM16X2: ("H", 2, 65535.0), VertexFormat.UNORM8X4: ("B", 4, 255.0),
    VertexFormat.UNORM16X4: ("H", 4, 65535.0),
}


def component_count(vertex_format):
    return _FORMATS[vertex_format][1]


def element_bytes(vertex_format):
    letter, components, _ = _FORMATS[vertex_format]
    return struct.calcsize("<" + letter) * components


def stream_values(capture, stream, count):
    """The first `count` elements, normalised: an array (count, components) of float32 where there is numpy, else a
    list of tuples; None for an absent stream."""
    if stream.buffer == NONE:
        return None
    letter, components, divisor = _FORMATS[stream.format]
    data = capture.buffers[stream.buffer].bytes
    if numpy is not None:
        kind = numpy.dtype("<" + {"e": "f2", "f": "f4", "b": "i1", "h": "i2", "H": "u2", "B": "u1"}[letter])
        size = kind.itemsize * components
        if count == 0:
            return numpy.zeros((0, components), numpy.float32)
        raw = numpy.ndarray((count, components), kind, data, stream.offset, (stream.stride, kind.itemsize))
        assert stream.offset + (count - 1) * stream.stride + size <= len(data)
        values = raw.astype(numpy.float32)
        return numpy.maximum(values / numpy.float32(divisor), -1) if divisor else values
    element = struct.Struct("<" + letter * components)
    values = [element.unpack_from(data, stream.offset + i * stream.stride) for i in range(count)]
    if divisor:
        values = [tuple(max(v / divisor, -1.0) for v in value) for value in values]
    return values


def raw_indices(capture, draw):
    """The indices as stored, base_vertex not added: an array.array, or numpy array where there is numpy."""
    letter, size = ("H", 2) if draw.index_type == IndexType.UINT16 else ("I", 4)
    data = bytes(memoryview(capture.buffers[draw.index_buffer].bytes)[
        draw.index_offset:draw.index_offset + size * draw.index_count])
    if numpy is not None:
        return numpy.frombuffer(data, "<u%d" % size)
    values = array.array(letter)
    if values.itemsize != size:
        return array.array("L", struct.unpack("<%d%s" % (draw.index_count, letter), data))
    values.frombytes(data)
    if struct.pack("=H", 1) != struct.pack("<H", 1):
        values.byteswap()
    return values


def draw_indices(capture, draw):
    """The vertex number of every corner drawn, base_vertex added: three a triangle."""
    if draw.index_type == IndexType.NONE:
        return range(draw.base_vertex, draw.base_vertex + draw.index_count)
    values = raw_indices(capture, draw)
    if numpy is not None:
        return values.astype(numpy.int64) + draw.base_vertex
    return [value + draw.base_vertex for value in values]
