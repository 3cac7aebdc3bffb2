"""What `subpixel info --json` says of a capture, but for hash, size of the file and features."""


from .streams import triangle_count


def _triangles(capture, frame):
    return sum(triangle_count(capture, draw) for draw in frame.draws)


def summarize(capture):
    """A dictionary whose keys and values are those of `subpixel info --json`."""
    metadata = capture.metadata
    return {
        "title": metadata.title, "application": metadata.application, "tool": metadata.tool,
        "licence": metadata.licence, "metres_per_unit": metadata.metres_per_unit, "notices": list(metadata.notices),
        "frame_count": len(capture.frames),
        "width": capture.frames[0].width if capture.frames else 0,
        "height": capture.frames[0].height if capture.frames else 0,
        "triangles": max([_triangles(capture, frame) for frame in capture.frames] or [0]),
        "draws": max([len(frame.draws) for frame in capture.frames] or [0]),
        "point_lights": max([len(frame.point_lights) for frame in capture.frames] or [0]),
        "buffers": {"count": len(capture.buffers), "bytes": sum(len(b.bytes) for b in capture.buffers)},
        "textures": {"count": len(capture.textures), "bytes": sum(len(t.bytes) for t in capture.textures)},
        "materials": len(capture.materials),
        "frames": [{"name": frame.name, "time_s": frame.time_s, "width": frame.width, "height": frame.height,
                    "draws": len(frame.draws), "triangles": _triangles(capture, frame),
                    "point_lights": len(frame.point_lights)} for frame in capture.frames],
    }
