"""Small linear algebra on tuples: 3-vectors, affine maps as three rows of four, 4x4 matrices as four rows."""
import math


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def length(a):
    return math.sqrt(dot(a, a))


def scaled(a, s):
    return (a[0] * s, a[1] * s, a[2] * s)


def apply(rows, p):
    """An affine map (or the rows of a 4x4 matrix) of a point."""
    return tuple(r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3] for r in rows)


def transposed(m):
    return tuple(zip(*m))


def multiplied(a, b):
    return tuple(tuple(sum(a[r][k] * b[k][c] for k in range(4)) for c in range(4)) for r in range(4))


def column_major(rows):
    """16 numbers, as SPEC.md has matrices; an affine map gets its last row."""
    rows = list(rows) + ([(0.0, 0.0, 0.0, 1.0)] if len(rows) == 3 else [])
    return tuple(float(rows[r][c]) for c in range(4) for r in range(4))


def determinant(rows):
    return dot(rows[0][:3], cross(rows[1][:3], rows[2][:3]))


def solve(a, b):
    """x of a x = b with several right sides, by elimination with pivots; None where a is singular to 1e-11."""
    n = len(a)
    rows = [list(map(float, a[i])) + list(map(float, b[i])) for i in range(n)]
    largest = max(abs(v) for row in rows for v in row[:n]) or 1.0
    for c in range(n):
        pivot = max(range(c, n), key=lambda r: abs(rows[r][c]))
        if abs(rows[pivot][c]) < 1e-11 * largest:
            return None
        rows[c], rows[pivot] = rows[pivot], rows[c]
        for r in range(n):
            if r != c and rows[r][c] != 0.0:
                factor = rows[r][c] / rows[c][c]
                rows[r] = [x - factor * y for x, y in zip(rows[r], rows[c])]
    return [[rows[r][n + k] / rows[r][r] for k in range(len(rows[r]) - n)] for r in range(n)]


def fit(points, values):
    """The rows of the affine map of least squares from 3-points to tuples of k numbers; None where the points lie in a
    plane."""
    count = float(len(points))
    if count < 4:
        return None
    centre = tuple(sum(p[i] for p in points) / count for i in range(3))
    extent = max(max(abs(p[i] - centre[i]) for p in points) for i in range(3))
    if not extent > 0 or not math.isfinite(extent):
        return None
    width = len(values[0])
    normal = [[0.0] * 4 for _ in range(4)]
    right = [[0.0] * width for _ in range(4)]
    for p, v in zip(points, values):
        q = ((p[0] - centre[0]) / extent, (p[1] - centre[1]) / extent, (p[2] - centre[2]) / extent, 1.0)
        for i in range(4):
            for j in range(4):
                normal[i][j] += q[i] * q[j]
            for k in range(width):
                right[i][k] += q[i] * v[k]
    # Points of a plane leave a pivot of rounding errors.
    for i in range(4):
        normal[i] = [x / count for x in normal[i]]
        right[i] = [x / count for x in right[i]]
    if _least_eigenvalue_is_tiny(normal):
        return None
    x = solve(normal, right)
    if x is None:
        return None
    rows = []
    for k in range(width):
        linear = tuple(x[i][k] / extent for i in range(3))
        rows.append(linear + (x[3][k] - dot(linear, centre),))
    return tuple(rows)


def _least_eigenvalue_is_tiny(normal):
    """Whether the 3x3 part, of centred points within a cube of side 2, is flat to a ten thousandth."""
    m = [row[:3] for row in normal[:3]]
    det = determinant(m)
    trace = m[0][0] + m[1][1] + m[2][2]
    second = (m[0][0] * m[1][1] - m[0][1] ** 2) + (m[0][0] * m[2][2] - m[0][2] ** 2) + \
        (m[1][1] * m[2][2] - m[1][2] ** 2)
    # det / second is about the least eigenvalue.
    return second <= 1e-14 * trace * trace or det / second < 1e-8 * trace
