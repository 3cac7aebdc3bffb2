"""Texels of block-compressed textures, decoded where texels are needed here: BC1 to BC5 and BC7 (Khronos, "Data Format
Specification" 1.3, chapters S3TC, RGTC and BPTC). Needs numpy."""
import struct

import numpy

# Of BPTC's partitions into two and three parts: the part of each texel, texel 0 in the lowest one or two bits.
_TWO = (
    "cccc 8888 eeee ecc8 c880 feec fec8 ec80 c800 ffec fe80 e800 ffe8 ff00 fff0 f000 f710 008e 7100 08ce 008c 7310 "
    "3100 8cce 088c 3110 6666 366c 17e8 0ff0 718e 399c aaaa f0f0 5a5a 33cc 3c3c 55aa 9696 a55a 73ce 13c8 324c 3bdc "
    "6996 c33c 9966 0660 0272 04e4 4e40 2720 c936 936c 39c6 639c 9336 9cc6 817e e718 ccf0 0fcc 7744 ee22")
_THREE = (
    "aa685050 6a5a5040 5a5a4200 5450a0a8 a5a50000 a0a05050 5555a0a0 5a5a5050 aa550000 aa555500 aaaa5500 90909090 "
    "94949494 a4a4a4a4 a9a59450 2a0a4250 a5945040 0a425054 a5a5a500 55a0a0a0 a8a85454 6a6a4040 a4a45000 1a1a0500 "
    "0050a4a4 aaa59090 14696914 69691400 a08585a0 aa821414 50a4a450 6a5a0200 a9a58000 5090a0a8 a8a09050 24242424 "
    "00aa5500 24924924 24499224 50a50a50 500aa550 aaaa4444 66660000 a5a0a5a0 50a050a0 69286928 44aaaa44 66666600 "
    "aa444444 54a854a8 95809580 96969600 a85454a8 80959580 aa141414 96960000 aaaa1414 a05050a0 a0a5a5a0 96000000 "
    "40804080 a9a8a9a8 aaaaaa44 2a4a5254")
# The texels whose index lacks its highest bit, besides texel 0: of the second of two parts, the second and third of
# three.
_FIXED_OF_TWO = "fffffffffffffffff282288f28228822ff6828ff28222ff66268ff22fffff22f"
_FIXED_OF_THREE = ("33ff83ff88666533338f336a588685ff8f356a8ff3f5ffff3f55585a5a8dfc33",
                   "f883ff38fffffff8f8f3f8f83f6affa8f3faa89a6f8f3668f3ffffffffff3ff8")
# Of modes 0 to 7: parts, bits of the partition, rotation, index selection, colour, alpha, least bits for each end or
# each part, indices and second indices.
_MODES = ((3, 4, 0, 0, 4, 0, "end", 3, 0), (2, 6, 0, 0, 6, 0, "part", 3, 0), (3, 6, 0, 0, 5, 0, "", 2, 0),
          (2, 6, 0, 0, 7, 0, "end", 2, 0), (1, 0, 2, 1, 5, 6, "", 2, 3), (1, 0, 2, 0, 7, 8, "", 2, 2),
          (1, 0, 0, 0, 7, 7, "end", 4, 0), (2, 6, 0, 0, 5, 5, "end", 2, 0))
_WEIGHTS = {2: (0, 21, 43, 64), 3: (0, 9, 18, 27, 37, 46, 55, 64),
            4: (0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64)}


