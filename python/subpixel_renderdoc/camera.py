"""The camera of a frame from matrices and clip positions.

A perspective projection shows in any matrix that has it as its last factor, whatever rotations, translations and
uniform scales stand before: with r0 to r3 the first three numbers of the rows, r3 is the viewing direction, r0 and r1
are across it, r2 along it. So no names are needed: every draw's map from input to clip positions, and every 4x4
constant, is asked.
"""
import math

from .linear import apply, column_major, cross, determinant, dot, length, scaled, sub


class Projection:
    """x' = a x + e w, y' = b y + f w, z' = c w + d, w = -z of view space: what the six numbers mean."""

    def __init__(self, a, b, e, f, c, d):
        self.a, self.b, self.e, self.f, self.c, self.d = a, b, e, f, c, d

    def numbers(self):
        return (self.a, self.b, self.e, self.f, self.c, self.d)

    def is_near(self, other, tolerance=2e-3):
        for x, y in zip(self.numbers(), other.numbers()):
            if abs(x - y) > tolerance * max(abs(x), abs(y), 0.05):
                return False
        return True

    def to_view(self, clip):
        """View-space position of a clip position; its z' is not needed."""
        w = clip[3]
        return ((clip[0] - self.e * w) / self.a, (clip[1] - self.f * w) / self.b, -w)

    def view_rows(self, matrix):
        """The affine map before the projection: three rows of four of the matrix's four."""
        return (tuple((x - self.e * w) / self.a for x, w in zip(matrix[0], matrix[3])),
                tuple((y - self.f * w) / self.b for y, w in zip(matrix[1], matrix[3])),
                tuple(-w for w in matrix[3]))

    def rows(self):
        return ((self.a, 0.0, -self.e, 0.0), (0.0, self.b, -self.f, 0.0), (0.0, 0.0, -self.c, self.d),
                (0.0, 0.0, -1.0, 0.0))


def projection_of(matrix, y_up):
    """The Projection that is the last factor of four rows of four, or None."""
    r0, r1, r2, r3 = (row[:3] for row in matrix)
    n2 = dot(r3, r3)
    if not (1e-12 < n2 < 1e12) or not all(math.isfinite(v) for row in matrix for v in row):
        return None
    n = math.sqrt(n2)
    e, f, c = dot(r0, r3) / n2, dot(r1, r3) / n2, dot(r2, r3) / n2
    q0, q1, q2 = sub(r0, scaled(r3, e)), sub(r1, scaled(r3, f)), sub(r2, scaled(r3, c))
    a, b = length(q0) / n, length(q1) / n
    if not (1e-3 < a < 1e3 and 1e-3 < b < 1e3):
        return None
    if abs(dot(q0, q1)) > 2e-3 * length(q0) * length(q1) or length(q2) > 2e-3 * n * max(abs(c), 1e-3):
        return None
    if abs(e) > 2 or abs(f) > 2:
        return None
    d = matrix[2][3] - c * matrix[3][3]
    if abs(d) < 1e-9:
        return None
    return Projection(a, b if y_up else -b, e, f, c, d)


def clip_variants(matrix):
    """A constant's matrix, and what vertex shaders make of it that were written for other clip spaces: y turned round,
    z halved from -w to w to 0 to w."""
    x, y, z, w = matrix
    turned = tuple(-v for v in y)
    halved = tuple((a + b) / 2 for a, b in zip(z, w))
    return ((x, y, z, w), (x, turned, halved, w), (x, turned, z, w), (x, y, halved, w))


def are_near(a, b):
    """Whether two matrices take the same points to the same pixels, nearly."""
    for p, q in zip(a, b):
        size = max(max(map(abs, p[:3])), max(map(abs, q[:3])), 1e-9)
        if max(abs(x - y) for x, y in zip(p[:3], q[:3])) > 1e-4 * size:
            return False
        if abs(p[3] - q[3]) > 1e-4 * max(abs(p[3]), abs(q[3]), size):
            return False
    return True


