"""Frames of RenderDoc captures to one capture of Subpixel's."""
import json
import os
import re
import struct

import subpixel_capture as spcap
from subpixel_capture import Draw, Frame, VertexFormat, VertexStream

from . import camera as cameras
from . import geometry, layers, textures
from .builder import Builder
from .errors import ExportError, renderdoc_module
from .formats import float_bytes
from .linear import column_major, determinant, transposed
from .replay import Replay

try:
    import numpy
    from . import bake
except ImportError:  # qrenderdoc's own Python has none
    numpy = None

TOOL = "subpixel_renderdoc 1"
MOST_INSTANCES = 65536
LEVEL = 1  # zlib's: a frame with 230 MB of textures takes 3 s, not 10, and `subpixel import` writes the file anew


class Options:
    """What of the frame is taken, and how.

    events: (first, last) event ids, or None; target: id of the depth target as RenderDoc shows it, or None; mapping:
    role -> names (regular expressions) or slots of textures; sun: the way a directional light travels in world space,
    or None; title, application, licence: texts of the metadata; progress: called with a line now and then."""

    def __init__(self, **values):
        self.events = self.target = self.sun = None
        self.mapping = {}
        self.title = self.application = self.licence = ""
        self.progress = lambda line: None
        for name, value in values.items():
            if not hasattr(self, name):
                raise TypeError("Options has no field " + name)
            setattr(self, name, value)


class Entry:
    """A draw of the main view."""

    def __init__(self, number, action, state, name):
        self.number, self.action, self.state, self.name = number, action, state, name
        self.mesh = self.reason = None
        self.attributes = self.outputs = self.points = self.position = None
        self.clip_rows = None
        self.instances = []       # meshes of instances 1, 2, ...
        self.textures = {}
        self.samplers = {}
        self.uv_name = None       # of what the fragment shader reads the base colour at, where it says so
        self.discards, self.cutoff = False, None
        self.colour = None        # of a constant
        self.matrices = []
        self.data = {}            # (resource, stride) -> (bytes, offset of the first vertex)
        self.kept = set()         # numbers of triangles that are drawn
        self.tints = self.uvs = self.placement = None  # asked for where layers are composed
        self.role = "surface"     # surface, prepass, layer

    def triangles(self):
        return len(self.mesh.corners) // 3 if self.mesh else 0


class Notices:
    """Reasons with the draws that they hold for."""

    def __init__(self):
        self.draws, self.plain = {}, []

    def draw(self, reason, entry_name):
        self.draws.setdefault(reason, []).append(entry_name)

    def say(self, text):
        if text not in self.plain:
            self.plain.append(text)

    def lines(self, frame):
        out = ["frame {}: {}".format(frame, text) for text in self.plain]
        for reason, names in self.draws.items():
            text = "frame {}: {} ({} draws): {}".format(frame, reason, len(names), ", ".join(names))
            out.append(text if len(text) < 2000 else text[:1990] + " ...")
        return out


def _names_view(name):
    """Whether a matrix is called what takes the world to the camera's space."""
    if re.search("camera_?inv|world_?to_?(view|cam|eye)", name, re.I):
        return True
    return re.search("view", name, re.I) and not re.search("proj|inv|norm|prev|last|shadow|light|model|tex", name, re.I)


_BASE_COLOUR = re.compile(r"^([mug]_)?(albedo|base_?colou?r|diffuse)(_?(colou?r|factor))?$", re.I)


def _base_colour(constants):
    """The colour that a fragment shader's constant of such a name has, or None."""
    for name in sorted(constants):
        stem, _, component = name.rpartition(".")
        if component == "x" and stem + ".z" in constants and _BASE_COLOUR.match(stem.split(".")[-1]):
            return tuple(min(max(float(constants[stem + "." + c]), 0.0), 1.0) for c in "xyz")
    return None


