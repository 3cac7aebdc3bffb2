"""How much of an imported frame lies where the application drew it.

    python3 -m subpixel_renderdoc.depth FRAME.rdc CAPTURE.spcap FRAME_NUMBER SUBPIXEL_BINARY OUT_FOLDER

replays a copy of the capture whose colours are the distances from the eye and compares them, pixel by pixel, with the
depth buffer that RenderDoc replays after the last draw that was taken. Prints JSON: shares of pixels whose distances
agree to half a per cent, that only one side covers, and that differ; writes a picture (green: agrees, red: differs,
blue: only the application drew there, yellow: only the capture does, black: neither).
"""
import json
import os
import struct
import subprocess
import sys
import zlib

import subpixel_capture as spcap

from .errors import ExportError, renderdoc_module
from .linear import apply
from .replay import Replay

TOLERANCE = 0.005  # of the distance; half floats hold it to a two thousandth


def distances_of_application(path, target, event, viewport, projection, clip_negative):
    """Rows, top first, of the distance along the view at each pixel's first sample; 0 where nothing was drawn."""
    rd = renderdoc_module()
    rd.InitialiseReplay(rd.GlobalEnvironment(), [])
    replay = Replay.open(rd, path)
    try:
        replay.controller.SetFrameEvent(event, True)
        texture = replay.textures[target]
        data = bytes(replay.controller.GetTextureData(texture.resourceId, rd.Subresource(0, 0, 0)))
        is_gl = replay.controller.GetPipelineState().IsCaptureGL()
        depths = _depths(rd, texture.format, data, texture.width * texture.height, is_gl)
    finally:
        replay.close()
        rd.ShutdownReplay()
    x0, y0, width, height, low, high = viewport
    c, d = -projection[10], projection[14]
    rows = []
    for y in range(int(height)):
        # OpenGL's first row is the lowest.
        source = texture.height - 1 - (int(texture.height - y0 - height) + y) if is_gl else int(y0) + y
        row = []
        for x in range(int(width)):
            z = depths[source * texture.width + int(x0) + x]
            ndc = (z - low) / (high - low)
            if clip_negative:
                ndc = 2 * ndc - 1
            # A depth of the far plane is what the target was cleared to.
            row.append(0.0 if z >= 1.0 or z == 0.0 or ndc == c else d / (ndc - c))
        rows.append(row)
    return rows


def _depths(rd, form, data, count, is_gl):
    kinds = rd.ResourceFormatType
    if form.type == kinds.D24S8:
        shift = 8 if is_gl else 0  # GL_UNSIGNED_INT_24_8 has stencil in the low bits, the other APIs in the high ones
        return [(v >> shift & 0xFFFFFF) / 16777215.0 for v in struct.unpack("<%dI" % count, data[:4 * count])]
    if form.type == kinds.D32S8:
        return list(struct.unpack("<" + "f4x" * count, data[:8 * count]))
    if form.compByteWidth == 2:
        return [v / 65535.0 for v in struct.unpack("<%dH" % count, data[:2 * count])]
    if form.compByteWidth == 3:
        if is_gl:  # GL_UNSIGNED_INT is all 32 bits, whatever the target holds
            return [v / 4294967295.0 for v in struct.unpack("<%dI" % count, data[:4 * count])]
        return [(v & 0xFFFFFF) / 16777215.0 for v in struct.unpack("<%dI" % count, data[:4 * count])]
    return list(struct.unpack("<%df" % count, data[:4 * count]))


def distance_capture(capture, number):
    """The frame alone, without lights, each vertex as bright as it is far: (capture, distance of brightness 1)."""
    frame = capture.frames[number]
    view = [tuple(frame.view[4 * c + r] for c in range(4)) for r in range(4)]
    out = spcap.Capture(metadata=spcap.Metadata(title="distances"), buffers=list(capture.buffers))
    materials = {}
    white = {}
    made = spcap.Frame(name=frame.name, view=frame.view, projection=frame.projection, clip_depth=frame.clip_depth,
                       clip_y_up=frame.clip_y_up, width=frame.width, height=frame.height, sky=(0.0, 0.0, 0.0))
    furthest, todo = 1e-6, []
    for draw in frame.draws:
        count = draw.instance_count
        places = [draw.transform] if draw.instance_buffer == spcap.NONE else [
            struct.unpack_from("<16f", capture.buffers[draw.instance_buffer].bytes, draw.instance_offset + 64 * i)
            for i in range(count)]
        positions = [tuple(map(float, p))[:3] for p in spcap.stream_values(capture, draw.position, draw.vertex_count)]
        positions = [p + (0.0,) * (3 - len(p)) for p in positions]
        for place in places:
            rows = [tuple(place[4 * c + r] for c in range(4)) for r in range(3)]
            distances = [-apply(view, apply(rows, p))[2] for p in positions]
            furthest = max([furthest] + [d for d in distances if d < 1e30])
            todo.append((draw, place, distances))
    for draw, place, distances in todo:
        key = draw.material
        if key not in materials:
            held = capture.materials[draw.material]
            texture = spcap.NONE
            if held.alpha_mode == spcap.AlphaMode.TEST and held.base_colour_texture != spcap.NONE:
                texture = _whitened(capture, out, held.base_colour_texture, white)
            materials[key] = len(out.materials)
            out.materials.append(spcap.Material(
                unlit=True, two_sided=held.two_sided, base_colour_texture=texture, base_colour_uv=held.base_colour_uv,
                alpha_mode=held.alpha_mode if texture != spcap.NONE else 0, alpha_cutoff=held.alpha_cutoff))
        copy = spcap.Draw(**dict((n, getattr(draw, n)) for n, _ in spcap.Draw.DEFAULTS))
        copy.instance_buffer, copy.instance_offset, copy.instance_count = spcap.NONE, 0, 1
        copy.transform, copy.material = place, materials[key]
        alphas = _alphas(capture, draw) if out.materials[materials[key]].alpha_mode else [1.0] * len(distances)
        if min(distances) < 0:
            distances, alphas = _clipped(capture, out, copy, distances, alphas)
        shades = struct.pack("<%df" % (4 * len(distances)), *[
            s for d, alpha in zip(distances, alphas) for s in (d / furthest,) * 3 + (alpha,)])
        copy.colour = spcap.VertexStream(buffer=len(out.buffers), format=2, stride=16)
        out.buffers.append(spcap.Buffer(name="distances", bytes=shades))
        made.draws.append(copy)
    out.frames.append(made)
    return out, furthest


