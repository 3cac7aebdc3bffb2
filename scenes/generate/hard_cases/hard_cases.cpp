#include "scenes/generate/hard_cases/hard_cases.hpp"

#include <array>

#include "scenes/generate/scenes.hpp"

namespace subpixel::capture {
namespace {

constexpr std::array kCases{
    HardCase{"hard_slivers", "triangles a million times as long as wide, in every direction",
             "lines of a tenth of a pixel at most; what is narrower than a snapping step covers nothing", hard_slivers},
    HardCase{"hard_subpixel", "60 triangles in each pixel, at all depths, in six materials",
             "the reference within the sampling error; list techniques overflow and count it", hard_subpixel, 32, 24},
    HardCase{"hard_shared_edges", "a fan around one point and a closed mesh, both white, before black",
             "inside exactly 1, outside exactly 0: each sample is covered once", hard_shared_edges},
    HardCase{"hard_t_junctions", "corners in the middle of neighbours' edges, a white sky behind a grey wall",
             "0.25 inside the wall but for single samples along the junctions, the same ones in every technique",
             hard_t_junctions},
    HardCase{"hard_fullscreen", "one triangle over the whole frame", "every pixel exactly (0.5, 0.25, 1)",
             hard_fullscreen},
    HardCase{"hard_near_plane", "triangles through the near plane and behind the eye",
             "the reference: what is cut keeps its edges, what is behind does not come back", hard_near_plane},
    HardCase{"hard_grazing", "walls seen edge-on, up to 1e12 units of depth in a pixel: no half float holds the slope",
             "the reference; no NaN from an infinite derivative", hard_grazing},
    HardCase{"hard_coplanar", "a rectangle drawn twice, and one over another that is cut differently",
             "left all red: of equal depths the first drawn stays; right red or green by rounding", hard_coplanar},
    HardCase{"hard_interpenetrating", "planes through one axis and one across",
             "the reference: visibility changes inside pixels and triangles", hard_interpenetrating},
    HardCase{"hard_depth_range", "near plane 0.01, far plane 1e5, pairs of sheets 0.1% of their distance apart",
             "blue rectangles inside red ones, no stripes, at all four distances", hard_depth_range},
    HardCase{"hard_bad_vertices", "a sphere, and triangles with corners that are NaN or infinite, or without area",
             "the sphere alone: a triangle with a bad corner is not drawn", hard_bad_vertices},
    HardCase{"hard_far_origin", "a cube and bars a million units from the origin",
             "the same coverage as at the origin; positions used for lighting are rounded to 1/16 unit",
             hard_far_origin},
    HardCase{"hard_opposite_normals", "quarter-pixel strips whose normals are opposite",
             "half of what a lit strip sends; a merged normal of length 0 is not a NaN", hard_opposite_normals},
    HardCase{"hard_roughness", "spheres of roughness 0 and 1, dielectric and metal",
             "finite highlights of finite size: roughness has a floor", hard_roughness},
    HardCase{"hard_overflow", "about ten thin bars in each pixel, in eight materials",
             "pools and lists overflow, are counted, and nothing is written out of bounds", hard_overflow, 48, 36},
    HardCase{"hard_alpha_foliage", "alpha-tested leaf cards at all angles", "the reference at the leaves' edges",
             hard_alpha_foliage},
    HardCase{"hard_bright_light", "a light of 1e6, bars that reflect nothing",
             "nothing of the wall's light in what is black beside it; no value above the ceiling of 60000",
             hard_bright_light},
    HardCase{"hard_emissive_only", "no light but six emitters, 1e-4 to 1e4", "each emitter's own radiance",
             hard_emissive_only},
    HardCase{"hard_many_lights", "300 point lights", "the light of all 300", hard_many_lights, 48, 36},
    HardCase{"hard_shadow_albedo", "Crassin et al. 2016, fig. 17 a: white stripes in shadow, black ones lit",
             "dark above, grey below; mean albedo times mean light is too bright above", hard_shadow_albedo},
    HardCase{"hard_hairs", "Crassin et al. 2016, fig. 17 b: hairs of 0.3 pixels with highlights",
             "the reference; isotropic distributions of normals widen the highlights", hard_hairs},
    HardCase{"hard_railings", "Crassin et al. 2016, fig. 17 c: square bars of a third of a pixel",
             "the reference; a distribution of two or three lobes is no single lobe", hard_railings},
    HardCase{"hard_blurred_texture", "Wang et al. 2015, fig. 10 a: a fine mesh with a texture of pixel size",
             "the reference; shading once a surface blurs the texture or aliases it", hard_blurred_texture},
    HardCase{"hard_small_angle", "Wang et al. 2015, fig. 10 b: walls meeting at 170 degrees under a grazing sun",
             "bright and dark faces with sharp borders; averaged normals smooth them", hard_small_angle},
    HardCase{"hard_window_frame", "Wang et al. 2015, fig. 10 c: frames of a quarter pixel before a white wall",
             "the frames stay as grey lines; a discard shows the wall instead", hard_window_frame},
    HardCase{"streaming_normals", "steep pleats: what merging without the condition on normals gets wrong",
             "the reference with all conditions on", streaming_normals},
    HardCase{"streaming_depth", "slats before a finely meshed wall: the same for depths",
             "the reference with all conditions on", streaming_depth},
    HardCase{"streaming_coverage", "mats on a floor at a grazing angle: the same for coverage",
             "the reference with all conditions on", streaming_coverage},
    HardCase{"streaming_angle", "Kerzner and Salvi 2014, fig. 8: light strips beside dark ones at 30 degrees",
             "sharp borders; a merge that all conditions allow greys them", streaming_angle},
    HardCase{"empty", "frames without a draw call", "the sky exactly, nothing lit", empty},
};

}  // namespace

std::span<const HardCase> hard_cases() {
  return kCases;
}

Capture make_case(const HardCase& hard) {
  return hard.make({.frames = 1, .width = hard.width, .height = hard.height});
}

}  // namespace subpixel::capture
