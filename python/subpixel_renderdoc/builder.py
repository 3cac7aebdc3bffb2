"""A capture that grows: equal buffers, textures and materials are held once, over all frames."""
import hashlib

from subpixel_capture import NONE, Buffer, Capture, Material, Metadata


class Builder:
    def __init__(self):
        self.capture = Capture(metadata=Metadata())
        self._buffers, self._textures, self._materials = {}, {}, {}
        self.texture_of = {}   # (resource, role, sampler) -> number or None, alpha, what to say; of one .rdc

    def buffer(self, data, name=""):
        """The number of a buffer of these bytes."""
        key = (len(data), hashlib.sha256(data).digest())
        if key not in self._buffers:
            self._buffers[key] = len(self.capture.buffers)
            self.capture.buffers.append(Buffer(name=name, bytes=bytes(data)))
        return self._buffers[key]

    def texture(self, texture):
        sampler = texture.sampler
        key = (hashlib.sha256(texture.bytes).digest(), texture.srgb, texture.encoding, texture.width, texture.height,
               sampler.wrap_u, sampler.wrap_v, sampler.magnify, sampler.minify, sampler.mip)
        if key not in self._textures:
            self._textures[key] = len(self.capture.textures)
            self.capture.textures.append(texture)
        return self._textures[key]

    def material(self, **values):
        material = Material(**values)
        values.pop("name", None)
        key = repr(sorted(values.items()))
        if key not in self._materials:
            self._materials[key] = len(self.capture.materials)
            self.capture.materials.append(material)
        return self._materials[key]

    def drop_unused_textures(self):
        """Leaves out what no material shows: textures of draws that others hide, or that were composed into one."""
        capture = self.capture
        fields = [name + "_texture" for name in ("base_colour", "normal", "metallic_roughness", "emissive")]
        used = sorted(set(getattr(m, field) for m in capture.materials for field in fields) - {NONE})
        moved = dict((old, new) for new, old in enumerate(used))
        for material in capture.materials:
            for field in fields:
                setattr(material, field, moved.get(getattr(material, field), NONE))
        capture.textures = [capture.textures[old] for old in used]
