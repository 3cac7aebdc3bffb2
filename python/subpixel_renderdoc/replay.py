"""One capture open in RenderDoc, asked draw by draw: state, constants, attributes, vertex shader outputs."""
import struct

from . import glsl
from .errors import ExportError
from .formats import AttributeFormat


FACTORS = ("Zero", "One", "SrcCol", "InvSrcCol", "DstCol", "InvDstCol", "SrcAlpha", "InvSrcAlpha")  # of blending


class DrawState:
    """How a draw was drawn, whatever API it came through."""

    def __init__(self):
        self.depth_test = self.depth_write = False
        self.depth_function = "Always"
        self.cull = "None"         # None, Front, Back, Both
        self.front_ccw = True      # as seen on the image
        self.blends = False        # the first target's colour is mixed with what was there
        self.blend = None          # (factor of the source's colour, of what was there), where they are added
        self.target_is_srgb = False
        self.writes_colour = True
        self.clip_y_up = True
        self.clip_depth_negative = False
        self.viewport = (0.0, 0.0, 1.0, 1.0, 0.0, 1.0)  # x, y, width, height in pixels, least and largest depth
        self.topology = None       # list, strip, fan; None: no triangles
        self.restart_index = None
        self.has_other_stages = False


class Attribute:
    """A vertex attribute: where its elements are, relative to a vertex number."""

    def __init__(self, name, location, resource, offset, stride, form, per_instance, constant):
        self.name, self.location, self.resource, self.offset, self.stride = name, location, resource, offset, stride
        self.format, self.per_instance, self.constant = form, per_instance, constant


