// What the interface headers are written in. One for each technique and each folder of shared passes declares, for both
// languages, the ids of specialization constants (NAME_CONSTANT_X), the slots of descriptors within their kind
// (NAME_SLOT_X), push constants (struct NamePush) and the sizes of states; shaders say
//   layout(constant_id = DCAA_CONSTANT_SURFACES) const uint SURFACES = 4u;
//   layout(set = 0, binding = STORAGE(DCAA_SLOT_TABLE), scalar) readonly buffer CoverageTable { ... };
//   layout(push_constant, scalar) uniform Push { DcaaKeepPush push; };
// and the host {DCAA_CONSTANT_SURFACES, n}, gpu::reads(DCAA_SLOT_TABLE, table) and DcaaKeepPush with pass.reads(buffer).
#ifndef SUBPIXEL_INTERFACE_H
#define SUBPIXEL_INTERFACE_H

// Bindings of set 0; their ranges are those of the layout that all pipelines share (replay/gpu/pipeline.hpp).
#define UNIFORM_BINDING 0
#define STORAGE(slot) (1 + slot)
#define SAMPLED(slot) (13 + slot)
#define STORAGE_IMAGE(slot) (21 + slot)
#define INPUT_ATTACHMENT(index) (24 + index)

// Constants that a frame gives to all of its passes; a shader may leave them out. Those of one pass or technique start
// at PASS_CONSTANTS.
#define CONSTANT_SAMPLES 0
#define CONSTANT_FEATURES 1       // FEATURE_ bits
#define CONSTANT_SHADING_MODEL 2  // SHADING_MODEL_
#define CONSTANT_ALPHA_MODE 3     // ALPHA_MODE_
#define CONSTANT_SAMPLE_GROUP 4   // which GROUP_SAMPLES samples of the pattern
#define CONSTANT_RESOLVE 5        // 1: samples are averaged after the tone curve
#define CONSTANT_GROUP_SAMPLES 6
#define PASS_CONSTANTS 7

// 1 where `bits` have the bit, else 0: for sizes that follow from constants.
#define BIT_OF(bits, bit) (((bits) / (bit)) & 1u)

// Slots that the frame's own resources have in every pass; its constants are the uniform buffer.
#define FRAME_SLOT_SPOT_CONES 8   // storage
#define FRAME_SLOT_UV_MAPPINGS 9  // storage
#define FRAME_SLOT_MATERIALS 10   // storage, of passes over fragments
#define FRAME_SLOT_LIGHT_CELLS 11 // storage, of passes that light
#define FRAME_SLOT_SHADOW_MAP 7   // sampled
#define FRAME_SLOT_VISIBILITY 0   // sampled, of passes after the visibility pass

// Bindings of set 1: the textures of one material, in the order of textures_of() (replay/scene/materials.hpp).
#define MATERIAL_SLOT_BASE_COLOUR 0
#define MATERIAL_SLOT_METALLIC_ROUGHNESS 1
#define MATERIAL_SLOT_NORMAL 2
#define MATERIAL_SLOT_EMISSIVE 3

#define SHADING_MODEL_GGX 0u
#define SHADING_MODEL_BLINN_PHONG 1u
#define ALPHA_MODE_TO_COVERAGE 0u
#define ALPHA_MODE_TEST 1u
#define ALPHA_MODE_PER_SAMPLE 2u

// A buffer reached by its address: ADDRESS(Records) records; is a uint64_t on the host, a reference in a shader, which
// needs the block's name before, BUFFER_REFERENCE(Records), and its members anywhere.
#ifdef __cplusplus
#include <cstdint>
#include <glm/glm.hpp>
namespace subpixel::gpu_types {
using glm::mat4;
using glm::uvec2;
using glm::uvec3;
using glm::uvec4;
using glm::vec2;
using glm::vec3;
using glm::vec4;
using uint = std::uint32_t;
}  // namespace subpixel::gpu_types
#define ADDRESS(block) std::uint64_t
#define BUFFER_REFERENCE(block)
#else
#define ADDRESS(block) block
#define BUFFER_REFERENCE(block) layout(buffer_reference) buffer block;
#endif

#endif
