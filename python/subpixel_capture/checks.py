"""The rules of SPEC.md on a capture's values, for reader and writer alike. The first broken one raises CaptureError."""
import math

from . import layout
from .errors import CaptureError
from .model import NONE, AlphaMode, ClipDepth, IndexType, MipFilter, TextureEncoding, Topology, VertexFormat
from .streams import element_bytes, index_bytes, most_triangles, raw_indices, restart_index

_COLOUR_FORMATS = (VertexFormat.FLOAT32X3, VertexFormat.FLOAT32X4, VertexFormat.FLOAT16X4, VertexFormat.UNORM8X4,
                   VertexFormat.UNORM16X4, VertexFormat.UNORM10X3_2, VertexFormat.FLOAT11X2_10, VertexFormat.FLOAT16X3)


class Checker:
    """Raises with `what`, the broken rule and `part`, field."""

    def __init__(self, what):
        self.what = what
        self.part = ""
        self.known_bounds = {}

    def fail(self, field, why):
        raise CaptureError(self.what, why, "{}{}field {}".format(self.part, ", " if self.part else "", field))

    def require(self, truth, field, why):
        if not truth:
            self.fail(field, why)

    def text(self, field, value):
        try:
            size = len(value.encode("utf-8"))
        except UnicodeEncodeError:
            self.fail(field, "not UTF-8")
        self.require(size <= layout.MOST_TEXT_BYTES, field, "longer than 65536 bytes")

    def finite(self, field, values, count=None):
        self.require(count is None or len(values) == count, field, "not {} numbers".format(count))
        self.require(all(math.isfinite(v) for v in values), field, "not finite")

    def not_negative(self, field, values, count=None):
        self.finite(field, values, count)
        self.require(all(v >= 0 for v in values), field, "negative")

    def unit(self, field, values):
        self.require(all(0 <= v <= 1 for v in values), field, "outside 0 to 1")

    def enumeration(self, field, value, last, what):
        self.require(0 <= value <= last, field, "{} is no {}".format(value, what))

    def side(self, field, value):
        self.require(1 <= value <= layout.MOST_SIDE, field, "{} is outside 1 to {}".format(value, layout.MOST_SIDE))

    def metadata(self, metadata):
        for field in ("title", "application", "tool", "licence"):
            self.text(field, getattr(metadata, field))
        scale = metadata.metres_per_unit
        self.require(math.isfinite(scale) and scale > 0, "metres_per_unit", "not a positive number")
        self.require(len(metadata.notices) <= layout.MOST_NOTICES, "notices",
                     "{} are more than {}".format(len(metadata.notices), layout.MOST_NOTICES))
        for i, notice in enumerate(metadata.notices):
            self.text("notices[{}]".format(i), notice)

    def texture(self, texture):
        self.text("name", texture.name)
        sampler = texture.sampler
        self.enumeration("sampler.wrap_u", sampler.wrap_u, 2, "wrap")
        self.enumeration("sampler.wrap_v", sampler.wrap_v, 2, "wrap")
        self.enumeration("sampler.magnify", sampler.magnify, 1, "texel filter")
        self.enumeration("sampler.minify", sampler.minify, 1, "texel filter")
        self.enumeration("sampler.mip", sampler.mip, MipFilter.NEAREST_OF_MEANS, "mip filter")
        self.enumeration("encoding", texture.encoding, TextureEncoding.IMAGE_FILE, "texture encoding")
        if texture.encoding == TextureEncoding.IMAGE_FILE:
            self.require(texture.width == 0 and texture.height == 0, "width", "set on a texture that is an image file")
            self.require(len(texture.bytes) > 0, "bytes", "empty")
            return
        self.side("width", texture.width)
        self.side("height", texture.height)
        needed = 4 * texture.width * texture.height
        self.require(len(texture.bytes) == needed, "bytes",
                     "{} bytes instead of {}".format(len(texture.bytes), needed))

    def material(self, material, texture_count):
        self.text("name", material.name)
        self.unit("base_colour", material.base_colour)
        for field in ("alpha_cutoff", "metallic", "roughness"):
            self.unit(field, (getattr(material, field),))
        self.not_negative("emissive", material.emissive, 3)
        self.enumeration("alpha_mode", material.alpha_mode, AlphaMode.BLEND, "alpha mode")
        self.finite("normal_scale", (material.normal_scale,))
        for name in ("base_colour", "metallic_roughness", "normal", "emissive"):
            mapping = getattr(material, name + "_uv")
            self.require(mapping.set in (0, 1), name + "_uv.set", "{} is neither 0 nor 1".format(mapping.set))
            self.finite(name + "_uv.matrix", mapping.matrix, 6)
            number = getattr(material, name + "_texture")
            self.require(number == NONE or 0 <= number < texture_count, name + "_texture",
                         "{} is not below {}".format(number, texture_count))

    def frame(self, frame):
        self.text("name", frame.name)
        self.finite("time_s", (frame.time_s,))
        self.finite("view", frame.view, 16)
        self.finite("projection", frame.projection, 16)
        self.enumeration("clip_depth", frame.clip_depth, ClipDepth.MINUS_ONE_TO_ONE, "clip depth")
        self.side("width", frame.width)
        self.side("height", frame.height)
        self.not_negative("exposure", (frame.exposure,))
        self.not_negative("sky", frame.sky, 3)
        self.not_negative("ambient", frame.ambient, 3)
        if frame.sun is not None:
            self.finite("sun.direction", frame.sun.direction, 3)
            self.require(any(frame.sun.direction), "sun.direction", "of length 0")
            self.not_negative("sun.irradiance", frame.sun.irradiance, 3)
        self.require(len(frame.point_lights) <= layout.MOST_LIGHTS, "point_lights", "too many")
        for i, light in enumerate(frame.point_lights):
            name = "point_lights[{}].".format(i)
            self.finite(name + "position", light.position, 3)
            self.not_negative(name + "intensity", light.intensity, 3)
            self.require(math.isfinite(light.range) and light.range > 0, name + "range", "not a positive number")
            if light.cone is not None:
                self._cone(name + "cone.", light.cone)

    def _cone(self, name, cone):
        self.finite(name + "direction", cone.direction, 3)
        self.require(any(cone.direction), name + "direction", "of length 0")
        for field in ("inner_cosine", "outer_cosine"):
            self.require(-1 <= getattr(cone, field) <= 1, name + field, "outside -1 to 1")
        self.require(cone.inner_cosine > cone.outer_cosine, name + "inner_cosine", "not above outer_cosine")

    def draw(self, capture, draw):
        self.text("name", draw.name)
        self.require(0 <= draw.material < len(capture.materials), "material",
                     "{} is not below {}".format(draw.material, len(capture.materials)))
        self.require(draw.position.buffer != NONE, "position.buffer", "a draw needs positions")
        for name in ("position", "normal", "uv", "tangent", "uv2", "colour"):
            self._stream(capture, draw, getattr(draw, name), name)
        if draw.colour.buffer != NONE:
            self.require(draw.colour.format in _COLOUR_FORMATS, "colour.format",
                         "{} is no format of colours".format(draw.colour.format))
        self._indices(capture, draw)
        self._instances(capture, draw)

    def _stream(self, capture, draw, stream, name):
        if stream.buffer == NONE:
            return
        self.require(0 <= stream.buffer < len(capture.buffers), name + ".buffer",
                     "{} is not below {}".format(stream.buffer, len(capture.buffers)))
        self.enumeration(name + ".format", stream.format, VertexFormat.SNORM16X2, "vertex format")
        size = element_bytes(stream.format)
        self.require(stream.stride >= size or (stream.stride == 0 and name != "position"), name + ".stride",
                     "{} bytes is less than an element".format(stream.stride))
        available = len(capture.buffers[stream.buffer].bytes)
        if draw.vertex_count:
            end = stream.offset + (draw.vertex_count - 1) * stream.stride + size
            self.require(end <= available, name + ".offset",
                         "{} vertices at byte {} leave the buffer's {} bytes".format(draw.vertex_count, stream.offset,
                                                                                     available))

    def _indices(self, capture, draw):
        self.enumeration("topology", draw.topology, Topology.TRIANGLE_FAN, "topology")
        is_list = draw.topology == Topology.TRIANGLE_LIST
        self.require(not is_list or draw.index_count % 3 == 0, "index_count",
                     "{} is no multiple of 3".format(draw.index_count))
        self.require(not draw.restart or not (is_list or draw.index_type == IndexType.NONE), "restart",
                     "set on a draw that is no indexed strip or fan")
        if draw.index_type == IndexType.NONE:
            self.require(draw.index_buffer == NONE, "index_buffer", "set on a draw without indices")
            last = draw.base_vertex + draw.index_count
            self.require(draw.base_vertex >= 0 and last <= draw.vertex_count, "index_count",
                         "vertices {} to {} are not all among the {}".format(draw.base_vertex, last,
                                                                            draw.vertex_count))
            return
        self.enumeration("index_type", draw.index_type, IndexType.UINT8, "index type")
        self.require(0 <= draw.index_buffer < len(capture.buffers), "index_buffer",
                     "{} is not below {}".format(draw.index_buffer, len(capture.buffers)))
        size = index_bytes(draw.index_type)
        available = len(capture.buffers[draw.index_buffer].bytes)
        self.require(draw.index_offset + size * draw.index_count <= available, "index_offset",
                     "{} indices at byte {} leave the buffer's {} bytes".format(draw.index_count, draw.index_offset,
                                                                               available))
        if draw.index_count == 0:
            return
        key = (draw.index_buffer, draw.index_type, draw.index_offset, draw.index_count, draw.restart)
        if key not in self.known_bounds:
            values = raw_indices(capture, draw)
            if draw.restart:
                cut = restart_index(draw.index_type)
                values = values[values != cut] if hasattr(values, "min") else [v for v in values if v != cut]
            self.known_bounds[key] = None if len(values) == 0 else (
                int(values.min()) if hasattr(values, "min") else min(values),
                int(values.max()) if hasattr(values, "max") else max(values))
        if self.known_bounds[key] is None:
            return  # nothing but restarts
        low, high = self.known_bounds[key]
        self.require(low + draw.base_vertex >= 0 and high + draw.base_vertex < draw.vertex_count, "index_buffer",
                     "vertices {} to {} are not all among the {}".format(low + draw.base_vertex,
                                                                        high + draw.base_vertex, draw.vertex_count))

    def _instances(self, capture, draw):
        if draw.instance_buffer == NONE:
            self.require(draw.instance_count == 1, "instance_count", "must be 1 without an instance buffer")
            return
        self.require(0 <= draw.instance_buffer < len(capture.buffers), "instance_buffer",
                     "{} is not below {}".format(draw.instance_buffer, len(capture.buffers)))
        available = len(capture.buffers[draw.instance_buffer].bytes)
        self.require(draw.instance_offset + 64 * draw.instance_count <= available, "instance_offset",
                     "{} matrices at byte {} leave the buffer's {} bytes".format(draw.instance_count,
                                                                                draw.instance_offset, available))

    def frame_draws(self, frame):
        self.require(len(frame.draws) <= layout.MOST_DRAWS, "draws", "too many")
        triangles = sum(most_triangles(draw) for draw in frame.draws)
        self.require(triangles <= layout.MOST_TRIANGLES, "draws", "more than {} triangles".format(
            layout.MOST_TRIANGLES))


def check_capture(capture, what="can't write the capture"):
    """Raises CaptureError for the first value that SPEC.md does not allow."""
    checker = Checker(what)
    for name, most in layout.MOST_OF.items():
        count = len(getattr(capture, name))
        if count > most:
            raise CaptureError(what, "{} are more than {}".format(count, most), name)
    checker.part = "metadata"
    checker.metadata(capture.metadata)
    for i, held in enumerate(capture.buffers):
        checker.part = "buffer {}".format(i)
        checker.text("name", held.name)
    for i, texture in enumerate(capture.textures):
        checker.part = "texture {}".format(i)
        checker.texture(texture)
    for i, material in enumerate(capture.materials):
        checker.part = "material {}".format(i)
        checker.material(material, len(capture.textures))
    for f, frame in enumerate(capture.frames):
        checker.part = "frame {}".format(f)
        checker.frame(frame)
        checker.frame_draws(frame)
        for d, draw in enumerate(frame.draws):
            checker.part = "frame {}, draw {}".format(f, d)
            checker.draw(capture, draw)
