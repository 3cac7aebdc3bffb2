"""The triangles of one draw: which vertices, where they come to lie, and whether one affine map takes them there."""
import math
import re
import struct

from .linear import apply, cross, dot, fit, length, scaled, sub
from .topology import triangles

POSITION = r"pos(ition)?\d*$|^(in_?|a_?|v_?)?(pos|vert)|vertex$|gl_Vertex"
NORMAL = r"normal|nrm"
UV = r"uv|tex_?co|tex(ture)?coord|texco|^tc\d?$|TEXCOORD"
COLOUR = r"colou?r|COLOR"
TANGENT = r"tangent|TANGENT"


class Mesh:
    """One instance's vertices, numbered `first` to `first + count - 1`; corners are such numbers, three a triangle."""

    def __init__(self):
        self.first = self.count = 0
        self.corners = []       # vertex numbers
        self.post = {}          # vertex number -> vertex shader output number
        self.outputs = None     # bytes, stride

    def clip(self, vertex):
        data, stride = self.outputs
        return struct.unpack_from("<4f", data, self.post[vertex] * stride)


def read_mesh(replay, action, state):
    """The Mesh of the first instance, or the reason why there is none."""
    if state.topology is None:
        return None, "no triangles"
    if state.has_other_stages:
        return None, "drawn through tessellation or geometry shaders"
    outputs = replay.vertex_outputs(0)
    if outputs is None:
        return None, "RenderDoc has no vertex shader outputs of it"
    data, stride, post_indices, post_base = outputs
    indices = replay.index_stream(action)
    count = len(indices) if indices is not None else action.numIndices
    if post_indices is not None:
        count = min(count, len(post_indices))
    elif indices is None:
        count = min(count, len(data) // stride)
    restarts = []
    if indices is not None and state.restart_index is not None and state.topology != "list":
        # OpenGL's fixed index is the largest of the indices' size, whatever its setting says.
        restart = state.restart_index & ((1 << 8 * replay.index_bytes()) - 1)
        restarts = [i for i in range(count) if indices[i] == restart]
    base = action.baseVertex if indices is not None else action.vertexOffset
    mesh = Mesh()
    mesh.outputs = (data, stride)
    most = len(data) // stride
    for position in triangles(state.topology, count, restarts):
        vertex = (indices[position] if indices is not None else position) + base
        post = post_indices[position] + post_base if post_indices is not None else position
        if post_indices is None and indices is not None:
            post = vertex
        if not 0 <= post < most:
            return None, "its vertex shader outputs lack vertex {}".format(vertex)
        mesh.post.setdefault(vertex, post)
        mesh.corners.append(vertex)
    if not mesh.corners:
        return None, "no triangles"
    mesh.first = min(mesh.corners)
    mesh.count = max(mesh.corners) - mesh.first + 1
    return mesh, ""


def instance_outputs(replay, mesh, instance):
    """The Mesh again with the outputs of another instance; None where RenderDoc has none."""
    outputs = replay.vertex_outputs(instance)
    if outputs is None or len(outputs[0]) < len(mesh.outputs[0]):
        return None
    other = Mesh()
    other.first, other.count, other.corners, other.post = mesh.first, mesh.count, mesh.corners, mesh.post
    other.outputs = (outputs[0], outputs[1])
    return other


def pick(attributes, pattern, least=1, most=4):
    """The first per-vertex attribute whose name fits."""
    for attribute in attributes:
        if attribute.constant is None and not attribute.per_instance and re.search(pattern, attribute.name, re.I) \
                and least <= attribute.format.count <= most:
            return attribute
    return None


def position_candidates(attributes):
    """Attributes that may hold positions: by name, then by location."""
    held = [a for a in attributes if a.constant is None and not a.per_instance and a.format.count >= 2]
    named = [a for a in held if re.search(POSITION, a.name, re.I) and not re.search(NORMAL + "|" + UV, a.name, re.I)]
    return named + [a for a in sorted(held, key=lambda a: a.location) if a not in named and a.format.count >= 3]


def samples_of(mesh, most=96):
    """Vertex numbers spread over the mesh."""
    used = sorted(mesh.post)
    if len(used) <= most:
        return used
    return [used[i * (len(used) - 1) // (most - 1)] for i in range(most)]


def clip_map(points, clips):
    """Rows of four of the matrix that takes all points to their clip positions, or None."""
    finite = [(p, c) for p, c in zip(points, clips) if all(map(math.isfinite, p + c))]
    if len(finite) < 5:
        return None
    points, clips = zip(*finite)
    rows = fit(points, clips)
    if rows is None:
        return None
    for p, c in zip(points, clips):
        got = apply(rows, p)
        size = max(abs(c[0]), abs(c[1]), abs(c[3]), 1e-6)
        if max(abs(got[i] - c[i]) for i in (0, 1, 3)) > 1e-4 * size:
            return None
    return rows


def world_map(points, clips, camera, pixels):
    """Affine rows that take all points to the world positions of their clip positions, to a tenth of a pixel of
    `pixels` from bottom to top; or None. Points of a plane get the map that keeps its normal's length in step."""
    finite = [(p, c) for p, c in zip(points, clips) if all(map(math.isfinite, p + c))]
    if len(finite) < 3:
        return None
    points, clips = [p for p, _ in finite], [c for _, c in finite]
    worlds = [camera.world(c) for c in clips]
    rows = fit(points, worlds)
    if rows is None:
        rows = _planar_map(points, worlds)
    if rows is None:
        return None
    tolerance = 0.1 * 2 / pixels / max(abs(camera.projection.a), abs(camera.projection.b))
    for p, c, world in zip(points, clips, worlds):
        error = length(sub(apply(rows, p), world))
        if not error <= tolerance * max(abs(c[3]), 1e-3) + 1e-6 * length(world):
            return None
    return rows


def off_scene(clips, projection, is_reversed, clip_negative):
    """Why clip positions are no places in the scene, or None. The eye's distance is read from w, and depth has to
    follow it as the projection says, unless a depth range of its own shows a weapon or cockpit before all else."""
    clips = [c for c in clips if all(map(math.isfinite, c))]
    if not clips:
        return "no finite positions"
    far = 1.0 if not is_reversed else -1.0 if clip_negative else 0.0
    if all(abs(c[2] - far * c[3]) <= 1e-6 * abs(c[3]) for c in clips):
        return "drawn at the far plane (sky)"
    w = clips[0][3]
    is_flat = all(abs(c[3] - w) <= 1e-6 * abs(w) for c in clips)
    expected = projection.c * w + projection.d
    if is_flat and any(abs(c[2] - expected) > 1e-2 * abs(w) for c in clips):
        return "drawn on the screen, at no place in the scene"
    return None


def _planar_map(points, worlds):
    """With the plane's normal added to what is given: its image is across the images of two edges."""
    best, size = None, 0.0
    origin = points[0]
    far = max(range(len(points)), key=lambda i: length(sub(points[i], origin)))
    along = sub(points[far], origin)
    for i in range(len(points)):
        area = length(cross(along, sub(points[i], origin)))
        if area > size:
            best, size = i, area
    if best is None or not size > 1e-10 * dot(along, along):
        return None
    normal = cross(along, sub(points[best], origin))
    along_world = sub(worlds[far], worlds[0])
    normal_world = cross(along_world, sub(worlds[best], worlds[0]))
    if length(normal_world) == 0:
        return None
    extent, extent_world = length(along), length(along_world)
    up = scaled(normal, extent / length(normal))
    up_world = scaled(normal_world, extent_world / length(normal_world))
    added = [tuple(a + b for a, b in zip(origin, up))]
    added_world = [tuple(a + b for a, b in zip(worlds[0], up_world))]
    return fit(list(points) + added * 4, list(worlds) + added_world * 4)


def smooth_normals(positions, corners):
    """A unit normal for each position: of the triangles around it, by area. (0, 0, 1) where there is none."""
    sums = {}
    for t in range(0, len(corners), 3):
        a, b, c = corners[t:t + 3]
        n = cross(sub(positions[b], positions[a]), sub(positions[c], positions[a]))
        for v in (a, b, c):
            s = sums.get(v)
            sums[v] = n if s is None else (s[0] + n[0], s[1] + n[1], s[2] + n[2])
    out = {}
    for v, n in sums.items():
        size = length(n)
        out[v] = scaled(n, 1 / size) if size > 0 and math.isfinite(size) else (0.0, 0.0, 1.0)
    return out


def triangle_keys(mesh):
    """For each triangle two keys by where its corners lie, so that the same triangle drawn again is found: a grid and
    one moved by half a cell, as a rounding error may cross a border of one."""
    cells = {}
    for vertex in mesh.post:
        clip = mesh.clip(vertex)
        w = clip[3] if abs(clip[3]) > 1e-6 else 1e-6
        spots = (clip[0] / w * 4096, clip[1] / w * 4096, math.log(abs(w)) * 4096)
        if not all(map(math.isfinite, spots)):
            spots = (0.0, 0.0, 0.0)
        cells[vertex] = (tuple(int(math.floor(s)) for s in spots), tuple(int(math.floor(s + 0.5)) for s in spots))
    keys = []
    for t in range(0, len(mesh.corners), 3):
        corners = [cells[v] for v in mesh.corners[t:t + 3]]
        keys.append((tuple(sorted(c[0] for c in corners)), tuple(sorted(c[1] for c in corners))))
    return keys
