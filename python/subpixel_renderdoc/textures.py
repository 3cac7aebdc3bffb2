"""Textures to image files or texels that a capture holds.

Block-compressed ones go as DDS files of the blocks as they are, which OpenImageIO decodes when the capture is replayed;
others are converted to 8-bit texels here. RenderDoc's own conversions would draw, which costs a replay and shows nothing
where the driver is told to leave pixels out (cli/renderdoc_import.cpp).
"""
import re
import struct

from subpixel_capture import MipFilter, Sampler, Texture, TextureEncoding

from .formats import AttributeFormat

try:
    import numpy
    from . import blocks
except ImportError:  # qrenderdoc's own Python has none
    pass

_OF_MEANS = {MipFilter.LINEAR: MipFilter.LINEAR_OF_MEANS, MipFilter.NEAREST: MipFilter.NEAREST_OF_MEANS}
ROLES = ("base_colour", "normal", "metallic_roughness", "emissive")

# By name, first match first; slots in their order where no name tells.
NAMES = {
    "base_colour": (r"albedo|diffuse|base_?colou?r|map_?kd|_baseMap|mainTex", r"colou?r_?(map|tex)|^colou?r",
                    r"^(u_?)?tex(ture)?_?(0|layer_?0|2d)?$|^(t|s|texture|sampler)0$|sampler2D0"),
    "normal": (r"normal|bump|_nrm|norm_?map|^nm$",),
    "metallic_roughness": (r"metal|rough|_orm|occlusionRoughness|pbr",),
    "emissive": (r"emiss|glow|self_?illum",),
}
NEVER = r"shadow|depth|light_?map|lut|noise|env|cube|irradiance|brdf|ssao|mask|tcmask|gbuffer|history|specular"


def choose(bound, textures, mapping, is_target):
    """Role -> (name, slot, resource id) of the bound textures. `mapping`: role -> list of names (regular expressions)
    or slots of the user's, asked first."""
    chosen, left = {}, []
    for entry in bound:
        texture = textures[str(entry[2])]
        if texture.cubemap or texture.depth > 1 or texture.arraysize > 1 or is_target(entry[2]):
            continue
        left.append(entry)
    for role in ROLES:
        for wanted in mapping.get(role, []):
            for entry in left:
                hit = entry[1] == wanted if isinstance(wanted, int) else re.search(wanted, entry[0])
                if hit and role not in chosen and entry not in chosen.values():
                    chosen[role] = entry
    for role in ("normal", "metallic_roughness", "emissive", "base_colour"):
        if role in chosen or role in mapping:
            continue
        for pattern in NAMES[role]:
            found = [e for e in left if re.search(pattern, e[0], re.I) and e not in chosen.values()
                     and (role == "normal" or not re.search(NEVER, e[0], re.I))]
            if found:
                chosen[role] = min(found, key=lambda e: e[1])
                break
    if "base_colour" not in chosen and "base_colour" not in mapping:
        rest = [e for e in left if e not in chosen.values() and not re.search(NEVER, e[0], re.I)
                and not any(re.search(p, e[0], re.I) for role in ROLES[1:] for p in NAMES[role])]
        if rest:
            chosen["base_colour"] = min(rest, key=lambda e: e[1])
    return chosen