class Replay:
    """Opens a .rdc, or takes a controller that is open already."""

    def __init__(self, rd, controller, structured_file, close=None):
        self.rd, self.controller, self.structured = rd, controller, structured_file
        self._close = close or (lambda: None)
        self.null = rd.ResourceId.Null()
        self.textures = dict((str(t.resourceId), t) for t in controller.GetTextures())
        self._buffers = {}
        self._matrices = {}

    @classmethod
    def open(cls, rd, path):
        what = "the RenderDoc capture can't be read"
        capture = rd.OpenCaptureFile()
        result = capture.OpenFile(path, "", None)
        if result.code != rd.ResultCode.Succeeded:
            capture.Shutdown()
            raise ExportError(what, _reason(rd, result), path)
        if capture.LocalReplaySupport() != rd.ReplaySupport.Supported:
            driver = capture.DriverName()
            capture.Shutdown()
            raise ExportError(what, "this machine cannot replay captures of {}".format(driver), path)
        result, controller = capture.OpenCapture(rd.ReplayOptions(), None)
        if result.code != rd.ResultCode.Succeeded:
            capture.Shutdown()
            raise ExportError(what, _reason(rd, result), path)

        def close():
            controller.Shutdown()
            capture.Shutdown()

        return cls(rd, controller, controller.GetStructuredFile(), close)

    def close(self):
        self._close()

    def draws(self):
        """All draw calls of the frame, in order."""
        found = []

        def walk(actions):
            for action in actions:
                if action.flags & self.rd.ActionFlags.Drawcall:
                    found.append(action)
                walk(action.children)

        walk(self.controller.GetRootActions())
        return found

    def name(self, action):
        return action.GetName(self.structured)

    def go_to(self, action):
        self.controller.SetFrameEvent(action.eventId, False)
        self.pipe = self.controller.GetPipelineState()
        return self.pipe

    def buffer(self, resource, offset, size):
        """Bytes of a buffer at the current event."""
        return bytes(self.controller.GetBufferData(resource, offset, size)) if size > 0 else b""

    # --- state

    def state(self):
        rd, pipe, state = self.rd, self.pipe, DrawState()
        view = pipe.GetViewport(0)
        state.viewport = (view.x, view.y, view.width, view.height, view.minDepth, view.maxDepth)
        topologies = {rd.Topology.TriangleList: "list", rd.Topology.TriangleStrip: "strip",
                      rd.Topology.TriangleFan: "fan"}
        state.topology = topologies.get(pipe.GetPrimitiveTopology())
        if pipe.IsRestartEnabled():
            state.restart_index = pipe.GetRestartIndex()
        stages = rd.ShaderStage
        state.has_other_stages = any(pipe.GetShader(stage) != self.null
                                     for stage in (stages.Hull, stages.Domain, stages.Geometry))
        blends = pipe.GetColorBlends()
        if blends:
            blend = blends[0]
            state.writes_colour = (blend.writeMask & 7) != 0
            one, zero = rd.BlendMultiplier.One, rd.BlendMultiplier.Zero
            state.blends = blend.enabled and not (blend.colorBlend.source == one and
                                                  blend.colorBlend.destination == zero)
            if state.blends and blend.colorBlend.operation == rd.BlendOperation.Add:
                state.blend = (self._factor(blend.colorBlend.source), self._factor(blend.colorBlend.destination))
        targets = pipe.GetOutputTargets()
        first = self.textures.get(str(targets[0].resourceId)) if targets else None
        state.target_is_srgb = first is not None and first.format.compType == rd.CompType.UNormSRGB
        if not any(t.resourceId != self.null for t in targets):
            state.writes_colour = False
        if pipe.IsCaptureGL():
            self._gl(state)
        elif pipe.IsCaptureVK():
            self._vulkan(state)
        else:
            self._direct3d(state, self.controller.GetD3D11PipelineState() if pipe.IsCaptureD3D11() else
                           self.controller.GetD3D12PipelineState())
        return state

    def _gl(self, state):
        gl = self.controller.GetGLPipelineState()
        depth, raster = gl.depthState, gl.rasterizer.state
        state.depth_test, state.depth_write = depth.depthEnable, depth.depthEnable and depth.depthWrites
        state.depth_function = self._function(depth.depthFunction)
        state.cull, state.front_ccw = self._cull(raster.cullMode), raster.frontCCW
        state.clip_y_up = gl.vertexProcessing.clipOriginLowerLeft
        state.clip_depth_negative = gl.vertexProcessing.clipNegativeOneToOne

    def _vulkan(self, state):
        vk = self.controller.GetVulkanPipelineState()
        depth, raster = vk.depthStencil, vk.rasterizer
        state.depth_test, state.depth_write = depth.depthTestEnable, depth.depthTestEnable and depth.depthWriteEnable
        state.depth_function = self._function(depth.depthFunction)
        state.cull, state.front_ccw = self._cull(raster.cullMode), raster.frontCCW
        state.clip_y_up = state.viewport[3] < 0
        if state.clip_y_up:
            x, y, width, height, low, high = state.viewport
            state.viewport = (x, y + height, width, -height, low, high)

    def _direct3d(self, state, d3d):
        depth, raster = d3d.outputMerger.depthStencilState, d3d.rasterizer.state
        state.depth_test, state.depth_write = depth.depthEnable, depth.depthEnable and depth.depthWrites
        state.depth_function = self._function(depth.depthFunction)
        state.cull, state.front_ccw = self._cull(raster.cullMode), raster.frontCCW

    def _function(self, value):
        for name in ("Never", "AlwaysTrue", "Less", "LessEqual", "Greater", "GreaterEqual", "Equal", "NotEqual"):
            if value == getattr(self.rd.CompareFunction, name):
                return name
        return "AlwaysTrue"

    def _factor(self, value):
        for name in FACTORS:
            if value == getattr(self.rd.BlendMultiplier, name):
                return name
        return "other"

    def _cull(self, value):
        kinds = self.rd.CullMode
        return {kinds.NoCull: "None", kinds.Front: "Front", kinds.Back: "Back"}.get(value, "Both")

    # --- vertices

    def index_stream(self, action):
        """Indices as drawn, base vertex added, None where a strip is broken; or None for draws without indices."""
        rd, pipe = self.rd, self.pipe
        if not action.flags & rd.ActionFlags.Indexed:
            return None
        held = pipe.GetIBuffer()
        size = held.byteStride
        data = self.buffer(held.resourceId, held.byteOffset + action.indexOffset * size, action.numIndices * size)
        return self._unpacked(data, size, action.numIndices)

    def index_bytes(self):
        return self.pipe.GetIBuffer().byteStride or 4

    @staticmethod
    def _unpacked(data, size, count):
        letter = {1: "B", 2: "H", 4: "I"}.get(size)
        if letter is None:
            return None
        count = min(count, len(data) // size)
        return struct.unpack("<%d%s" % (count, letter), data[:count * size])

    def attributes(self):
        """Vertex attributes that the vertex shader reads."""
        pipe, found = self.pipe, []
        buffers = pipe.GetVBuffers()
        reflection = pipe.GetShaderReflection(self.rd.ShaderStage.Vertex)
        names = {}
        if reflection is not None:
            for parameter in reflection.inputSignature:
                names[parameter.regIndex] = parameter.varName or parameter.semanticIdxName or parameter.semanticName
        for location, attribute in enumerate(pipe.GetVertexInputs()):
            if not attribute.used:
                continue
            form = AttributeFormat(self.rd, attribute.format)
            if not form.is_known:
                continue
            name = attribute.name or names.get(location, "")
            if attribute.genericEnabled:
                value = attribute.genericValue
                constant = tuple((value.floatValue if hasattr(value, "floatValue") else value.f32v)[:4])
                found.append(Attribute(name, location, self.null, 0, 0, form, False, constant))
                continue
            if attribute.vertexBuffer >= len(buffers):
                continue
            held = buffers[attribute.vertexBuffer]
            if held.resourceId == self.null:
                continue
            found.append(Attribute(name, location, held.resourceId, held.byteOffset + attribute.byteOffset,
                                   held.byteStride, form, attribute.perInstance, None))
        return found

    def outputs(self):
        """(name, components, byte offset) of what the vertex shader hands on; positions first, at offset 0."""
        reflection = self.pipe.GetShaderReflection(self.rd.ShaderStage.Vertex)
        aligned = self.pipe.HasAlignedPostVSData(self.rd.MeshDataStage.VSOut)
        parameters = list(reflection.outputSignature)
        position = [p for p in parameters if p.systemValue == self.rd.ShaderBuiltin.Position]
        found, offset = [], 0
        for parameter in position + [p for p in parameters if p.systemValue != self.rd.ShaderBuiltin.Position]:
            if aligned:
                unit = 4 * {1: 1, 2: 2}.get(parameter.compCount, 4)
                offset = (offset + unit - 1) // unit * unit
            name = parameter.varName or parameter.semanticIdxName or parameter.semanticName
            found.append((name, parameter.compCount, offset))
            offset += 4 * parameter.compCount
        return found

    def vertex_outputs(self, instance):
        """(bytes, stride, index of each vertex drawn or None, base) after the vertex shader, or None."""
        mesh = self.controller.GetPostVSData(instance, 0, self.rd.MeshDataStage.VSOut)
        if mesh.vertexResourceId == self.null or mesh.vertexByteStride == 0:
            return None
        indices, count = None, mesh.numIndices
        if mesh.indexByteStride and mesh.indexResourceId != self.null:
            data = self.buffer(mesh.indexResourceId, mesh.indexByteOffset, mesh.numIndices * mesh.indexByteStride)
            indices = self._unpacked(data, mesh.indexByteStride, mesh.numIndices)
            limit = (1 << 8 * mesh.indexByteStride) - 1
            used = [i for i in indices if i != limit] or [0]
            count = max(used) + 1 + max(mesh.baseVertex, 0)
        data = self.buffer(mesh.vertexResourceId, mesh.vertexByteOffset, count * mesh.vertexByteStride)
        return data, mesh.vertexByteStride, indices, mesh.baseVertex

    # --- constants

    def matrices(self):
        """(name, four rows of four) of the vertex shader's 4x4 constants: M v with columns as vectors."""
        found = []
        for block, variable in self._constants(self.rd.ShaderStage.Vertex,
                                               lambda block: any(_has_matrix(v.type) for v in block.variables)):
            self._collect(variable, block.name, found)
        return found

    def fragment_constants(self):
        """Name -> number of the fragment shader's scalars and components of vectors, by the names that sources use."""
        found = {}

        def collect(variable, prefix):
            names = [prefix + variable.name, variable.name]
            if len(variable.members):
                for member in list(variable.members)[:32]:
                    collect(member, prefix + variable.name + ".")
                return
            if variable.rows != 1 or variable.columns > 4:
                return
            kinds = self.rd.VarType
            values = variable.value.f32v if variable.type in (kinds.Float, kinds.Half) else variable.value.s32v
            for name in names:
                if variable.columns == 1:
                    found[name] = values[0]
                for c in range(variable.columns):
                    found[name + "." + "xyzw"[c]] = found[name + "." + "rgba"[c]] = values[c]

        for block, variable in self._constants(self.rd.ShaderStage.Fragment, lambda block: True):
            collect(variable, "")
            if block.name:
                collect(variable, block.name + ".")
        return found

    def _constants(self, stage, wanted):
        """(block, variable) of a stage's constant blocks, those that `wanted` takes."""
        rd, pipe = self.rd, self.pipe
        reflection = pipe.GetShaderReflection(stage)
        if reflection is None:
            return
        for i, block in enumerate(reflection.constantBlocks):
            if not wanted(block):
                continue
            if hasattr(pipe, "GetConstantBlock"):
                held = pipe.GetConstantBlock(stage, i, 0).descriptor
                resource, offset, size = held.resource, held.byteOffset, held.byteSize
            else:
                held = pipe.GetConstantBuffer(stage, i, 0)
                resource, offset, size = held.resourceId, held.byteOffset, held.byteSize
            variables = self.controller.GetCBufferVariableContents(
                pipe.GetGraphicsPipelineObject(), reflection.resourceId, stage, pipe.GetShaderEntryPoint(stage), i,
                resource, offset, size)
            for variable in variables:
                yield block, variable

    def _collect(self, variable, prefix, found):
        if len(found) >= 64:
            return
        name = "{}.{}".format(prefix, variable.name)
        if len(variable.members):
            for member in list(variable.members)[:16]:
                self._collect(member, name, found)
        elif variable.rows == 4 and variable.columns == 4:
            v = list(variable.value.f32v[:16])
            found.append((name, tuple(tuple(v[4 * r:4 * r + 4]) for r in range(4))))

    # --- the fragment shader and its textures

    def fragment_source(self):
        """Source or disassembly of the fragment shader; empty where there is none."""
        rd, pipe = self.rd, self.pipe
        reflection = pipe.GetShaderReflection(rd.ShaderStage.Fragment)
        if reflection is None:
            return None, ""
        key = str(reflection.resourceId)
        if key not in self._matrices:
            text = ""
            if reflection.encoding == rd.ShaderEncoding.GLSL:
                text = glsl.active(bytes(reflection.rawBytes).decode("latin-1"))
            else:
                text = self.controller.DisassembleShader(pipe.GetGraphicsPipelineObject(), reflection, "")
            self._matrices[key] = text
        return key, self._matrices[key]

    def fragment_textures(self):
        """(name, slot, resource id, sampler) of the 2D textures bound to the fragment shader's names."""
        rd, pipe = self.rd, self.pipe
        stage = rd.ShaderStage.Fragment
        reflection = pipe.GetShaderReflection(stage)
        if reflection is None:
            return []
        found = []
        bound = list(pipe.GetReadOnlyResources(stage))
        for number, resource in enumerate(reflection.readOnlyResources):
            if not resource.isTexture:
                continue
            for slot, held in self._bound(pipe, stage, bound, number, resource):
                if held != self.null and str(held) in self.textures:
                    found.append((resource.name, slot, held))
                    break
        return found

    def _bound(self, pipe, stage, bound, number, resource):
        if bound and hasattr(bound[0], "descriptor"):  # RenderDoc 1.31 and later
            return [(number, b.descriptor.resource) for b in bound if b.access.index == number]
        mapping = pipe.GetBindpointMapping(stage).readOnlyResources
        if resource.bindPoint >= len(mapping):
            return []
        point = mapping[resource.bindPoint]
        return [(point.bind, b.resourceId) for array in bound
                if array.bindPoint.bindset == point.bindset and array.bindPoint.bind == point.bind
                for b in array.resources]

    def sampler(self, slot, name):
        """(wrap u, wrap v, magnify, minify, mip) of a slot as SPEC.md numbers them, or None."""
        try:
            if self.pipe.IsCaptureGL():
                held = self.controller.GetGLPipelineState().samplers[slot]
            elif self.pipe.IsCaptureVK():
                held = self._vulkan_sampler(slot)
            else:
                return None
            if held is None:
                return None
            modes = self.rd.AddressMode
            wraps = {modes.Wrap: 0, modes.ClampEdge: 1, modes.Mirror: 2}
            filters = self.rd.FilterMode
            u = held.addressS if hasattr(held, "addressS") else held.addressU
            v = held.addressT if hasattr(held, "addressT") else held.addressV
            way = held.filter
            mip = 2 if way.mip == filters.NoFilter else 1 if way.mip == filters.Point else 0
            return (wraps.get(u, 1), wraps.get(v, 1), int(way.magnify == filters.Point),
                    int(way.minify == filters.Point), mip)
        except (AttributeError, IndexError, TypeError):
            return None

    def _vulkan_sampler(self, slot):
        for descriptor_set in self.controller.GetVulkanPipelineState().graphics.descriptorSets:
            for number, binding in enumerate(descriptor_set.bindings):
                if number == slot and len(binding.binds) and binding.binds[0].samplerResourceId != self.null:
                    return binding.binds[0]
        return None


def _has_matrix(kind):
    return (kind.rows == 4 and kind.columns == 4) or any(_has_matrix(member.type) for member in kind.members)


def _reason(rd, result):
    return result.Message() or str(result.code)
