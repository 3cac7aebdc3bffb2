"""Values of vertex streams and indices: numpy arrays where numpy is installed, else lists of tuples and arrays."""
import array
import math
import struct

from .model import NONE, IndexType, Topology, VertexFormat

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
    VertexFormat.UNORM16X4: ("H", 4, 65535.0), VertexFormat.FLOAT16X3: ("e", 3, 0),
    VertexFormat.SNORM16X2: ("h", 2, 32767.0),
}


def _octahedral(divisor):
    def unpack(element):
        u, v = (max(c / divisor, -1.0) for c in element)
        x, y, z = u, v, 1.0 - abs(u) - abs(v)
        if z < 0:
            x, y = math.copysign(1.0 - abs(v), u), math.copysign(1.0 - abs(u), v)
        length = math.sqrt(x * x + y * y + z * z)
        return (x / length, y / length, z / length)
    return unpack


def _snorm_field(bits, at, width):
    value = bits >> at & (1 << width) - 1
    value -= (value >> width - 1) << width
    return max(value / ((1 << width - 1) - 1), -1.0)


def _snorm10(element):
    return tuple(_snorm_field(element[0], at, width) for at, width in ((0, 10), (10, 10), (20, 10), (30, 2)))


def _unorm10(element):
    bits = element[0]
    return tuple((bits >> at & 1023) / 1023 for at in (0, 10, 20)) + ((bits >> 30) / 3,)


def _float11(element):
    bits = element[0]
    halves = struct.pack("<HHH", (bits & 2047) << 4, (bits >> 11 & 2047) << 4, bits >> 22 << 5)
    return struct.unpack("<eee", halves)


# format -> struct letters of an element, components, function of the unpacked element
_PACKED = {
    VertexFormat.OCTAHEDRAL_SNORM8: ("bb", 3, _octahedral(127.0)),
    VertexFormat.OCTAHEDRAL_SNORM16: ("hh", 3, _octahedral(32767.0)),
    VertexFormat.SNORM10X3_2: ("I", 4, _snorm10), VertexFormat.UNORM10X3_2: ("I", 4, _unorm10),
    VertexFormat.FLOAT11X2_10: ("I", 3, _float11),
}


def component_count(vertex_format):
    return (_PACKED if vertex_format in _PACKED else _FORMATS)[vertex_format][1]


def element_bytes(vertex_format):
    if vertex_format in _PACKED:
        return struct.calcsize("<" + _PACKED[vertex_format][0])
    letter, components, _ = _FORMATS[vertex_format]
    return struct.calcsize("<" + letter) * components


def stream_values(capture, stream, count):
    """The first `count` elements, normalised: an array (count, components) of float32 where there is numpy, else a
    list of tuples; None for an absent stream."""
    if stream.buffer == NONE:
        return None
    data = capture.buffers[stream.buffer].bytes
    if stream.format in _PACKED:
        letters, components, unpack = _PACKED[stream.format]
        packed = struct.Struct("<" + letters)
        values = [unpack(packed.unpack_from(data, stream.offset + i * stream.stride)) for i in range(count)]
        return values if numpy is None else numpy.array(values, numpy.float32).reshape(count, components)
    letter, components, divisor = _FORMATS[stream.format]
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


_INDICES = {IndexType.UINT8: ("B", 1), IndexType.UINT16: ("H", 2), IndexType.UINT32: ("I", 4)}


def index_bytes(index_type):
    return _INDICES[index_type][1]


def restart_index(index_type):
    """The index that begins a new strip or fan."""
    return (1 << 8 * index_bytes(index_type)) - 1


def most_triangles(draw):
    """Triangles of a draw with its instances; where it restarts, the most there can be."""
    if draw.topology == Topology.TRIANGLE_LIST:
        return draw.index_count // 3 * draw.instance_count
    return max(draw.index_count - 2, 0) * draw.instance_count


def triangle_count(capture, draw):
    """Triangles of a draw with its instances."""
    if not draw.restart:
        return most_triangles(draw)
    return len(draw_indices(capture, draw)) // 3 * draw.instance_count


def _listed(topology, indices, cut):
    """The corners of the triangles of a strip or fan; `cut` begins a new one, None never does."""
    corners, begin = [], 0
    for end in [i for i, index in enumerate(indices) if index == cut] + [len(indices)]:
        part, begin = indices[begin:end], end + 1
        for i in range(len(part) - 2):
            if topology == Topology.TRIANGLE_FAN:
                corners += (part[i + 1], part[i + 2], part[0])
            else:
                corners += (part[i], part[i + 1 + i % 2], part[i + 2 - i % 2])
    return corners


def raw_indices(capture, draw):
    """The indices as stored, base_vertex not added: an array.array, or numpy array where there is numpy."""
    letter, size = _INDICES[draw.index_type]
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
    if draw.topology != Topology.TRIANGLE_LIST:
        stored = range(draw.index_count) if draw.index_type == IndexType.NONE else list(raw_indices(capture, draw))
        cut = restart_index(draw.index_type) if draw.restart else None
        corners = [int(index) + draw.base_vertex for index in _listed(draw.topology, stored, cut)]
        return corners if numpy is None else numpy.array(corners, numpy.int64)
    if draw.index_type == IndexType.NONE:
        return range(draw.base_vertex, draw.base_vertex + draw.index_count)
    values = raw_indices(capture, draw)
    if numpy is not None:
        return values.astype(numpy.int64) + draw.base_vertex
    return [value + draw.base_vertex for value in values]