def read(replay, resource, role, sampler):
    """A Texture of the resource's first level, or (None, reason)."""
    rd = replay.rd
    description = replay.textures[str(resource)]
    form = description.format
    srgb = role in ("base_colour", "emissive")
    texture = Texture(srgb=srgb, sampler=Sampler(**dict(zip(("wrap_u", "wrap_v", "magnify", "minify", "mip"), sampler)))
                      if sampler else Sampler())
    if role == "base_colour":  # alpha tests read levels that applications rarely make for them
        texture.sampler.mip = _OF_MEANS.get(texture.sampler.mip, texture.sampler.mip)
    kinds = rd.ResourceFormatType
    if max(description.width, description.height) > 16384:
        return None, "larger than 16384 texels"
    if form.type == kinds.Regular and form.compByteWidth == 1 and form.compType in (rd.CompType.UNorm,
                                                                                   rd.CompType.UNormSRGB):
        data = bytes(replay.controller.GetTextureData(resource, rd.Subresource(0, 0, 0)))
        texels = _rgba(data, form.compCount, form.BGRAOrder())
        if len(texels) >= 4 * description.width * description.height:
            texture.width, texture.height = description.width, description.height
            texture.bytes = texels[:4 * description.width * description.height]
            return texture, ""
    blocks = _blocks(kinds, form.type)
    if blocks:
        data = bytes(replay.controller.GetTextureData(resource, rd.Subresource(0, 0, 0)))
        signed = form.compType in (rd.CompType.SNorm, rd.CompType.SInt)
        texture.bytes = _dds(description.width, description.height, blocks, signed, data)
        texture.encoding = TextureEncoding.IMAGE_FILE
        return texture, ""
    texels = _converted(rd, form, replay.controller.GetTextureData(resource, rd.Subresource(0, 0, 0)),
                        description.width * description.height)
    if texels is None:
        return None, "its format {} is not known here".format(form.Name())
    texture.srgb = srgb and form.compType != rd.CompType.Float
    texture.width, texture.height, texture.bytes = description.width, description.height, texels
    return texture, ""


def _converted(rd, form, data, count):
    """RGBA texels of 8 bits of `count` texels in another format; None where the format is not known."""
    data, kinds = bytes(data), rd.ResourceFormatType
    packed = {kinds.R5G6B5: (5, 6, 5, 0), kinds.R5G5B5A1: (5, 5, 5, 1), kinds.R4G4B4A4: (4, 4, 4, 4)}.get(form.type)
    if packed and len(data) >= 2 * count:
        return _unpacked(struct.unpack("<%dH" % count, data[:2 * count]), packed, form.BGRAOrder())
    if form.type not in (kinds.Regular, kinds.R10G10B10A2) or form.compType not in (
            rd.CompType.Float, rd.CompType.UNorm, rd.CompType.SNorm, rd.CompType.UNormSRGB):
        return None
    element = AttributeFormat(rd, form)
    if element.bytes == 0 or len(data) < element.bytes * count:
        return None
    out = bytearray(b"\xff") * (4 * count)
    for i, value in enumerate(element.decode(data, 0, element.bytes, count)):
        if len(value) == 1:
            value = value * 3
        for c, v in enumerate(value):
            out[4 * i + c] = int(255.0 * min(max(v, 0.0), 1.0) + 0.5) if v == v else 0
        if len(value) == 2:
            out[4 * i + 2] = 0
    return bytes(out)


def _unpacked(words, bits, alpha_first):
    """Texels of 16-bit words with red in the highest bits, alpha in the lowest or, with `alpha_first`, before red."""
    red, green, blue, alpha = bits
    out = bytearray(b"\xff") * (4 * len(words))
    for i, word in enumerate(words):
        if alpha and alpha_first:
            word = (word << alpha | word >> (16 - alpha)) & 0xFFFF
        shift = 16
        for c, size in enumerate((red, green, blue, alpha)):
            if size:
                shift -= size
                out[4 * i + c] = (word >> shift & ((1 << size) - 1)) * 255 // ((1 << size) - 1)
    return bytes(out)


def _blocks(kinds, kind):
    """(bytes of a 4x4 block, FourCC, DXGI format where there is no FourCC) of a block-compressed type, or None."""
    return {kinds.BC1: (8, b"DXT1", 0), kinds.BC2: (16, b"DXT3", 0), kinds.BC3: (16, b"DXT5", 0),
            kinds.BC4: (8, b"ATI1", 0), kinds.BC5: (16, b"ATI2", 0), kinds.BC6: (16, b"DX10", 95),
            kinds.BC7: (16, b"DX10", 98)}.get(kind)


