"""Textures to image files or texels that a capture holds.

Block-compressed ones go as the DDS file that RenderDoc saves, which OpenImageIO decodes when the capture is replayed;
8-bit ones as texels; all others as the PNG that RenderDoc converts them to.
"""
import os
import re
import struct
import tempfile

from subpixel_capture import Sampler, Texture, TextureEncoding

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
    save = rd.TextureSave()
    save.resourceId = resource
    save.mip, save.slice.sliceIndex, save.sample.sampleIndex = 0, 0, 0
    is_block = form.type in (kinds.BC1, kinds.BC2, kinds.BC3, kinds.BC4, kinds.BC5, kinds.BC6, kinds.BC7)
    save.destType = rd.FileType.DDS if is_block else rd.FileType.PNG
    save.alpha = rd.AlphaMapping.Preserve
    folder = tempfile.mkdtemp(prefix="subpixel-texture.")
    path = os.path.join(folder, "texture")
    try:
        replay.controller.SaveTexture(save, path)
        if not os.path.exists(path) or os.path.getsize(path) == 0:
            return None, "RenderDoc does not save {}".format(form.Name())
        with open(path, "rb") as file:
            texture.bytes = file.read()
    finally:
        if os.path.exists(path):
            os.unlink(path)
        os.rmdir(folder)
    texture.encoding = TextureEncoding.IMAGE_FILE
    return texture, ""


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


def has_alpha(texture):
    """Whether any texel of an rgba8 texture is not opaque; None where the bytes are an image file."""
    if texture.encoding != TextureEncoding.RGBA8:
        return None
    return texture.bytes[3::4].count(b"\xff") != len(texture.bytes) // 4


def cutoff(source):
    """(whether a fragment shader discards, the alpha below which it does or None)."""
    if not re.search(r"\bdiscard\b|OpKill|\bKill\b|OpDemoteToHelper|\bclip\s*\(|\bdiscard_(n?z)\b", source):
        return False, None
    number = r"([0-9]*\.[0-9]+|[0-9]+\.?)f?"
    for pattern in (r"(?:\.a|\.w|alpha)\s*\)?\s*<=?\s*" + number, r"clip\s*\([^;]*?(?:\.a|\.w|alpha)\s*-\s*" + number,
                    r"<=?\s*" + number + r"[^;{]{0,40}\{?\s*(?:discard|Kill)"):
        found = re.search(pattern, source, re.I)
        if found and 0.0 < float(found.group(1)) <= 1.0:
            return True, float(found.group(1))
    return True, None
