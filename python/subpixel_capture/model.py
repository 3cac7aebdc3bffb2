"""What a capture is, in memory: capture_format/capture.hpp in Python. Units and conventions are those of SPEC.md."""

NONE = 0xFFFFFFFF  # "no such resource" in an index field
IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)


class TextureEncoding:
    RGBA8, IMAGE_FILE = 0, 1


class Wrap:
    REPEAT, CLAMP_TO_EDGE, MIRRORED_REPEAT = 0, 1, 2


class TexelFilter:
    LINEAR, NEAREST = 0, 1


class MipFilter:
    LINEAR, NEAREST, NONE, LINEAR_OF_MEANS, NEAREST_OF_MEANS = 0, 1, 2, 3, 4


class AlphaMode:
    OPAQUE, TEST, BLEND = 0, 1, 2


class IndexType:
    NONE, UINT16, UINT32, UINT8 = 0, 1, 2, 3


class Topology:
    TRIANGLE_LIST, TRIANGLE_STRIP, TRIANGLE_FAN = 0, 1, 2


class ClipDepth:
    ZERO_TO_ONE, ONE_TO_ZERO, MINUS_ONE_TO_ONE = 0, 1, 2


class VertexFormat:
    FLOAT32X2, FLOAT32X3, FLOAT32X4, FLOAT16X2, FLOAT16X4, SNORM8X4, SNORM16X4, UNORM16X2, UNORM8X4, UNORM16X4, \
        OCTAHEDRAL_SNORM8, OCTAHEDRAL_SNORM16, SNORM10X3_2, UNORM10X3_2, FLOAT11X2_10, FLOAT16X3, SNORM16X2 = range(17)


class Record:
    """Fields with defaults; equal when all fields are."""

    DEFAULTS = ()  # (name, default or a function that makes one)

    def __init__(self, **values):
        for name, default in self.DEFAULTS:
            value = values.pop(name) if name in values else default() if callable(default) else default
            setattr(self, name, value)
        if values:
            raise TypeError("{} has no field {}".format(type(self).__name__, ", ".join(sorted(values))))

    def __eq__(self, other):
        return type(self) is type(other) and all(
            getattr(self, name) == getattr(other, name) for name, _ in self.DEFAULTS)

    __hash__ = None

    def __repr__(self):
        shown = []
        for name, _ in self.DEFAULTS:
            value = getattr(self, name)
            is_long = isinstance(value, (bytes, bytearray, memoryview)) and len(value) > 16
            shown.append("{}={}".format(name, "<{} bytes>".format(len(value)) if is_long else repr(value)))
        return "{}({})".format(type(self).__name__, ", ".join(shown))


class Metadata(Record):
    """Texts; `application` is what was recorded, `tool` what recorded it, `notices` what was left out."""
    DEFAULTS = (("title", ""), ("application", ""), ("tool", ""), ("licence", ""), ("metres_per_unit", 1.0),
                ("notices", list))


class Buffer(Record):
    """Bytes that vertex streams, indices and instance matrices point into."""
    DEFAULTS = (("name", ""), ("bytes", b""))


class Sampler(Record):
    DEFAULTS = (("wrap_u", Wrap.REPEAT), ("wrap_v", Wrap.REPEAT), ("magnify", TexelFilter.LINEAR),
                ("minify", TexelFilter.LINEAR), ("mip", MipFilter.LINEAR))


class Texture(Record):
    """Texels of rgba8, top row first; or an image file as it is on disk, with width and height 0."""
    DEFAULTS = (("name", ""), ("encoding", TextureEncoding.RGBA8), ("srgb", False), ("width", 0), ("height", 0),
                ("bytes", b""), ("sampler", Sampler))


class UvMapping(Record):
    DEFAULTS = (("set", 0), ("matrix", (1.0, 0.0, 0.0, 0.0, 1.0, 0.0)))


class Material(Record):
    """glTF 2.0's metallic-roughness; colours are linear, texture numbers NONE where there is none."""
    DEFAULTS = (("name", ""), ("base_colour", (1.0, 1.0, 1.0, 1.0)), ("base_colour_texture", NONE),
                ("alpha_mode", AlphaMode.OPAQUE), ("alpha_cutoff", 0.5), ("metallic", 0.0), ("roughness", 0.8),
                ("metallic_roughness_texture", NONE), ("normal_texture", NONE), ("emissive", (0.0, 0.0, 0.0)),
                ("emissive_texture", NONE), ("two_sided", False), ("normal_scale", 1.0), ("unlit", False),
                ("base_colour_uv", UvMapping), ("metallic_roughness_uv", UvMapping), ("normal_uv", UvMapping),
                ("emissive_uv", UvMapping))


class VertexStream(Record):
    """Element i of an attribute starts at byte `offset + i * stride` of buffer `buffer`; NONE: absent."""
    DEFAULTS = (("buffer", NONE), ("format", VertexFormat.FLOAT32X3), ("offset", 0), ("stride", 0))


class Draw(Record):
    """One draw; `index_count` counts indices, or vertices of a draw without. Strips and fans stay what they are here:
    draw_indices() makes lists of them."""
    DEFAULTS = (("name", ""), ("material", 0), ("position", VertexStream), ("normal", VertexStream),
                ("uv", VertexStream), ("tangent", VertexStream), ("index_type", IndexType.NONE),
                ("index_buffer", NONE), ("index_offset", 0), ("index_count", 0), ("base_vertex", 0),
                ("vertex_count", 0), ("transform", IDENTITY), ("instance_buffer", NONE), ("instance_offset", 0),
                ("instance_count", 1), ("uv2", VertexStream), ("colour", VertexStream),
                ("topology", Topology.TRIANGLE_LIST), ("restart", False))


class DirectionalLight(Record):
    DEFAULTS = (("direction", (0.0, -1.0, 0.0)), ("irradiance", (3.0, 3.0, 3.0)), ("shadows", True))


class SpotCone(Record):
    DEFAULTS = (("direction", (0.0, -1.0, 0.0)), ("inner_cosine", 1.0), ("outer_cosine", 0.0))


class PointLight(Record):
    DEFAULTS = (("position", (0.0, 0.0, 0.0)), ("intensity", (1.0, 1.0, 1.0)), ("range", 10.0), ("cone", None))


class Frame(Record):
    """Matrices are column-major tuples of 16; `sun` is a DirectionalLight or None."""
    DEFAULTS = (("name", ""), ("time_s", 0.0), ("view", IDENTITY), ("projection", IDENTITY),
                ("clip_depth", ClipDepth.ONE_TO_ZERO), ("clip_y_up", False), ("width", 1280), ("height", 720),
                ("exposure", 1.0), ("sky", (0.35, 0.5, 0.75)), ("ambient", (0.3, 0.35, 0.4)), ("sun", None),
                ("point_lights", list), ("draws", list))


class Capture(Record):
    DEFAULTS = (("metadata", Metadata), ("buffers", list), ("textures", list), ("materials", list),
                ("frames", list))
