"""One texture for triangles that several blended draws make up: what they leave together, a cell for each triangle.

A cell has about a texel for each pixel that its triangle covers where it was recorded, never more than the finest of
its textures has. Needs numpy.
"""
import math

import numpy

BORDER = 4      # texels around a cell, so that filters of the first two levels stay in it
LONGEST = 1024  # texels along an edge
HIGHEST = 8192  # texels of the texture from top to bottom
CHUNK = 1 << 18


class Cell:
    """A triangle to be composed: clip positions of its corners, whether it is seen, and its layers from below, each
    (texture number, three uvs, three RGBA colours, (source, destination) factors or None where nothing is blended)."""

    def __init__(self, clips, is_seen, layers):
        self.clips, self.is_seen, self.layers = clips, is_seen, layers


class Image:
    """A texture's levels, each half the size of the one before, as floats of 0 to 1."""

    def __init__(self, texels, wraps, is_linear):
        level = texels.astype(numpy.float32) / numpy.float32(255)
        if is_linear:
            level[..., :3] = _linear(level[..., :3])
        self.levels, self.wraps = [level], wraps
        while max(level.shape[:2]) > 1:
            rows, columns = (max(n // 2, 1) for n in level.shape[:2])
            step = [1 if n == 1 else 2 for n in level.shape[:2]]
            level = sum(level[i:step[0] * rows:step[0], j:step[1] * columns:step[1]]
                        for i in range(step[0]) for j in range(step[1])) / numpy.float32(step[0] * step[1])
            self.levels.append(level)

    def size(self):
        return self.levels[0].shape[1], self.levels[0].shape[0]

    def sample(self, level, uv):
        """Bilinear RGBA of (n, 2) uvs."""
        texels = self.levels[level]
        corner, part = [], []
        for axis, count in ((0, texels.shape[1]), (1, texels.shape[0])):
            at = uv[:, axis] * count - 0.5
            low = numpy.floor(at)
            part.append((at - low).astype(numpy.float32)[:, None])
            corner.append([_wrapped(low.astype(numpy.int64) + i, count, self.wraps[axis]) for i in (0, 1)])
        (x0, x1), (y0, y1), (u, v) = corner[0], corner[1], part
        return (texels[y0, x0] * (1 - u) + texels[y0, x1] * u) * (1 - v) + (
            texels[y1, x0] * (1 - u) + texels[y1, x1] * u) * v


def _wrapped(number, count, wrap):
    if wrap == 1:
        return numpy.clip(number, 0, count - 1)
    if wrap == 2:
        number = number % (2 * count)
        return numpy.where(number < count, number, 2 * count - 1 - number)
    return number % count


def _linear(value):
    return numpy.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4).astype(numpy.float32)


def _encoded(value):
    return numpy.where(value <= 0.0031308, 12.92 * value, 1.055 * numpy.maximum(value, 0.0031308) ** (1 / 2.4) - 0.055)


def is_in_view(clips):
    """Whether a triangle may touch the image: not all corners beyond one of its borders or behind the eye."""
    return not (all(c[3] <= 0 for c in clips) or any(
        all(sign * c[axis] > c[3] for c in clips) for axis in (0, 1) for sign in (1, -1)))


def _cell_size(cell, images, viewport, longest):
    """Texels along the edges from the first corner to the second and the third."""
    if not cell.is_seen:
        return 1, 1
    finest = []
    for corner in (1, 2):
        lengths = [math.hypot(*((uvs[corner][axis] - uvs[0][axis]) * images[number].size()[axis] for axis in (0, 1)))
                   for number, uvs, _, _ in cell.layers]
        finest.append(max(lengths))
    wanted = finest
    if all(c[3] > 0 for c in cell.clips):
        places = [(c[0] / c[3] * viewport[0] / 2, c[1] / c[3] * viewport[1] / 2) for c in cell.clips]
        wanted = [math.hypot(places[corner][0] - places[0][0], places[corner][1] - places[0][1]) for corner in (1, 2)]
    return tuple(int(min(max(math.ceil(min(a, b)), 1), longest)) for a, b in zip(wanted, finest))


def _packed(sizes):
    """Corners of rectangles in rows, tallest first: (width, height, [(x, y)])."""
    width = 256
    while width < 8192 and width * width < sum(w * h for w, h in sizes) or width < max(w for w, _ in sizes):
        width *= 2
    places, x, y, tallest = [None] * len(sizes), 0, 0, 0
    for number in sorted(range(len(sizes)), key=lambda i: (-sizes[i][1], -sizes[i][0], i)):
        across, down = sizes[number]
        if x + across > width:
            x, y, tallest = 0, y + tallest, 0
        places[number] = (x, y)
        x, tallest = x + across, max(tallest, down)
    return width, y + tallest, places


def bake(cells, images, viewport, is_linear):
    """(width, height, RGBA bytes, three uvs for each cell). `viewport`: width and height in pixels; `is_linear`: the
    target blends linear numbers and holds sRGB."""
    longest = LONGEST
    while True:
        inner = [_cell_size(cell, images, viewport, longest) for cell in cells]
        borders = [BORDER if cell.is_seen else 0 for cell in cells]
        width, height, places = _packed([(w + 2 * b, h + 2 * b) for (w, h), b in zip(inner, borders)])
        if height <= HIGHEST or longest == 1:
            break
        # Coarser: triangles that reach behind the eye, whose place on the image says nothing, are cut by their length.
        viewport, longest = (viewport[0] / 2, viewport[1] / 2), longest // 2
    inner, borders, places = (numpy.array(values, numpy.int64) for values in (inner, borders, places))
    stack = _Stacks(cells, images, inner)
    counts = (inner[:, 0] + 2 * borders) * (inner[:, 1] + 2 * borders)
    out = numpy.zeros((height, width, 4), numpy.uint8)
    out[..., 3] = 255
    begin = 0
    while begin < len(cells):
        end = begin + max(int(numpy.searchsorted(numpy.cumsum(counts[begin:]), CHUNK)), 1)
        chosen = numpy.arange(begin, end)[:len(cells) - begin]
        cell = numpy.repeat(chosen, counts[chosen])
        first = numpy.cumsum(counts[chosen]) - counts[chosen]
        within = numpy.arange(len(cell)) - numpy.repeat(first, counts[chosen])
        across = inner[cell, 0] + 2 * borders[cell]
        x, y = within % across, within // across
        weights = numpy.stack([numpy.zeros(len(cell)), (x + 0.5 - borders[cell]) / inner[cell, 0],
                               (y + 0.5 - borders[cell]) / inner[cell, 1]], 1)
        weights[:, 0] = 1 - weights[:, 1] - weights[:, 2]
        # Beyond the triangle stands what is at its edge.
        weights = numpy.maximum(weights, 0)
        weights /= weights.sum(axis=1, keepdims=True)
        colour = stack.composed(cell, weights)
        if is_linear:
            colour = _encoded(colour)
        out[places[cell, 1] + y, places[cell, 0] + x, :3] = (numpy.clip(colour, 0, 1) * 255 + 0.5).astype(numpy.uint8)
        begin = int(chosen[-1]) + 1
    low = (places + borders[:, None]) / (width, height)
    high = (places + borders[:, None] + inner) / (width, height)
    uvs = numpy.stack([low, numpy.stack([high[:, 0], low[:, 1]], 1), numpy.stack([low[:, 0], high[:, 1]], 1)], 1)
    return width, height, out.tobytes(), uvs


def _mixed(weights, values, cell):
    """Of each cell's three values the mean by weights."""
    return sum(weights[:, corner, None] * values[cell, corner] for corner in range(3))


def _level(image, uvs, inner):
    """Of an image the level whose texels are nearest in size to the cell's."""
    across, down = image.size()
    steps = [math.hypot((uvs[corner][0] - uvs[0][0]) * across, (uvs[corner][1] - uvs[0][1]) * down) / inner[corner - 1]
             for corner in (1, 2)]
    mean = math.sqrt(max(steps[0] * steps[1], 1e-12))
    return min(max(int(math.floor(math.log2(mean) + 0.5)), 0), len(image.levels) - 1)


class _Stacks:
    """The layers of all cells, the lowest of each first."""

    def __init__(self, cells, images, inner):
        self.images, self.places = images, []
        for place in range(max(len(cell.layers) for cell in cells)):
            # What texels are computed together by: (image, factors, level), None for cells with fewer layers.
            keys, group = {(None, None, None): 0}, numpy.zeros(len(cells), numpy.int16)
            uvs, colours = numpy.zeros((len(cells), 3, 2)), numpy.zeros((len(cells), 3, 4))
            for i, cell in enumerate(cells):
                if len(cell.layers) > place:
                    image, uvs[i], colours[i], factors = cell.layers[place]
                    key = (image, factors or ("One", "Zero"), _level(images[image], cell.layers[place][1], inner[i]))
                    group[i] = keys.setdefault(key, len(keys))
            self.places.append((list(keys), group, uvs, colours))

    def composed(self, cell, weights):
        colour = numpy.zeros((len(cell), 3), numpy.float32)
        for keys, group, uvs, colours in self.places:
            held = group[cell]
            order = numpy.argsort(held, kind="stable")
            begins = numpy.searchsorted(held[order], numpy.arange(len(keys) + 1))
            for number, (image, factors, level) in enumerate(keys):
                at = order[begins[number]:begins[number + 1]]
                if image is None or not len(at):
                    continue
                w, of = weights[at], cell[at]
                texel = self.images[image].sample(level, _mixed(w, uvs, of))
                source = texel * _mixed(w, colours, of).astype(numpy.float32)
                below = colour[at]
                factor, other = (_factor(name, source, below) for name in factors)
                colour[at] = numpy.clip(source[:, :3] * factor + below * other, 0, 1)
        return colour


def _factor(name, source, below):
    value = {"Zero": numpy.float32(0), "One": numpy.float32(1), "SrcCol": source[:, :3], "DstCol": below,
             "SrcAlpha": source[:, 3:]}.get(name)
    if value is None:
        value = 1 - _factor(name[3:], source, below)
    return value