def _alphas(capture, draw):
    """What the draw's vertices multiply the alpha by."""
    if draw.colour.buffer != spcap.NONE:
        values = spcap.stream_values(capture, draw.colour, draw.vertex_count)
        if len(values) and len(values[0]) == 4:
            return [float(v[3]) for v in values]
    return [1.0] * draw.vertex_count


def _clipped(capture, out, draw, distances, alphas):
    """The draw's triangles cut where the eye is, as no colour is negative: the distances and alphas of its new
    vertices."""
    def stream(held, count):
        if held.buffer == spcap.NONE:
            return [(0.0,) * count] * draw.vertex_count
        values = [tuple(map(float, v))[:count] for v in spcap.stream_values(capture, held, draw.vertex_count)]
        return [v + (0.0,) * (count - len(v)) for v in values]

    numbers = [p + uv + (d, alpha) for p, uv, d, alpha in zip(
        stream(draw.position, 3), stream(draw.uv, 2), distances, alphas)]
    corners = range(draw.vertex_count)
    if draw.index_buffer != spcap.NONE:
        letter = "H" if draw.index_type == spcap.IndexType.UINT16 else "I"
        corners = struct.unpack_from("<%d%s" % (draw.index_count, letter), capture.buffers[draw.index_buffer].bytes,
                                     draw.index_offset)
    made = []
    for t in range(0, len(corners) - 2, 3):
        polygon, kept = [numbers[c] for c in corners[t:t + 3]], []
        for a, b in zip(polygon, polygon[1:] + polygon[:1]):
            if a[5] >= 0:
                kept.append(a)
            if (a[5] >= 0) != (b[5] >= 0):
                u = a[5] / (a[5] - b[5])
                cut = tuple(x + u * (y - x) for x, y in zip(a, b))
                kept.append(cut[:5] + (0.0, cut[6]))
        for i in range(1, len(kept) - 1):
            made += [kept[0], kept[i], kept[i + 1]]
    made = made or [numbers[0][:5] + (0.0, 1.0)] * 3
    draw.position = spcap.VertexStream(buffer=len(out.buffers), format=1, stride=20)
    draw.uv = spcap.VertexStream(buffer=len(out.buffers), format=0, offset=12, stride=20)
    out.buffers.append(spcap.Buffer(name="clipped", bytes=struct.pack("<%df" % (5 * len(made)), *[
        x for vertex in made for x in vertex[:5]])))
    draw.normal, draw.tangent = spcap.VertexStream(), spcap.VertexStream()
    draw.vertex_count, draw.index_type, draw.index_buffer, draw.index_count = len(made), 0, spcap.NONE, len(made)
    return [vertex[5] for vertex in made], [vertex[6] for vertex in made]


