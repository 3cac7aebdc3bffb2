"""Vertex attributes: which formats a capture takes as they are, and the numbers of all others."""
import struct

from subpixel_capture import VertexFormat

# (component type, bytes of one, components) -> the capture's format
_SAME = {("Float", 4, 2): VertexFormat.FLOAT32X2, ("Float", 4, 3): VertexFormat.FLOAT32X3,
         ("Float", 4, 4): VertexFormat.FLOAT32X4, ("Float", 2, 2): VertexFormat.FLOAT16X2,
         ("Float", 2, 4): VertexFormat.FLOAT16X4, ("SNorm", 1, 4): VertexFormat.SNORM8X4,
         ("SNorm", 2, 4): VertexFormat.SNORM16X4, ("UNorm", 2, 2): VertexFormat.UNORM16X2,
         ("UNorm", 1, 4): VertexFormat.UNORM8X4, ("UNorm", 2, 4): VertexFormat.UNORM16X4}
_LETTERS = {("Float", 2): "e", ("Float", 4): "f", ("Float", 8): "d"}
_INTEGERS = {1: "B", 2: "H", 4: "I"}


class AttributeFormat:
    """A vertex attribute's element, from RenderDoc's ResourceFormat."""

    def __init__(self, rd, form):
        self.kind = _kind_name(rd, form.compType)
        self.special = form.type if form.type != rd.ResourceFormatType.Regular else None
        self.is_packed = form.type == rd.ResourceFormatType.R10G10B10A2
        self.width, self.count = form.compByteWidth, form.compCount
        self.is_bgra = form.BGRAOrder()
        self.is_known = self.special is None or self.is_packed
        self.bytes = 4 if self.is_packed else self.width * self.count

    def same(self):
        """The capture's format of the same bytes, or None."""
        if self.special is not None or self.is_bgra:
            return None
        return _SAME.get((self.kind, self.width, self.count))

    def decode(self, data, offset, stride, count):
        """`count` tuples of numbers, normalised."""
        if self.is_packed:
            return [self._unpacked(struct.unpack_from("<I", data, offset + i * stride)[0]) for i in range(count)]
        letter = _LETTERS.get((self.kind, self.width))
        divisor = 0.0
        if letter is None:
            letter = _INTEGERS[self.width]
            if self.kind in ("SNorm", "SInt", "SScaled"):
                letter = letter.lower()
            if self.kind in ("SNorm", "UNorm", "UNormSRGB"):
                divisor = float((1 << (8 * self.width - (1 if self.kind == "SNorm" else 0))) - 1)
        element = struct.Struct("<" + letter * self.count)
        if stride == 0:
            values = [element.unpack_from(data, offset)] * count
        elif stride == element.size:
            values = list(element.iter_unpack(bytes(data[offset:offset + stride * count])))
        else:
            values = [element.unpack_from(data, offset + i * stride) for i in range(count)]
        if divisor:
            values = [tuple(max(v / divisor, -1.0) for v in value) for value in values]
        if self.is_bgra:
            values = [(v[2], v[1], v[0]) + v[3:] for v in values]
        return values

    def _unpacked(self, word):
        parts = [word & 1023, word >> 10 & 1023, word >> 20 & 1023, word >> 30]
        if self.kind in ("SNorm", "SInt", "SScaled"):
            parts = [p - 1024 if p > 511 else p for p in parts[:3]] + [parts[3] - 4 if parts[3] > 1 else parts[3]]
        if self.kind == "SNorm":
            parts = [max(p / 511.0, -1.0) for p in parts[:3]] + [max(float(parts[3]), -1.0)]
        elif self.kind == "UNorm":
            parts = [p / 1023.0 for p in parts[:3]] + [parts[3] / 3.0]
        if self.is_bgra:
            parts[0], parts[2] = parts[2], parts[0]
        return tuple(parts)


def _kind_name(rd, value):
    for name in ("Float", "UNorm", "SNorm", "UInt", "SInt", "UScaled", "SScaled", "UNormSRGB", "Depth"):
        if value == getattr(rd.CompType, name):
            return name
    return "Float"


def float_bytes(values, components):
    """Tuples as float32, cut or filled (0, 0, 0, 1) to `components`."""
    filler = (0.0, 0.0, 0.0, 1.0)
    flat = []
    for value in values:
        flat.extend((tuple(value) + filler[len(value):])[:components])
    return struct.pack("<%df" % len(flat), *flat)