def _dds(width, height, blocks, signed, data):
    """A DDS file of one level (Microsoft, "Programming guide for DDS")."""
    block_bytes, code, dxgi = blocks
    size = (width + 3) // 4 * ((height + 3) // 4) * block_bytes
    head = struct.pack("<4s7I44x", b"DDS ", 124, 0x81007, height, width, size, 0, 0)
    # Of two channels OpenImageIO works out the third where the file says that it is a normal map, and else takes them
    # for grey and alpha.
    flags = 0x4 | (0x80000000 if code == b"ATI2" else 0)
    head += struct.pack("<2I4s5I", 32, flags, code, 0, 0, 0, 0, 0) + struct.pack("<5I", 0x1000, 0, 0, 0, 0)
    if code == b"DX10":
        head += struct.pack("<5I", dxgi + (1 if signed and dxgi == 95 else 0), 3, 0, 1, 0)
    return head + data[:size]


def _rgba(data, components, is_bgra):
    """Tightly packed 8-bit texels to RGBA: missing colours are 0 (one component: grey), missing alpha 255."""
    count = len(data) // components
    out = bytearray(b"\xff") * (4 * count)
    if components == 1:
        out[0::4] = out[1::4] = out[2::4] = data[:count]
        return bytes(out)
    out[2::4] = bytes(count)
    for c in range(components):
        out[c::4] = data[c:components * count:components]
    if is_bgra and components >= 3:
        out[0::4], out[2::4] = out[2::4], out[0::4]
    return bytes(out)


def texels(texture):
    """An array (height, width, 4) of bytes; None where the texture's format is not decoded here. Needs numpy."""
    if texture.encoding == TextureEncoding.IMAGE_FILE:
        return blocks.from_dds(texture.bytes)
    return numpy.frombuffer(texture.bytes, numpy.uint8).reshape(texture.height, texture.width, 4)


def read_at(source, name):
    """What a fragment shader's source or disassembly reads a texture of this name at: a variable's name, or None where
    it is not one."""
    held = re.search(r"(_\d+) = \*{};".format(re.escape(name)), source)
    if held:
        found = re.search(r"ImageSample\w*\({}, (_\d+)\b".format(held.group(1)), source)
        found = found and re.search(r"{} = \*(?:\w+\.)*(\w+);".format(found.group(1)), source)
    else:
        found = re.search(r"\btexture\w*\s*\(\s*{}\s*,\s*(?:\w+\.)?(\w+)\s*(?:\.(?:xy|st)\s*)?[,)]".format(
            re.escape(name)), source)
    return found.group(1) if found else None


def has_alpha(texture):
    """Whether any texel of an rgba8 texture is not opaque; None where the bytes are an image file."""
    if texture.encoding != TextureEncoding.RGBA8:
        return None
    return texture.bytes[3::4].count(b"\xff") != len(texture.bytes) // 4


def is_one_colour(texture):
    """Whether all texels of an rgba8 texture are the same, alpha aside; False where the bytes are an image file."""
    if texture.encoding != TextureEncoding.RGBA8:
        return False
    return all(len(set(texture.bytes[c::4])) <= 1 for c in range(3))


_COMPARED = re.compile(r"([A-Za-z_]\w*(?:\.\w+)*)\s*(==|!=|>=|<=|>|<)\s*(-?[0-9]+\.?[0-9]*)")
_OPERATIONS = {"==": lambda a, b: a == b, "!=": lambda a, b: a != b, ">=": lambda a, b: a >= b,
               "<=": lambda a, b: a <= b, ">": lambda a, b: a > b, "<": lambda a, b: a < b}


