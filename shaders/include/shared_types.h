// Structures that host and shaders share. Both languages include this file; members are vectors of four 32-bit values
// or matrices of them, so that every buffer layout rule gives the same offsets.
#ifndef SUBPIXEL_SHARED_TYPES_H
#define SUBPIXEL_SHARED_TYPES_H

#ifdef __cplusplus
#include <glm/glm.hpp>
namespace subpixel::gpu_types {
using glm::mat4;
using glm::uvec4;
using glm::vec4;
#endif

// In a uniform buffer; linked_list walks up to 32 surfaces a pixel, so loops stay below the 65,535 turns of Mesa 22.3.
#define SUBPIXEL_MAX_POINT_LIGHTS 1024
// Shadow maps of growing reach around the eye, in the quadrants of one image: 0 1 over 2 3.
#define SUBPIXEL_SHADOW_CASCADES 4

// What a scene needs, as bits of the specialization constant FEATURES and of SceneFeatures. A clear bit removes the
// code.
#define FEATURE_BASE_TEXTURE 1u  // some material has a base colour texture
#define FEATURE_ALPHA_TEST 2u    // some material discards by alpha
#define FEATURE_NORMAL_MAP 4u
#define FEATURE_ROUGHNESS_TEXTURE 8u  // metallic-roughness texture
#define FEATURE_EMISSIVE 16u          // some material emits
#define FEATURE_EMISSIVE_TEXTURE 32u
#define FEATURE_METAL 64u  // some material's metallic factor is not 0
#define FEATURE_TWO_SIDED 128u
#define FEATURE_SUN 256u
#define FEATURE_SHADOWS 512u
#define FEATURE_POINT_LIGHTS 1024u
#define FEATURE_VARYING_ROUGHNESS 2048u  // roughness differs between materials or texels
#define FEATURE_SAMPLERS 4096u           // some texture is read otherwise than trilinearly and repeating
#define FEATURE_SECOND_UV 8192u          // some texture is placed by the second coordinates
#define FEATURE_TEXTURE_TRANSFORM 16384u
#define FEATURE_VERTEX_COLOUR 32768u
#define FEATURE_NORMAL_SCALE 65536u
#define FEATURE_UNLIT 131072u  // some material is: never without FEATURE_EMISSIVE and FEATURE_METAL, which hold it
#define FEATURE_SPOT_LIGHTS 262144u
#define SUBPIXEL_LAST_FEATURE FEATURE_SPOT_LIGHTS

struct PointLightConstants {
  vec4 position_range;  // world units
  vec4 intensity;       // linear radiant intensity
};

// Storage buffer: of a light's cone, the fraction of the way from its outer to its inner cosine is
// dot(plane.xyz, the way the light travels) + plane.w. A light without a cone: 0, 0, 0, 1.
struct SpotConeConstants {
  vec4 plane;
};

// Cells of the view's volume, for which lights are told that may reach them (replay/scene/light_cells.hpp).
#define LIGHT_SLICE_SHIFT 21
struct LightCellConstants {
  vec4 rows[3];  // of a matrix from the world to column, row (both times the depth, a tile wide and high) and depth
  vec4 tiles;    // the last column and row; columns; unused
  uvec4 slices;  // key of the first one: bits of a depth above LIGHT_SLICE_SHIFT; the last one's number; words of a
                 // cell; tiles
};

// The uniform buffer of every pass.
struct FrameConstants {
  mat4 view_projection;          // world to clip: Vulkan conventions, reversed depth
  mat4 inverse_view_projection;  // clip to world
  mat4 view;                     // world to view
  mat4 shadow_matrix;            // world to the sun's view: xy in world units, z depth (0 nearest caster, 1 beyond all)
  vec4 eye;                      // world position
  vec4 sun_direction;            // unit, the way the light travels; w: shadow depth per world unit
  vec4 sun_irradiance;
  vec4 ambient;
  vec4 sky;
  vec4 viewport;                                   // width, height, 1/width, 1/height in pixels
  vec4 tone;                                       // exposure; roughness of all surfaces where it does not vary; unused
  uvec4 counts;                                    // point lights, materials, instances, unused
  uvec4 band;                                      // rows of pixels that passes draw: the first, how many; unused
  vec4 shadow_cascades[SUBPIXEL_SHADOW_CASCADES];  // x scale and yz offset to [0, 1] of the cascade, w texel in world
                                                   // units
  LightCellConstants light_cells;
  PointLightConstants point_lights[SUBPIXEL_MAX_POINT_LIGHTS];
};

// Storage buffer: one for each instance of each draw of the frame, in submission order.
struct InstanceRecord {
  vec4 world_row[3];   // rows of the object-to-world matrix
  vec4 normal_row[3];  // rows of its inverse transpose; .w of row 0: -1 when the transform mirrors
};

#define MATERIAL_BASE_TEXTURE 1u
#define MATERIAL_ALPHA_TEST 2u
#define MATERIAL_NORMAL_MAP 4u
#define MATERIAL_ROUGHNESS_TEXTURE 8u
#define MATERIAL_EMISSIVE_TEXTURE 16u
#define MATERIAL_TWO_SIDED 32u
#define MATERIAL_ALPHA_BLEND 64u
#define MATERIAL_UNLIT 128u
#define MATERIAL_SECOND_UV 256u  // of the base colour's texture; its double, of the second texture; and so on

struct MaterialRecord {
  vec4 base_colour;      // linear, alpha in w
  vec4 emissive_cutoff;  // rgb linear radiance, w alpha cutoff
  vec4 metal_rough;      // x metallic, y roughness, z scale of the normal map
  uvec4 flags;           // x: MATERIAL_ bits; y: the first of four records of where the textures are read
};

// Where a texture is read: u' = dot(row[0].xyz, (u, v, 1)), v' = dot(row[1].xyz, (u, v, 1)).
struct UvMappingRecord {
  vec4 row[2];
};

#ifdef __cplusplus
static_assert(sizeof(PointLightConstants) == 32);
static_assert(sizeof(LightCellConstants) == 80);
static_assert(sizeof(FrameConstants) ==
              4 * 64 + 9 * 16 + 80 + SUBPIXEL_SHADOW_CASCADES * 16 + SUBPIXEL_MAX_POINT_LIGHTS * 32);
static_assert(sizeof(InstanceRecord) == 96);
static_assert(sizeof(MaterialRecord) == 64);
static_assert(sizeof(UvMappingRecord) == 32);
static_assert(sizeof(SpotConeConstants) == 16);
}  // namespace subpixel::gpu_types
#endif
#endif
