"""Triangles of strips, fans and lists: positions in the stream of indices, three a triangle."""


def triangles(kind, count, restarts=()):
    """Corners of the triangles of `count` indices. `kind`: list, strip or fan; `restarts`: where a new one begins,
    ascending positions of indices that are no corners."""
    corners = []
    begin = 0
    for end in list(restarts) + [count]:
        corners.extend(_run(kind, begin, end))
        begin = end + 1
    return corners


def _run(kind, begin, end):
    if kind == "list":
        return range(begin, end - (end - begin) % 3)
    out = []
    for i in range(begin, end - 2):
        if kind == "fan":
            out.extend((begin, i + 1, i + 2))
        elif (i - begin) % 2 == 0:
            out.extend((i, i + 1, i + 2))
        else:
            out.extend((i + 1, i, i + 2))
    return out
