"""Reads and writes .spcap captures: the frames an application drew, with their buffers, textures and materials.

    import subpixel_capture as spcap

    capture = spcap.read("park.spcap")
    for draw in capture.frames[0].draws:
        print(draw.name, spcap.triangle_count(capture, draw))
    positions = spcap.stream_values(capture, draw.position, draw.vertex_count)   # a numpy array where there is numpy

    spcap.write(capture, "again.spcap")

The records are those of capture_format/capture.hpp, field for field; capture_format/SPEC.md has the conventions and the
bytes. Errors are CaptureError, whose text says what is wrong and where. Writing needs the standard library alone and
works from Python 3.6 on: files are of version 2, or 3 where one has strips, fans or
formats of it, with CRC-32 checksums and zlib. Reading what Subpixel itself wrote
needs libxxhash and libzstd (module codecs).
"""
from .checks import check_capture
from .errors import CaptureError
from .model import (NONE, Buffer, Capture, DirectionalLight, Draw, Frame, Material, Metadata, PointLight, Sampler,
                    SpotCone, Texture, UvMapping, VertexStream, AlphaMode, ClipDepth, IndexType, MipFilter,
                    TexelFilter, TextureEncoding, Topology, VertexFormat, Wrap, IDENTITY)
from .reader import decode, read
from .streams import draw_indices, element_bytes, component_count, stream_values, triangle_count
from .summary import summarize
from .writer import encode, write

__all__ = ["NONE", "Buffer", "Capture", "DirectionalLight", "Draw", "Frame", "Material", "Metadata", "PointLight",
           "Sampler", "SpotCone", "Texture", "UvMapping", "VertexStream", "AlphaMode", "ClipDepth", "IndexType",
           "MipFilter", "TexelFilter", "TextureEncoding", "Topology", "VertexFormat", "Wrap", "IDENTITY", "CaptureError",
           "check_capture", "decode", "read", "encode", "write", "draw_indices", "element_bytes", "component_count",
           "stream_values", "summarize", "triangle_count"]