def rigid_view(rows):
    """The rotation and translation of three rows of four that have a common scale, mirrored if need be; or None."""
    lengths = [length(row) for row in rows]
    if min(lengths) < 1e-9 or max(lengths) > 1.01 * min(lengths):
        return None
    s = sum(lengths) / 3
    rows = [tuple(v / s for v in row) for row in rows]
    for i in range(3):
        if abs(dot(rows[i], rows[(i + 1) % 3])) > 5e-3:
            return None
    if determinant(rows) < 0:
        # The application's world is left-handed: its z axis is turned round.
        rows = [(row[0], row[1], -row[2], row[3]) for row in rows]
    x = scaled(rows[0][:3], 1 / length(rows[0]))
    z = cross(x, rows[1][:3])
    z = scaled(z, 1 / length(z))
    y = cross(z, x)
    return tuple(axis + (row[3],) for axis, row in zip((x, y, z), rows))


def inverse_of(view):
    """Of a rotation and translation, three rows of four."""
    back = []
    for i in range(3):
        axis = (view[0][i], view[1][i], view[2][i])
        back.append(axis + (-(axis[0] * view[0][3] + axis[1] * view[1][3] + axis[2] * view[2][3]),))
    return tuple(back)


class Camera:
    """Projection and view of a frame."""

    def __init__(self, projection, view):
        self.projection, self.view = projection, view
        self.inverse = inverse_of(view)

    def world(self, clip):
        """World position of a clip position."""
        return apply(self.inverse, self.projection.to_view(clip))

    def clip(self, world):
        """Clip position of a world position."""
        return apply(self.projection.rows(), apply(self.view, world))

    def view_matrix(self):
        return column_major(self.view)

    def projection_matrix(self):
        return column_major(self.projection.rows())


def merged(candidates):
    """(Projection, weight) with those of equal numbers, to five digits, added up: most constants are seen by all
    draws."""
    sums = {}
    for projection, weight in candidates:
        key = tuple("%.5g" % number for number in projection.numbers())
        held = sums.setdefault(key, [projection, 0.0])
        held[1] += weight
    return sorted(((p, w) for p, w in sums.values()), key=lambda held: -held[1])


def dominant(candidates):
    """Of (Projection, weight) the centre of the heaviest group of near ones; None of none."""
    best, best_weight = None, 0.0
    for projection, _ in candidates:
        weight = sum(w for other, w in candidates if projection.is_near(other))
        if weight > best_weight:
            best, best_weight = projection, weight
    if best is None:
        return None
    near = [(p, w) for p, w in candidates if best.is_near(p)]
    total = sum(w for _, w in near)
    # d is a small difference of large numbers in most: the median of it, the mean of the rest would do as well.
    numbers = []
    for i in range(6):
        values = sorted((p.numbers()[i], w) for p, w in near)
        passed = 0.0
        for value, w in values:
            passed += w
            if passed >= total / 2:
                numbers.append(value)
                break
    return Projection(*numbers)


def assumed_projection(clips, width, height, y_up):
    """Where no matrix shows it: 60 degrees from bottom to top, square pixels, depth by the line through z' over w."""
    points = [(c[3], c[2]) for c in clips if c[3] > 0]
    if len(points) < 2:
        return None
    mean_w = sum(w for w, _ in points) / len(points)
    mean_z = sum(z for _, z in points) / len(points)
    spread = sum((w - mean_w) ** 2 for w, _ in points)
    if spread <= 1e-12 * max(mean_w * mean_w, 1e-12) * len(points):
        return None
    c = sum((w - mean_w) * (z - mean_z) for w, z in points) / spread
    b = 1 / math.tan(math.radians(30))
    return Projection(b * height / width, b if y_up else -b, 0.0, 0.0, c, mean_z - c * mean_w)
