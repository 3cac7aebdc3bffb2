"""Which draws lie on the same triangles at equal depth: passes that together make up what a surface looks like."""
from . import geometry
from .replay import FACTORS


class Stack:
    """A triangle that others were drawn over: of `base`'s triangle `number`, [(layer, its triangle, order of its
    corners)] in the order they were drawn."""

    def __init__(self, base, number, over):
        self.base, self.number, self.over = base, number, over


def stacks(bases, layers):
    """The Stacks of all triangles of `bases` that at least one of `layers` lies on."""
    index = {}
    for place, entry in enumerate(layers):
        for t, keys in enumerate(geometry.triangle_keys(entry.mesh)):
            for grid, key in enumerate(keys):
                index.setdefault((grid, key), []).append((place, t))
    for base in bases if index else ():
        for t, keys in enumerate(geometry.triangle_keys(base.mesh)):
            found = set()
            for grid, key in enumerate(keys):
                found.update(index.get((grid, key), ()))
            if found:
                yield Stack(base, t, [(layers[place], other, _order(base.mesh, t, layers[place].mesh, other))
                                      for place, other in sorted(found)])


def _order(mesh, t, other, u):
    """For each corner of a triangle the corner of another that lies nearest."""
    ours = [mesh.clip(v) for v in mesh.corners[3 * t:3 * t + 3]]
    theirs = [other.clip(v) for v in other.corners[3 * u:3 * u + 3]]
    return [min(range(3), key=lambda i: sum(abs(a - b) for a, b in zip(place, theirs[i]))) for place in ours]


def can_be_composed(state, over_colour):
    """Whether a blended draw adds to the surface below: not as light that is added once more over what has colour."""
    if not state.blends:
        return True
    if state.blend is None or any(name not in FACTORS for name in state.blend):
        return False
    return not over_colour or state.blend[1] == "InvSrcAlpha"