def from_dds(data):
    """RGBA texels (height, width, 4) of a DDS file as textures.py makes them; None of a format not decoded here."""
    height, width = struct.unpack_from("<2I", data, 12)
    code, begin = bytes(data[84:88]), 128
    if code == b"DX10":
        code, begin = struct.unpack_from("<I", data, 128)[0], 148
    decode = {b"DXT1": _bc1, b"DXT3": _bc2, b"DXT5": _bc3, b"ATI1": _bc4, b"ATI2": _bc5, 98: _bc7}.get(code)
    if decode is None:
        return None
    across, down = (width + 3) // 4, (height + 3) // 4
    size = 8 if code in (b"DXT1", b"ATI1") else 16
    blocks = numpy.frombuffer(data, numpy.uint8, across * down * size, begin).reshape(-1, size)
    texels = decode(blocks).reshape(down, across, 4, 4, 4).transpose(0, 2, 1, 3, 4)
    return numpy.ascontiguousarray(texels.reshape(4 * down, 4 * across, 4)[:height, :width])


def _fields(blocks):
    """The bits of each block, the lowest first."""
    return numpy.unpackbits(blocks, axis=1, bitorder="little").astype(numpy.int32)


def _number(bits, begin, count):
    """The number of `count` bits of each block."""
    return bits[:, begin:begin + count] @ (1 << numpy.arange(count, dtype=numpy.int32))


def _rounded(value, divisor):
    return (2 * value + divisor) // (2 * divisor)


def _colours(blocks, always_four):
    """Of the last 8 bytes, S3TC's colours: (blocks, 16, 4) of 0 to 255."""
    words = numpy.ascontiguousarray(blocks[:, -8:]).view("<u2").astype(numpy.int32)
    first, second = (numpy.stack([w >> 11 & 31, w >> 5 & 63, w & 31], 1) for w in (words[:, 0], words[:, 1]))
    palette = numpy.full((len(blocks), 4, 4), 255, numpy.int32)
    for number, (mixed, parts) in enumerate(((first, 1), (second, 1), (2 * first + second, 3),
                                             (first + 2 * second, 3))):
        palette[:, number, :3] = _rounded(255 * mixed, parts * numpy.array((31, 63, 31)))
    if not always_four:
        three = words[:, 0] <= words[:, 1]
        palette[three, 2, :3] = _rounded(255 * (first + second)[three], numpy.array((62, 126, 62)))
        palette[three, 3] = 0
    numbers = _fields(blocks[:, -4:]).reshape(-1, 16, 2) @ (1, 2)
    return numpy.take_along_axis(palette, numbers[..., None], 1)


def _channel(blocks):
    """RGTC's 8 bytes of one channel: (blocks, 16)."""
    first, second = blocks[:, 0].astype(numpy.int32), blocks[:, 1].astype(numpy.int32)
    palette = numpy.zeros((len(blocks), 8), numpy.int32)
    palette[:, 0], palette[:, 1] = first, second
    seven = first > second
    for i in range(1, 7):
        palette[:, i + 1] = _rounded((7 - i) * first + i * second, 7)
    for i in range(1, 5):
        palette[~seven, i + 1] = _rounded((5 - i) * first[~seven] + i * second[~seven], 5)
    palette[~seven, 6], palette[~seven, 7] = 0, 255
    return numpy.take_along_axis(palette, _fields(blocks[:, 2:8]).reshape(-1, 16, 3) @ (1, 2, 4), 1)


def _bc1(blocks):
    return _colours(blocks, False).astype(numpy.uint8)


def _bc2(blocks):
    texels = _colours(blocks, True)
    texels[..., 3] = _fields(blocks[:, :8]).reshape(-1, 16, 4) @ (1, 2, 4, 8) * 17
    return texels.astype(numpy.uint8)


def _bc3(blocks):
    texels = _colours(blocks, True)
    texels[..., 3] = _channel(blocks)
    return texels.astype(numpy.uint8)


def _bc4(blocks):
    texels = numpy.full((len(blocks), 16, 4), 255, numpy.uint8)
    texels[..., :3] = _channel(blocks)[..., None]
    return texels


def _bc5(blocks):
    texels = numpy.full((len(blocks), 16, 4), 255, numpy.uint8)
    texels[..., 0], texels[..., 1], texels[..., 2] = _channel(blocks), _channel(blocks[:, 8:]), 0
    return texels