def _whitened(capture, out, number, known):
    """The texture with white for its colours: its alpha still cuts."""
    if number not in known:
        texture = capture.textures[number]
        if texture.encoding != spcap.TextureEncoding.RGBA8:
            return spcap.NONE
        data = bytearray(texture.bytes)
        for c in range(3):
            data[c::4] = b"\xff" * (len(data) // 4)
        known[number] = len(out.textures)
        out.textures.append(spcap.Texture(name=texture.name, width=texture.width, height=texture.height,
                                          bytes=bytes(data), sampler=texture.sampler))
    return known[number]


def read_exr(path, wanted=("R", "Y")):
    """(width, height, rows of the channel of one of these names) of a file of half or 32-bit floats, ZIP or no
    compression, as Subpixel writes them."""
    with open(path, "rb") as file:
        data = file.read()
    at, header = 8, {}
    while data[at]:
        end = data.index(b"\0", at)
        name = data[at:end].decode()
        kind_end = data.index(b"\0", end + 1)
        size = struct.unpack_from("<i", data, kind_end + 1)[0]
        header[name] = data[kind_end + 5:kind_end + 5 + size]
        at = kind_end + 5 + size
    at += 1
    channels, c = [], header["channels"]
    while c and c[0]:
        end = c.index(b"\0")
        channels.append((c[:end].decode(), struct.unpack_from("<i", c, end + 1)[0]))
        c = c[end + 17:]
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    lines = {0: 1, 1: 1, 2: 1, 3: 16}[header["compression"][0]]
    offsets = struct.unpack_from("<%dQ" % ((height + lines - 1) // lines), data, at)
    row_bytes = sum(width * (2 if kind == 1 else 4) for _, kind in channels)
    rows = [None] * height
    for offset in offsets:
        y, size = struct.unpack_from("<ii", data, offset)
        block = data[offset + 8:offset + 8 + size]
        held = min(lines, height - (y - y0))
        if size < row_bytes * held:
            raw = bytearray(zlib.decompress(block))
            for i in range(1, len(raw)):
                raw[i] = (raw[i - 1] + raw[i] - 128) & 255
            half = (len(raw) + 1) // 2
            block = bytearray(len(raw))
            block[0::2], block[1::2] = raw[:half], raw[half:]
        for i in range(held):
            start = i * row_bytes
            for name, kind in channels:
                size = width * (2 if kind == 1 else 4)
                if name.split(".")[-1] in wanted:
                    rows[y - y0 + i] = struct.unpack("<%d%s" % (width, "e" if kind == 1 else "f"),
                                                     bytes(block[start:start + size]))
                start += size
    return width, height, rows


def write_png(path, width, height, rows):
    """Rows of (r, g, b)."""
    def chunk(kind, payload):
        body = kind + payload
        return struct.pack(">I", len(payload)) + body + struct.pack(">I", zlib.crc32(body) & 0xFFFFFFFF)
    raw = b"".join(b"\0" + bytes(bytearray(v for p in row for v in p)) for row in rows)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
                   chunk(b"IDAT", zlib.compress(raw, 6)) + chunk(b"IEND", b""))


def compare(application, replayed):
    """(counts by kind, rows of colours)."""
    counts = {"agree": 0, "differ": 0, "only_application": 0, "only_capture": 0, "neither": 0}
    colours = {"agree": (60, 140, 60), "differ": (230, 30, 30), "only_application": (40, 60, 230),
               "only_capture": (230, 220, 40), "neither": (0, 0, 0)}
    picture = []
    for theirs, ours in zip(application, replayed):
        line = []
        for a, b in zip(theirs, ours):
            if a == 0 and b == 0:
                kind = "neither"
            elif b == 0:
                kind = "only_application"
            elif a == 0:
                kind = "only_capture"
            else:
                kind = "agree" if abs(a - b) <= TOLERANCE * max(a, b) else "differ"
            counts[kind] += 1
            line.append(colours[kind])
        picture.append(line)
    return counts, picture


def main(arguments=None):
    arguments = sys.argv[1:] if arguments is None else arguments
    if len(arguments) != 5:
        print(__doc__, file=sys.stderr)
        return 2
    rdc, path, number, binary, out = arguments
    number = int(number)
    capture = spcap.read(path)
    frame = capture.frames[number]
    try:
        facts = json.loads(next(n for n in capture.metadata.notices if n.startswith("frame {}: main view ".format(
            number))).split("main view ", 1)[1])
    except StopIteration:
        raise ExportError("the depths can't be compared", "the capture does not say which target was taken", path)
    os.makedirs(out, exist_ok=True)
    theirs = distances_of_application(rdc, facts["target"], facts["event"], facts["viewport"], frame.projection,
                                      frame.clip_depth == spcap.ClipDepth.MINUS_ONE_TO_ONE)
    made, furthest = distance_capture(capture, number)
    copy = os.path.join(out, "distances.spcap")
    spcap.write(made, copy, 1)
    done = subprocess.run([binary, "replay", copy, "--techniques", "noaa:alpha=test", "--reference-samples", "0",
                           "--repeat", "1", "--out", out], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True)
    if done.returncode != 0:
        raise ExportError("the depths can't be compared", done.stderr, copy)
    exr = [os.path.join(folder, name) for folder, _, names in os.walk(out) for name in names if name.endswith(".exr")]
    width, height, rows = read_exr(sorted(exr)[0])
    ours = [[v * furthest for v in row] for row in rows]
    counts, picture = compare(theirs, ours)
    total = float(width * height)
    print(json.dumps(dict((kind, round(100 * count / total, 3)) for kind, count in counts.items()), sort_keys=True))
    write_png(os.path.join(out, "depth.png"), width, height, picture)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (ExportError, spcap.CaptureError, OSError) as error:
        print("subpixel_renderdoc: {}".format(error), file=sys.stderr)
        sys.exit(3)