class FrameExport:
    """One open capture's frame into the builder."""

    def __init__(self, replay, builder, options):
        self.replay, self.builder, self.options = replay, builder, options
        self.rd = replay.rd
        self.notices = Notices()
        self.piles, self.images = [], {}  # triangles to be composed; textures that were decoded for it

    def run(self, number):
        entries = self._main_view()
        drawn = [e for e in entries if e.mesh is not None]
        if not drawn:
            raise ExportError("the RenderDoc capture can't be exported", "no draw of its main view can be taken: " +
                              "; ".join("{} ({})".format(r, len(n)) for r, n in self.notices.draws.items()))
        camera = self._camera(drawn)
        drawn = self._layers(self._in_scene(drawn, camera))
        frame = self._frame(number, camera)
        seen = {}
        self._composed(camera, frame)
        for entry in drawn:
            self._draw(entry, camera, frame, seen)
        if not frame.draws:
            raise ExportError("the RenderDoc capture can't be exported", "no triangle of its main view is left")
        self.builder.capture.frames.append(frame)
        taken = json.dumps({"target": self.depth_target, "event": max(e.action.eventId for e in drawn),
                            "viewport": list(self.viewport)}, sort_keys=True)
        self.notices.say("main view " + taken)
        self.builder.capture.metadata.notices.extend(self.notices.lines(number))
        self.camera = camera
        return frame

    # --- which draws

    def _main_view(self):
        """The visited draws of the depth target that most depth-writing triangles go to, of those with colours beside
        them that have at least a quarter of the largest one's pixels."""
        groups, self.target_ids, draws = {}, set(), self.replay.draws()
        for number, action in enumerate(draws):
            for output in action.outputs:
                self.target_ids.add(str(output))
            if action.depthOut == self.replay.null:
                continue
            self.target_ids.add(str(action.depthOut))
            if self.options.events and not self.options.events[0] <= action.eventId <= self.options.events[1]:
                continue
            if self.options.target and str(action.depthOut).split(":")[-1] != str(self.options.target):
                continue
            name = "event {} {}".format(action.eventId, re.sub(r"\(.*", "", self.replay.name(action)))
            groups.setdefault(str(action.depthOut), []).append(Entry(number, action, None, name))
        if not groups:
            raise ExportError("the RenderDoc capture can't be exported", "no draw has a depth target" + (
                " among the chosen ones" if self.options.events or self.options.target else ""))

        def area(key):
            texture = self.replay.textures.get(key)
            return texture.width * texture.height if texture else 0

        def has_colour(key):
            return any(o != self.replay.null for e in groups[key] for o in e.action.outputs)

        coloured = [key for key in groups if has_colour(key)] or list(groups)
        largest = max(area(key) for key in coloured)
        near = [key for key in coloured if 4 * area(key) >= largest] or coloured
        self.depth_target = best = self._look_at_most_depth_writing(dict((key, groups[key]) for key in near))
        self._place_in_viewport(groups[best])
        others = len(draws) - len(groups[best])
        if others:
            self.notices.say("left out: {} draws to other targets or without depth (shadows, post passes, HUD)".format(
                others))
        return groups[best]

    def _look_at_most_depth_writing(self, groups):
        """The key of the entries that most triangles are written to depth by, which have been looked at. What a draw
        writes is known when the replay stands at it, which costs a replay, so everything is asked then. Corners are
        no fewer: those of most corners are asked first, and those that can't win any more are not."""
        def most(entries):
            return sum(e.action.numIndices * max(e.action.numInstances, 1) for e in entries)

        best, written, notices = None, -1, self.notices
        for key in sorted(groups, key=lambda key: -most(groups[key])):
            if most(groups[key]) <= written:
                break
            self.notices = Notices()
            self._look(groups[key])
            count = sum(self._written(entry) for entry in groups[key])
            if count > written:
                best, written, notices = key, count, self.notices
        self.notices = notices
        return best

    @staticmethod
    def _written(entry):
        """How many triangles a draw that was looked at writes to depth, hidden ones too."""
        action, state = entry.action, entry.state
        if not state.depth_write or state.topology is None:
            return 0
        each = action.numIndices // 3 if state.topology == "list" else action.numIndices - 2
        return max(each, 0) * max(action.numInstances, 1)

    def _look(self, entries):
        """Asks everything about each draw in one visit."""
        for done, entry in enumerate(entries):
            self.replay.go_to(entry.action)
            entry.state = state = self.replay.state()
            if done % 25 == 0:
                self.options.progress("draw {} of {}".format(done + 1, len(entries)))
            entry.reason = self._refusal(state)
            if entry.reason:
                self.notices.draw("left out: " + entry.reason, entry.name)
                continue
            entry.mesh, reason = geometry.read_mesh(self.replay, entry.action, state)
            if entry.mesh is None:
                self.notices.draw("left out: " + reason, entry.name)
                continue
            if state.depth_write and not state.writes_colour:
                entry.role = "prepass"
            elif not state.depth_write:
                entry.role = "layer"
            self._inputs(entry)
            self._shading(entry)
            entry.matrices = self.replay.matrices()
            for instance in range(1, min(entry.action.numInstances, MOST_INSTANCES)):
                other = geometry.instance_outputs(self.replay, entry.mesh, instance)
                if other is None:
                    self.notices.draw("approximated: instances from {} on are missing".format(instance), entry.name)
                    break
                entry.instances.append(other)

    def _place_in_viewport(self, entries):
        """Finds the viewport that most triangles are drawn to, and drops the draws to others."""
        taken = [e for e in entries if e.mesh is not None]
        if not taken:
            return
        viewports = {}
        for entry in taken:
            key = entry.state.viewport
            viewports[key] = viewports.get(key, 0) + entry.triangles() * (entry.role != "layer")
        self.viewport = max(viewports, key=viewports.get)
        writing = [e for e in taken if e.state.depth_write] or taken
        self.typical = max(writing, key=Entry.triangles).state
        for entry in taken:
            if entry.state.viewport[:4] != self.viewport[:4]:
                entry.mesh = None
                self.notices.draw("left out: drawn to another part of the target", entry.name)
            elif entry.state.viewport[4:] != self.viewport[4:]:
                if entry.state.viewport[4] == entry.state.viewport[5]:
                    entry.mesh = None
                    self.notices.draw("left out: drawn at one depth (sky)", entry.name)
                else:
                    self.notices.draw("approximated: drawn with a depth range of its own", entry.name)

    @staticmethod
    def _refusal(state):
        if state.topology is None:
            return "points, lines or patches"
        if state.cull == "Both":
            return "all faces culled"
        if not state.depth_test:
            return "no depth test (HUD, sky, post)"
        if not state.depth_write and state.depth_function not in ("Equal", "LessEqual", "GreaterEqual"):
            return "writes no depth (blended or decal)"
        return None

    # --- what a draw has

    def _inputs(self, entry):
        entry.attributes, entry.outputs = self.replay.attributes(), self.replay.outputs()
        mesh = entry.mesh
        for attribute in entry.attributes:
            if attribute.constant is None and not attribute.per_instance:
                self._fetch(entry, attribute)
        sampled = geometry.samples_of(mesh)
        clips = [mesh.clip(v) for v in sampled]
        for attribute in geometry.position_candidates(entry.attributes):
            points = self._values(entry, attribute, sampled, 3)
            if points is None:
                continue
            rows = geometry.clip_map(points, clips)
            if rows is not None or entry.position is None:
                entry.position, entry.points = attribute, (sampled, points)
            if rows is not None:
                entry.clip_rows = rows
                break

    def _fetch(self, entry, attribute):
        """The bytes of the mesh's vertices of the attribute's buffer; interleaved attributes share them."""
        mesh = entry.mesh
        stride = attribute.stride
        key = (str(attribute.resource), stride, attribute.offset // stride if stride else attribute.offset)
        begin = key[2] * stride + stride * mesh.first if stride else attribute.offset
        if begin < 0:
            return
        if key not in entry.data:
            size = stride * mesh.count if stride else attribute.format.bytes
            entry.data[key] = self.replay.buffer(attribute.resource, begin, size)
        attribute.key = key
        attribute.within = attribute.offset - key[2] * stride if stride else 0

    def _values(self, entry, attribute, vertices, components):
        """Tuples of an attribute at vertex numbers; None where the buffer ends before."""
        data = entry.data.get(getattr(attribute, "key", None))
        if data is None:
            return None
        out, filler = [], (0.0, 0.0, 0.0, 1.0)
        for v in vertices:
            at = attribute.within + (v - entry.mesh.first) * attribute.stride
            if at + attribute.format.bytes > len(data):
                return None
            value = attribute.format.decode(data, at, 0, 1)[0]
            out.append((tuple(float(x) for x in value) + filler[len(value):])[:components])
        return out

    def _shading(self, entry):
        _, source = self.replay.fragment_source()
        entry.discards = False
        constants = self.replay.fragment_constants()
        entry.colour = _base_colour(constants)
        if "discard" in source or "Kill" in source or "clip" in source or "Demote" in source:
            entry.discards, entry.cutoff = textures.cutoff(source, constants)
        bound = self.replay.fragment_textures()
        chosen = textures.choose(bound, self.replay.textures, self.options.mapping,
                                 lambda resource: str(resource) in self.target_ids)
        for role, (name, slot, resource) in chosen.items():
            sampler = self.replay.sampler(slot, name)
            key = (str(resource), role, sampler)
            if key not in self.builder.texture_of:
                self.builder.texture_of[key] = self._texture(resource, role, sampler, name)
            number, alpha, reason = self.builder.texture_of[key]
            if reason:
                self.notices.draw(reason, entry.name)
            if number is not None:
                entry.textures[role] = (number, alpha)
        if "base_colour" in chosen:
            entry.uv_name = textures.read_at(source, chosen["base_colour"][0])

    def _texture(self, resource, role, sampler, name):
        """Its number in the capture, whether it has alpha, and what to say of the draws that read it."""
        texture, reason = textures.read(self.replay, resource, role, sampler)
        if texture is None:
            return None, None, "approximated: a texture is missing, as " + reason
        if role == "normal" and textures.is_one_colour(texture):
            # Some APIs want something bound where the application has no normal map.
            return None, None, "left out: a normal map of one colour"
        texture.name = "{} {}".format(name, str(resource).split(":")[-1])
        return self.builder.texture(texture), textures.has_alpha(texture), ""

    # --- the camera

    def _camera(self, drawn):
        y_up = drawn[0].state.clip_y_up
        candidates, shared = [], {}
        for entry in drawn:
            weight = float(entry.triangles() + 1)
            if entry.clip_rows is not None:
                projection = cameras.projection_of(entry.clip_rows, y_up)
                if projection is not None:
                    candidates.append((projection, weight))
            for name, matrix in entry.matrices:
                for form in (matrix, transposed(matrix)):
                    projection = cameras.projection_of(form, y_up)
                    if projection is not None:
                        candidates.append((projection, weight * 1e-3))
                        key = tuple(tuple(round(x, 5) for x in row) for row in form)
                        held = shared.setdefault(key, [form, 0.0, 0])
                        held[1] += weight
                        held[2] += 1
        projection = cameras.dominant(cameras.merged(candidates)[:4000])
        clips = [entry.mesh.clip(v) for entry in drawn for v in geometry.samples_of(entry.mesh, 16)]
        if projection is None:
            projection = cameras.assumed_projection(clips, self.viewport[2], self.viewport[3], y_up)
            if projection is None:
                raise ExportError("the RenderDoc capture can't be exported", "its main view has no perspective camera")
            self.notices.say("approximated: no matrix shows the projection; 60 degrees from bottom to top are assumed")
        return cameras.Camera(projection, self._view(drawn, projection, shared))

    def _in_scene(self, drawn, camera):
        """Without what does not stand where its w says: skies at the far plane, pictures laid on the screen."""
        kept = []
        for entry in drawn:
            clips = [entry.mesh.clip(v) for v in geometry.samples_of(entry.mesh)]
            reason = geometry.off_scene(clips, camera.projection, entry.state.depth_function.startswith("Greater"),
                                        entry.state.clip_depth_negative)
            if reason:
                self.notices.draw("left out: " + reason, entry.name)
            else:
                kept.append(entry)
        return kept

    def _view(self, drawn, projection, shared):
        found = []
        for form, weight, count in shared.values():
            is_pure = all(abs(x) < 1e-9 for x in (form[3][0], form[3][1], form[3][3]))
            if is_pure or count < max(2, len(drawn) // 4):
                continue
            for variant in cameras.clip_variants(form):
                other = cameras.projection_of(variant, drawn[0].state.clip_y_up)
                if other is None or not projection.is_near(other):
                    continue
                view = cameras.rigid_view(projection.view_rows(variant))
                if view is not None:
                    found.append((weight, view))
                    break
        if found:
            return max(found, key=lambda f: f[0])[1]
        named = {}
        for entry in drawn:
            for name, matrix in entry.matrices:
                if _names_view(name.split(".")[-1]):
                    for form in (matrix, transposed(matrix)):
                        if form[3] == (0.0, 0.0, 0.0, 1.0):
                            view = cameras.rigid_view(form[:3])
                            if view is not None:
                                named[view] = named.get(view, 0) + entry.triangles()
        if named:
            return max(named, key=named.get)
        same = []  # [rows, draws, triangles] of near maps
        for entry in drawn:
            if entry.clip_rows is None:
                continue
            for held in same:
                if cameras.are_near(held[0], entry.clip_rows):
                    break
            else:
                held = [entry.clip_rows, 0, 0]
                same.append(held)
            held[1] += 1
            held[2] += entry.triangles()
        for rows, count, _ in sorted(same, key=lambda s: -s[2]):
            view = cameras.rigid_view(projection.view_rows(rows))
            if view is not None and (count >= 2 or len(drawn) == 1):
                return view
        self.notices.say("approximated: no matrix shows where the camera stands; world space is the camera's")
        return ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))

    # --- passes over the same triangles

    def _layers(self, drawn):
        """Colour that stands in several draws at equal depth. A triangle that was drawn to depth alone and coloured by
        one opaque draw is that one's; what several make up is composed (self.piles); a draw over triangles that have
        colour already is left out."""
        self.piles = []
        prepass = [e for e in drawn if e.role == "prepass"]
        surfaces = [e for e in drawn if e.role == "surface"]
        over = [e for e in drawn if e.role == "layer"]
        for entry in drawn:
            entry.kept = set() if entry in over else set(range(entry.triangles()))
        bases = [e for e in surfaces if not (e.discards or e.state.blends or e.instances)]
        used = set()
        for stack in layers.stacks(prepass, surfaces + over):
            if any(entry.role == "surface" for entry, _, _ in stack.over):
                stack.base.kept.discard(stack.number)
            else:
                self._pile(stack, used)
        for stack in layers.stacks(bases, over):
            self._pile(stack, used)
        for entry in over:
            if entry.number not in used:
                self.notices.draw("left out: writes no depth (blended or decal)", entry.name)
        bare = [e for e in prepass if e.kept]
        for entry in bare:
            self.notices.draw("approximated: drawn to depth alone, {} of {} triangles get no colour from other draws"
                              .format(len(entry.kept), entry.triangles()), entry.name)
        return [e for e in drawn if e.kept]

    def _pile(self, stack, used):
        """Takes a stack's triangle from its draw and gives it to the one that shows, or to those to be composed."""
        base, pile = stack.base, []
        if base.role == "surface":
            pile.append((base, stack.number, (0, 1, 2)))
        for entry, t, order in stack.over:
            if entry.instances or not layers.can_be_composed(entry.state, base.role == "surface"):
                continue
            used.add(entry.number)
            # The same texture once more is another light's pass.
            if any(e.textures.get("base_colour") == entry.textures.get("base_colour") for e, _, _ in pile):
                continue
            if not entry.state.blends:
                pile = []
            elif entry.state.blend[0] == "SrcAlpha" and not any(c[3] > 0 for c in self._corner_colours(entry, t)):
                continue
            pile.append((entry, t, order))
        if pile == [] or pile[0][0] is base and len(pile) == 1:
            return
        base.kept.discard(stack.number)
        is_cut = base.discards and base.cutoff is not None
        if len(pile) == 1 and not pile[0][0].state.blends:
            entry, t, _ = pile[0]
            entry.kept.add(t)
            if is_cut and not entry.discards:
                entry.discards, entry.cutoff = True, base.cutoff
        elif numpy is None or is_cut:
            entry, t, _ = max(pile, key=lambda held: sum(c[3] for c in self._corner_colours(*held[:2])))
            entry.kept.add(t)
            why = "they are alpha-tested" if is_cut else "Python has no numpy"
            self.notices.draw("approximated: layers blended at equal depth; each triangle has the strongest one's "
                              "texture, as " + why, entry.name)
        else:
            self.piles.append((base, stack.number, pile))

    def _image(self, entry):
        """The base colour as a bake.Image; white where there is none."""
        number = entry.textures.get("base_colour", (None, None))[0]
        if number not in self.images:
            texels, wraps = numpy.full((1, 1, 4), 255, numpy.uint8), (1, 1)
            if number is not None:
                texture = self.builder.capture.textures[number]
                wraps = (texture.sampler.wrap_u, texture.sampler.wrap_v)
                found = textures.texels(texture)
                if found is None:
                    self.notices.draw("approximated: a layer's texture can't be decoded here; white", entry.name)
                else:
                    texels = found
            self.images[number] = bake.Image(texels, wraps, self.typical.target_is_srgb)
        return self.images[number]

    def _corner_colours(self, entry, t):
        """RGBA that a triangle's corners multiply its texture by."""
        if entry.tints is None:
            entry.tints = self._tints(entry)
        first = entry.mesh.first
        return [entry.tints[v - first] for v in entry.mesh.corners[3 * t:3 * t + 3]]

    def _tints(self, entry):
        mesh = entry.mesh
        values = None
        output = self._colour_output(entry)
        if output is not None:
            values = self._output_values(mesh, output[2], min(output[1], 4))
        elif entry.role == "layer":
            colour = geometry.pick(entry.attributes, geometry.COLOUR, 4, 4) or next(
                (a for a in entry.attributes if a.constant is None and a.format.kind == "UNorm" and a.format.width == 1
                 and a.format.count == 4), None)
            values = self._values(entry, colour, range(mesh.first, mesh.first + mesh.count), 4) if colour else None
        values = [(1.0,) * 4] * mesh.count if values is None else [tuple(v) + (1.0,) * (4 - len(v)) for v in values]
        if entry.colour is not None:
            values = [tuple(a * b for a, b in zip(v, entry.colour + (1.0,))) for v in values]
        return [tuple(min(max(x, 0.0), 1.0) for x in v) for v in values]

    def _composed(self, camera, frame):
        """Draws of the triangles that several draws make up, with a texture of what those leave together."""
        if not self.piles:
            return
        made, images, numbers = [], [], {}
        for base, t, pile in self.piles:
            points, rows = self._corner_places(base, t, camera)
            corners = base.mesh.corners[3 * t:3 * t + 3]
            start = points.index(min(points))
            turn = [start, (start + 1) % 3, (start + 2) % 3]
            if self._is_turned(base, rows):
                turn = [turn[0], turn[2], turn[1]]
            held = []
            for entry, u, order in pile:
                image = self._image(entry)
                number = numbers.setdefault(id(image), len(images))
                if number == len(images):
                    images.append(image)
                uvs, tints = self._corner_uvs(entry, u), self._corner_colours(entry, u)
                held.append((number, [uvs[order[i]] for i in turn], [tints[order[i]] for i in turn],
                             entry.state.blend if entry.state.blends else None))
            clips = [base.mesh.clip(corners[i]) for i in turn]
            made.append(((points[turn[0]], points[turn[1]], points[turn[2]]), rows, base,
                         bake.Cell(clips, bake.is_in_view(clips), held)))
        # In the order of where they lie, so that an application's way of splitting its draws does not show.
        made.sort(key=lambda item: item[0])
        width, height, texels, uvs = bake.bake([item[3] for item in made], images, self.viewport[2:4],
                                               self.typical.target_is_srgb)
        texture = self.builder.texture(spcap.Texture(
            name="composed layers", width=width, height=height, bytes=texels, srgb=True,
            sampler=spcap.Sampler(wrap_u=1, wrap_v=1)))
        groups = []  # [rows, two-sided, numbers]
        for number, (_, rows, base, _) in enumerate(made):
            two_sided = base.state.cull == "None"
            for group in groups:
                if group[1] == two_sided and cameras.are_near(group[0], rows):
                    break
            else:
                group = [rows, two_sided, []]
                groups.append(group)
            group[2].append(number)
        for place, (rows, two_sided, members) in enumerate(groups):
            count = 3 * len(members)
            draw = Draw(name="composed layers {}".format(place), vertex_count=count, index_count=count,
                        transform=column_major(rows))
            draw.material = self.builder.material(name="composed layers", base_colour_texture=texture,
                                                  two_sided=two_sided)
            draw.position = self._numbers([p for n in members for p in made[n][0]], 3)
            draw.uv = self._numbers([tuple(uv) for n in members for uv in uvs[n].tolist()], 2)
            frame.draws.append(draw)
        for entry in sorted(set(e for _, _, pile in self.piles for e, _, _ in pile), key=lambda e: e.number):
            self.notices.draw("approximated: {} triangles that several draws blended at equal depth make up have one "
                              "texture of {}x{} texels, composed without light and about as fine as the pixels".format(
                                  len(made), width, height), entry.name)

    def _corner_places(self, entry, t, camera):
        """(positions of a triangle's corners, rows of the map that takes them to the world)."""
        if entry.placement is None:
            maps = self._placements(entry, camera)
            entry.placement = (maps[0], entry.position) if maps else (((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0),
                                                                       (0.0, 0.0, 1.0, 0.0)), None)
        rows, position = entry.placement
        corners = entry.mesh.corners[3 * t:3 * t + 3]
        if position is None:
            return [camera.world(entry.mesh.clip(v)) for v in corners], rows
        return self._values(entry, position, corners, 3), rows

    @staticmethod
    def _is_turned(entry, rows):
        """Whether corners have to be turned round so that the visible side is counter-clockwise on the image, clockwise
        where the placement mirrors (glTF)."""
        mirrors = rows is not None and determinant(rows) < 0
        return entry.state.cull != "None" and ((entry.state.cull == "Back") != entry.state.front_ccw) != mirrors

    # --- records

    def _frame(self, number, camera):
        x, y, width, height = self.viewport[:4]
        state = self.typical
        projection = camera.projection
        depth = spcap.ClipDepth.MINUS_ONE_TO_ONE if state.clip_depth_negative else spcap.ClipDepth.ZERO_TO_ONE
        if state.depth_function.startswith("Greater"):
            if state.clip_depth_negative:
                projection.c, projection.d = (projection.c + 1) / 2, projection.d / 2
            depth = spcap.ClipDepth.ONE_TO_ZERO
        frame = Frame(name="frame {}".format(number), time_s=number / 60.0, view=camera.view_matrix(),
                      projection=camera.projection_matrix(), clip_depth=depth, clip_y_up=state.clip_y_up,
                      width=max(int(round(width)), 1), height=max(int(round(height)), 1), ambient=(1.0, 1.0, 1.0))
        if self.options.sun:
            frame.sun = spcap.DirectionalLight(direction=tuple(self.options.sun))
            frame.ambient = (0.35, 0.35, 0.35)
        else:
            self.notices.say("lights are not guessed: ambient light of 1 from everywhere")
        return frame

    def _draw(self, entry, camera, frame, seen):
        mesh = entry.mesh
        corners = mesh.corners
        if len(entry.kept) < entry.triangles():
            corners = [v for t in sorted(entry.kept) for v in corners[3 * t:3 * t + 3]]
        place = self._placements(entry, camera)
        if self._is_turned(entry, place[0] if place else None):
            corners = [v for t in range(0, len(corners), 3) for v in (corners[t], corners[t + 2], corners[t + 1])]
        draw = Draw(material=self._material(entry))
        resources = sorted(set(str(a.resource).split(":")[-1] for a in entry.attributes if a.constant is None))
        name = "vertices {} from {}, {} triangles".format("+".join(resources) or "generated", mesh.first,
                                                         len(corners) // 3)
        seen[name] = seen.get(name, 0) + 1
        draw.name = name if seen[name] == 1 else "{} ({})".format(name, seen[name])
        copies = [mesh] if place is not None else [mesh] + entry.instances
        draw.vertex_count = mesh.count * len(copies)
        self._indices(draw, [v - mesh.first for v in corners], mesh.count, len(copies))
        self._uv_and_colour(draw, entry, copies)
        if place is not None:
            self._rigid(draw, entry, place)
        else:
            self.notices.draw("approximated: no matrix places it; positions are as the vertex shader gave them, in the "
                              "world", entry.name)
            self._placed(draw, copies, corners, camera)
        frame.draws.append(draw)

    def _placements(self, entry, camera):
        """World map of each instance, or None where one has none."""
        if entry.position is None:
            return None
        sampled, points = entry.points
        maps = []
        for instance in [entry.mesh] + entry.instances:
            rows = geometry.world_map(points, [instance.clip(v) for v in sampled], camera, self.viewport[3])
            if rows is None:
                return None
            maps.append(rows)
        return maps

    def _indices(self, draw, corners, count, copies):
        """Of one mesh of `count` vertices whose copies lie one after the other."""
        values = [v + count * copy for copy in range(copies) for v in corners]
        draw.index_count = len(values)
        if count * copies <= 65536:
            draw.index_type, data = spcap.IndexType.UINT16, struct.pack("<%dH" % len(values), *values)
        else:
            draw.index_type, data = spcap.IndexType.UINT32, struct.pack("<%dI" % len(values), *values)
        draw.index_buffer = self.builder.buffer(data, "indices")

    def _stream(self, entry, attribute, components, copies=1):
        """A stream of the attribute: its own bytes where the capture has the format, else numbers."""
        mesh, data = entry.mesh, entry.data.get(getattr(attribute, "key", None))
        if data is None:
            return VertexStream()
        form = attribute.format.same()
        last = attribute.within + (mesh.count - 1) * attribute.stride + attribute.format.bytes
        if last > len(data):
            return VertexStream()
        is_short = form is not None and attribute.format.count < min(components, 3)
        if form is not None and not is_short and attribute.stride >= attribute.format.bytes:
            if copies > 1:
                data = data.ljust(attribute.stride * mesh.count, b"\0")[:attribute.stride * mesh.count] * copies
            return VertexStream(buffer=self.builder.buffer(data, "vertices"), format=form, offset=attribute.within,
                                stride=attribute.stride)
        values = attribute.format.decode(data, attribute.within, attribute.stride, mesh.count)
        return self._numbers(list(values) * copies, components)

    def _numbers(self, values, components):
        form = {2: VertexFormat.FLOAT32X2, 3: VertexFormat.FLOAT32X3, 4: VertexFormat.FLOAT32X4}[components]
        return VertexStream(buffer=self.builder.buffer(float_bytes(values, components), "vertices"), format=form,
                            stride=4 * components)

    @staticmethod
    def _output_values(mesh, offset, count):
        """Of each vertex what the vertex shader handed on; 0 for vertices that are not drawn."""
        data, stride = mesh.outputs
        shape = struct.Struct("<%df" % count)
        values = [(0.0,) * count] * mesh.count
        for vertex, post in mesh.post.items():
            values[vertex - mesh.first] = shape.unpack_from(data, post * stride + offset)
        return values

    def _uv_and_colour(self, draw, entry, copies):
        output, attribute = self._uv_source(entry)
        if output is not None:
            draw.uv = self._numbers([v for copy in copies for v in self._output_values(copy, output[2], 2)], 2)
        elif attribute is not None:
            draw.uv = self._stream(entry, attribute, 2, len(copies))
        if entry.role != "layer":
            draw.colour = self._colours(entry, copies)

    def _uv_source(self, entry):
        """(vertex shader's output, attribute): one of them, where the base colour's uvs are, or neither."""
        mesh = entry.mesh
        attribute = geometry.pick(entry.attributes, geometry.UV, 2, 4)
        if attribute is None:
            attribute = next((a for a in entry.attributes if a.constant is None and not a.per_instance
                              and a.format.count == 2 and a is not entry.position), None)
        found = [o for o in entry.outputs if o[2] > 0 and o[1] >= 2]
        named = [o for o in found if entry.uv_name and o[0].split(".")[-1] == entry.uv_name]
        named += [o for o in found if re.search(geometry.UV, o[0], re.I) and not re.search(textures.NEVER, o[0], re.I)]
        if named and attribute is not None:
            sampled = geometry.samples_of(mesh, 32)
            ins = self._values(entry, attribute, sampled, 2)
            data, stride = mesh.outputs
            outs = [struct.unpack_from("<2f", data, mesh.post[v] * stride + named[0][2]) for v in sampled]
            if ins is not None and all(abs(a - b) <= 1e-5 * max(1.0, abs(b)) for p, q in zip(ins, outs)
                                       for a, b in zip(p, q)):
                return None, attribute
        return (named[0], None) if named else (None, attribute)

    def _corner_uvs(self, entry, t):
        """Where a triangle's corners read the base colour."""
        if entry.uvs is None:
            mesh = entry.mesh
            output, attribute = self._uv_source(entry)
            entry.uvs = [(0.0, 0.0)] * mesh.count
            if output is not None:
                entry.uvs = self._output_values(mesh, output[2], 2)
            elif attribute is not None:
                entry.uvs = self._values(entry, attribute, range(mesh.first, mesh.first + mesh.count), 2) or entry.uvs
        return [entry.uvs[v - entry.mesh.first] for v in entry.mesh.corners[3 * t:3 * t + 3]]

    @staticmethod
    def _colour_output(entry):
        return next((o for o in entry.outputs if o[2] > 0 and o[1] >= 3 and re.search(geometry.COLOUR, o[0], re.I)),
                    None)

    def _colours(self, entry, copies):
        """Vertex colours that the vertex shader hands on as such, as it hands them on; those that it keeps are data of
        its own, such as how much the wind bends a plant."""
        mesh = entry.mesh
        colour = geometry.pick(entry.attributes, geometry.COLOUR, 3, 4)
        output = self._colour_output(entry)
        if colour is None or output is None:
            return VertexStream()
        _, count, offset = output
        sampled = geometry.samples_of(mesh, 32)
        ins = self._values(entry, colour, sampled, count)
        data, stride = mesh.outputs
        outs = [struct.unpack_from("<%df" % count, data, mesh.post[v] * stride + offset) for v in sampled]
        if ins is None or any(abs(a - b) > 1e-3 for p, q in zip(ins, outs) for a, b in zip(p, q)):
            return self._numbers([tuple(min(max(x, 0.0), 1.0) for x in v) for copy in copies
                                  for v in self._output_values(copy, offset, count)], count)
        stream = self._stream(entry, colour, 4, len(copies))
        return VertexStream() if stream.buffer != spcap.NONE and stream.format not in (1, 2, 4, 8, 9) else stream

    def _rigid(self, draw, entry, maps):
        draw.position = self._stream(entry, entry.position, 3)
        normal = geometry.pick(entry.attributes, geometry.NORMAL, 3, 4)
        if normal is not None and normal is not entry.position:
            draw.normal = self._stream(entry, normal, 3)
        tangent = geometry.pick(entry.attributes, geometry.TANGENT, 3, 4)
        if tangent is not None and "normal" in entry.textures:
            draw.tangent = self._stream(entry, tangent, 4)
        if entry.state.cull != "None" and len(set(determinant(rows) < 0 for rows in maps)) > 1:
            self.notices.draw("approximated: some instances are mirrored; the wrong side of those shows", entry.name)
        if len(maps) == 1:
            draw.transform = column_major(maps[0])
            return
        data = b"".join(struct.pack("<16f", *column_major(rows)) for rows in maps)
        draw.instance_buffer, draw.instance_count = self.builder.buffer(data, "instances"), len(maps)

    def _placed(self, draw, copies, corners, camera):
        places, normals = [], []
        for mesh in copies:
            positions = dict((vertex, camera.world(mesh.clip(vertex))) for vertex in mesh.post)
            place, normal = [(0.0, 0.0, 0.0)] * mesh.count, [(0.0, 0.0, 1.0)] * mesh.count
            for vertex, position in positions.items():
                place[vertex - mesh.first] = position
            for vertex, direction in geometry.smooth_normals(positions, corners).items():
                normal[vertex - mesh.first] = direction
            places.extend(place)
            normals.extend(normal)
        draw.position, draw.normal = self._numbers(places, 3), self._numbers(normals, 3)

    def _material(self, entry):
        values = {"two_sided": entry.state.cull == "None"}
        for role, (number, _) in entry.textures.items():
            values[role + "_texture"] = number
        if "metallic_roughness" in entry.textures:
            values["metallic"] = values["roughness"] = 1.0
        base, alpha = entry.textures.get("base_colour", (spcap.NONE, False))
        if entry.role == "layer" and entry.state.blends:
            pass
        elif entry.discards and base != spcap.NONE:
            values["alpha_mode"] = spcap.AlphaMode.TEST
            values["alpha_cutoff"] = entry.cutoff if entry.cutoff is not None else 0.5
            if entry.cutoff is None:
                self.notices.draw("approximated: the shader discards by something else than a constant; alpha 0.5 is "
                                  "taken", entry.name)
        elif entry.state.blends and alpha is not False:
            values["alpha_mode"], values["alpha_cutoff"] = spcap.AlphaMode.TEST, 0.5
            self.notices.draw("approximated: blended and writes depth; taken as alpha-tested at 0.5", entry.name)
        if entry.colour is not None and entry.role != "prepass":
            values["base_colour"] = entry.colour + (1.0,)
        elif base == spcap.NONE:
            self.notices.draw("approximated: no base colour texture; white", entry.name)
        return self.builder.material(name="material of " + entry.name, **values)


def _export(replays, options):
    builder = Builder()
    metadata = builder.capture.metadata
    metadata.title, metadata.application = options.title, options.application
    metadata.tool, metadata.licence = TOOL, options.licence
    for number, open_replay in enumerate(replays):
        replay = open_replay()
        try:
            builder.texture_of = {}
            work = FrameExport(replay, builder, options)
            work.run(number)
            options.progress("frame {}: {} draws, {} triangles".format(
                number, len(builder.capture.frames[-1].draws),
                sum(d.index_count // 3 * d.instance_count for d in builder.capture.frames[-1].draws)))
        finally:
            replay.close()
    builder.drop_unused_textures()
    metadata.notices = [n[:60000] for n in metadata.notices[:4000]]
    return builder.capture


def export_files(paths, out, options=None):
    """Exports .rdc files, a frame each, to one capture, and returns it. Raises ExportError and CaptureError."""
    options = options or Options()
    # No pixel is looked at, and nearly all of a replay's time goes to them where the CPU draws: Mesa's software
    # drivers leave them out when asked to, others know nothing of it.
    os.environ.setdefault("LP_NO_RAST", "1")
    rd = renderdoc_module()
    rd.InitialiseReplay(rd.GlobalEnvironment(), [])
    try:
        capture = _export([lambda path=path: Replay.open(rd, path) for path in paths], options)
    finally:
        rd.ShutdownReplay()
    spcap.write(capture, out, LEVEL)
    return capture


def export_open_capture(pyrenderdoc, out, options=None):
    """Exports the capture that is open in qrenderdoc, whose Python shell has `pyrenderdoc`."""
    rd = renderdoc_module()
    options = options or Options()
    made = []

    def work(controller):
        try:
            replay = Replay(rd, controller, controller.GetStructuredFile())
            made.append(_export([lambda: replay], options))
        except Exception as error:  # handed to the caller's thread
            made.append(error)

    pyrenderdoc.Replay().BlockInvoke(work)
    if isinstance(made[0], Exception):
        raise made[0]
    spcap.write(made[0], out, LEVEL)
    return made[0]