def _may_discard(source, constants):
    """False where each discard stands behind a constant that keeps it from happening: a comparison with a number or a
    flag, joined to the rest by "and"."""
    for found in re.finditer(r"\bdiscard\b", source):
        before = source[:found.start()]
        begin = before.rfind("if")
        condition = before[begin:] if begin >= 0 and not re.search("[;}]", before[begin:]) else ""
        if "||" in condition or not condition:
            return True
        known = [(_value(name, constants), op, float(number)) for name, op, number in _COMPARED.findall(condition)]
        stops = any(value is not None and not _OPERATIONS[op](value, number) for value, op, number in known)
        flags = re.findall(r"(?<![\w.!])([A-Za-z_]\w*(?:\.\w+)*)\s*(?=&&|\))", condition)
        if not stops and not any(_value(name, constants) == 0 for name in flags):
            return True
    return False


def _value(name, constants):
    """Of a constant by the name that a source gives it: with its block's instance before it, or without."""
    parts = name.split(".")
    for i in range(len(parts)):
        if ".".join(parts[i:]) in constants:
            return constants[".".join(parts[i:])]
    return None


class _Disassembly:
    """What RenderDoc's text of a SPIR-V module says of the conditions of its kills: names by their one assignment."""

    def __init__(self, source, constants):
        self.constants = constants
        self.thresholds = []
        self.values = dict(re.findall(r"(_\d+) = ([^;]+);", source))
        self.asked = set(re.findall(r"\bif\((_\d+)\)", source))
        self.kills = []
        for found in re.finditer(r"\bKill\(\)|DemoteToHelper", source):
            before = re.findall(r"\bif\(!?(_\d+)\)", source[:found.start()])
            self.kills.append(before[-1] if before else None)

    def resolved(self, name, depth=0):
        """The variable that a value was loaded from."""
        text = self.values.get(name, name).strip()
        if depth < 8 and re.match(r"[*&]?_\d+$", text):
            return self.resolved(text.lstrip("*&"), depth + 1)
        return text.lstrip("*&")

    def truth(self, name, depth=0):
        """Of a condition: True, False, or None where it depends on the fragment."""
        text = self.values.get(name, "")
        compared = re.match(r"(\w+) (==|!=|>=|<=|>|<) (-?[0-9.]+)$", text)
        if compared:
            value = _value(self.resolved(compared.group(1)), self.constants)
            number = float(compared.group(3))
            if value is not None:
                return _OPERATIONS[compared.group(2)](value, number)
            if compared.group(2) in ("<", "<="):
                self.thresholds.append(number)
            return None
        joined = re.match(r"Phi\((_\d+), (_\d+)\)$|(_\d+) (?:&&|\|\|) (_\d+)$", text)
        if joined and depth < 16:
            first, second = [part for part in joined.groups() if part]
            both = [self.truth(first, depth + 1), self.truth(second, depth + 1)]
            is_and = first in self.asked if "Phi" in text else "&&" in text
            if is_and:
                return False if False in both else True if both == [True, True] else None
            return True if True in both else False if both == [False, False] else None
        return None

    def discards(self):
        return any(kill is None or self.truth(kill) is not False for kill in self.kills)


def cutoff(source, constants):
    """(whether a fragment shader discards, the alpha below which it does or None). `constants`: name -> number."""
    if re.search(r"\bdiscard\b", source) and not _may_discard(source, constants):
        return False, None
    if not re.search(r"\bdiscard\b|OpKill|\bKill\b|OpDemoteToHelper|\bclip\s*\(|\bdiscard_(n?z)\b", source):
        return False, None
    if "SPIR-V" in source[:200]:
        module = _Disassembly(source, constants)
        if not module.discards():
            return False, None
        found = [t for t in module.thresholds if 0.0 < t <= 1.0]
        return True, found[0] if found else None
    number = r"([0-9]*\.[0-9]+|[0-9]+\.?)f?"
    for pattern in (r"(?:\.a|\.w|alpha)\s*\)?\s*<=?\s*" + number, r"clip\s*\([^;]*?(?:\.a|\.w|alpha)\s*-\s*" + number,
                    r"<=?\s*" + number + r"[^;{]{0,40}\{?\s*(?:discard|Kill)"):
        found = re.search(pattern, source, re.I)
        if found and 0.0 < float(found.group(1)) <= 1.0:
            return True, float(found.group(1))
    return True, None