def _bc7(blocks):
    texels = numpy.zeros((len(blocks), 16, 4), numpy.uint8)
    for mode in range(8):
        chosen = (blocks[:, 0] & ((2 << mode) - 1)) == 1 << mode
        if chosen.any():
            texels[chosen] = _bc7_mode(_fields(blocks[chosen]), mode)
    return texels


def _bc7_mode(bits, mode):
    parts, partition_bits, rotation_bits, selection_bits, colour_bits, alpha_bits, least, first, second = _MODES[mode]
    at, count = mode + 1, len(bits)
    partition = _number(bits, at, partition_bits)
    rotation = _number(bits, at + partition_bits, rotation_bits)
    selection = _number(bits, at + partition_bits + rotation_bits, selection_bits)
    at += partition_bits + rotation_bits + selection_bits
    ends = numpy.zeros((count, 2 * parts, 4), numpy.int32)
    for channel, width in ((0, colour_bits), (1, colour_bits), (2, colour_bits), (3, alpha_bits)):
        for end in range(2 * parts):
            ends[:, end, channel] = _number(bits, at, width)
            at += width
    widths = [colour_bits] * 3 + [alpha_bits]
    if least:
        for end in range(2 * parts):
            ends[:, end] = ends[:, end] << 1 | bits[:, at + (end if least == "end" else end // 2), None]
        at += 2 * parts if least == "end" else parts
        widths = [width + 1 if width else 0 for width in widths]
    for channel, width in enumerate(widths):
        if width:
            value = ends[..., channel] << (8 - width)
            ends[..., channel] = value | value >> width
    if not alpha_bits:
        ends[..., 3] = 255
    part, short = _partition(parts, partition, count)
    numbers, at = _indices(bits, at, first, short)
    others = numbers
    if second:
        others, at = _indices(bits, at, second, numpy.arange(16)[None] == numpy.zeros((count, 1)))
    rows = numpy.arange(count)[:, None]
    low, high = ends[rows, 2 * part], ends[rows, 2 * part + 1]
    weight = numpy.asarray(_WEIGHTS[first])[numbers]
    other = numpy.asarray(_WEIGHTS[second or first])[others]
    swapped = selection[:, None] == 1
    colour, alpha = numpy.where(swapped, other, weight), numpy.where(swapped, weight, other)
    weights = numpy.stack([colour, colour, colour, alpha], -1)
    texels = ((64 - weights) * low + weights * high + 32) >> 6
    for channel in range(3):
        turned = rotation == channel + 1
        texels[turned, :, channel], texels[turned, :, 3] = texels[turned, :, 3], texels[turned, :, channel]
    return texels


def _partition(parts, partition, count):
    """(the part of each texel, whether its index is a bit short) of each block."""
    part, short = numpy.zeros((count, 16), numpy.int64), numpy.zeros((count, 16), bool)
    short[:, 0] = True
    if parts > 1:
        width = parts - 1
        words = numpy.array([int(word, 16) for word in (_TWO if parts == 2 else _THREE).split()], numpy.int64)
        part = words[partition][:, None] >> (width * numpy.arange(16)) & ((1 << width) - 1)
        for fixed in ((_FIXED_OF_TWO,) if parts == 2 else _FIXED_OF_THREE):
            short[numpy.arange(count), numpy.array([int(digit, 16) for digit in fixed])[partition]] = True
    return part, short


def _indices(bits, at, width, short):
    """(16 numbers of each block, the bit after them)."""
    begins = at + numpy.cumsum(width - short, axis=1) - (width - short)
    rows, numbers = numpy.arange(len(bits))[:, None], numpy.zeros((len(bits), 16), numpy.int64)
    for i in range(width):
        held = bits[rows, numpy.minimum(begins + i, 127)]
        numbers |= numpy.where(short & (i == width - 1), 0, held << i)
    return numbers, at + 16 * width - int(short[0].sum())
