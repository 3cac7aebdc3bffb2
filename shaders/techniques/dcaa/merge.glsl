// Decoupled coverage anti-aliasing of one pixel: what one more fragment does to its surfaces.
// Wang, Wyman, He and Sen 2015, algorithm 1, sections 3.2 and 3.3.
// Reads and writes: its arguments alone, so that a test can feed it a stream of its own.
//
// Where the paper leaves a choice: the best candidate of the first attempt has the largest sum of how far its normal is
// within the limit and how much of the shorter depth interval the two share, both from 0 to 1; that of the second attempt the
// largest share alone; of equal candidates the earlier slot. Of equal depths the earlier slot is in front, the fragment
// last; of equal coverages the farthest has to go.
#ifndef SUBPIXEL_DCAA_MERGE_GLSL
#define SUBPIXEL_DCAA_MERGE_GLSL

#include "include/blending.glsl"
#include "include/ordered_state_words.glsl"
#include "techniques/dcaa/surface.glsl"

// Averages weighted by coverage; coverage by OR (section 3.2). The normals are those of the facets.
DcaaSurface dcaa_merged(DcaaSurface a, vec3 normal_a, DcaaSurface b, vec3 normal_b) {
  uvec2 weighing_a = a.coverage, weighing_b = b.coverage;
  if (dcaa_option(DCAA_WEIGHT_SHOWN)) {
    weighing_a &= b.depth > a.depth ? ~b.coverage : uvec2(0xffffffffu);
    weighing_b &= b.depth > a.depth ? uvec2(0xffffffffu) : ~a.coverage;
  }
  BlendWeights weights = weights_by_samples(dcaa_count(weighing_a), dcaa_count(weighing_b));
  DcaaSurface merged;
  merged.coverage = a.coverage | b.coverage;
  merged.facet = dcaa_pack_facet(blend(normal_a, normal_b, weights));
  merged.depth = dcaa_rounded_depth(blend(a.depth, b.depth, weights));
  merged.albedo = blend_albedo(a.albedo, b.albedo, weights);
  merged.normal = dcaa_pack_shading(blend(dcaa_shading(a.normal), dcaa_shading(b.normal), weights));
  merged.roughness =
      has_feature(FEATURE_VARYING_ROUGHNESS) ? blend_byte(a.roughness, b.roughness, 0u, weights) : a.roughness;
  merged.moments = uvec3(0u);
  if (dcaa_option(DCAA_SECOND_MOMENTS))
    for (uint c = 0u; c < 3u; ++c) merged.moments[c] = blend_halves(a.moments[c], b.moments[c], weights);
  merged.emission = blend_emission(a.emission, b.emission, weights);
  return merged;
}

DcaaSurface dcaa_select(bool condition, DcaaSurface yes, DcaaSurface no) {
  DcaaSurface s;
  s.coverage = condition ? yes.coverage : no.coverage;
  s.facet = condition ? yes.facet : no.facet;
  s.depth = condition ? yes.depth : no.depth;
  s.albedo = condition ? yes.albedo : no.albedo;
  s.normal = condition ? yes.normal : no.normal;
  s.roughness = condition ? yes.roughness : no.roughness;
  s.emission = condition ? yes.emission : no.emission;
  s.moments = condition ? yes.moments : no.moments;
  return s;
}

// How much of the shorter interval the two share, 0 to 1; below 0 when they don't overlap.
float dcaa_shared_depth(vec2 a, vec2 b) {
  precise float shared_part = min(a.y, b.y) - max(a.x, b.x);
  precise float shorter = min(a.y - a.x, b.y - b.x);
  return shared_part < 0.0 ? -1.0 : min(shared_part / max(shorter, 1e-30), 1.0);
}

DcaaPlane dcaa_select(bool condition, DcaaPlane yes, DcaaPlane no) {
  return DcaaPlane(condition ? yes.normal : no.normal, condition ? yes.slopes : no.slopes);
}

// Section 3.3, with the list full: which entry has to go, which samples it shows, which entry it joins. Entry SURFACES is the
// fragment, the one after it none.
void dcaa_find_room(DcaaSurface surface[DCAA_MAX_SURFACES], DcaaPlane plane[DCAA_MAX_SURFACES], DcaaSurface fragment,
                    DcaaPlane own, vec3 ray, DcaaView view, out uint leaving, out uint partner, out uvec2 shows) {
  uvec2 coverage[DCAA_MAX_SURFACES + 1];
  float depth[DCAA_MAX_SURFACES + 1];
  for (uint i = 0u; i < SURFACES; ++i) {
    coverage[i] = surface[i].coverage;
    depth[i] = surface[i].depth;
  }
  coverage[SURFACES] = fragment.coverage;
  depth[SURFACES] = fragment.depth;

  // The coarse resolve: what each covers that none in front of its centre does.
  leaving = 0u;
  partner = SURFACES + 1u;
  shows = uvec2(0u);
  uint least = 0xffffffffu, leaving_rank = 0u;
#define COARSE(i)                                                                          \
  {                                                                                        \
    uvec2 hidden = uvec2(0u);                                                              \
    uint rank = 0u;                                                                        \
    for (uint j = 0u; j <= SURFACES; ++j) {                                                \
      bool in_front = depth[j] > depth[i] || (depth[j] == depth[i] && j < i);              \
      hidden |= in_front ? coverage[j] : uvec2(0u);                                        \
      rank += in_front ? 1u : 0u;                                                          \
    }                                                                                      \
    uint shown = dcaa_count(coverage[i] & ~hidden);                                        \
    bool may_go = rank > 0u || !dcaa_option(DCAA_KEEP_FRONT);                              \
    bool better = may_go && (shown < least || (shown == least && rank > leaving_rank));    \
    least = better ? shown : least;                                                        \
    leaving = better ? i : leaving;                                                        \
    leaving_rank = better ? rank : leaving_rank;                                           \
    shows = better ? coverage[i] & ~hidden : shows;                                        \
  }
  EACH_SURFACE(COARSE)
  COARSE(SURFACES)
#undef COARSE

  // The second merge: of the paper, with the surface that shares most of its depth interval, all of it; of DCAA_NEAREST, with
  // the nearest, which keeps its plane, as much of it as shows.
  const bool kNearest = dcaa_option(DCAA_NEAREST);
  for (bool joins = kNearest ? least > 0u : dcaa_option(DCAA_SECOND_MERGE); joins; joins = false) {
    DcaaPlane gone = own;
    float gone_depth = fragment.depth;
    for (uint i = 0u; i < SURFACES; ++i) {
      gone = dcaa_select(leaving == i, plane[i], gone);
      gone_depth = leaving == i ? depth[i] : gone_depth;
    }
    vec2 interval = dcaa_interval(gone, gone_depth);
    float place = kNearest ? dcaa_place(gone_depth, ray, view) : 0.0;
    float best = kNearest ? -1e30 : -1.0;
#define CONSIDER(i, its)                                                                                      \
  {                                                                                                           \
    float score = kNearest ? -dcaa_distance(dcaa_place(depth[i], ray, view), its.normal, place, gone.normal)  \
                           : dcaa_shared_depth(dcaa_interval(its, depth[i]), interval);                       \
    bool better = i != leaving && score > best;                                                               \
    best = better ? score : best;                                                                             \
    partner = better ? i : partner;                                                                           \
  }
#define CONSIDER_SURFACE(i) CONSIDER(i, plane[i])
    EACH_SURFACE(CONSIDER_SURFACE)
    CONSIDER(SURFACES, own)
#undef CONSIDER_SURFACE
#undef CONSIDER
  }
}

// The samples of a fragment that no surface in front of it over the whole pixel covers.
uvec2 dcaa_not_hidden(uint count, DcaaSurface surface[DCAA_MAX_SURFACES], DcaaPlane plane[DCAA_MAX_SURFACES],
                      DcaaSurface fragment, DcaaPlane own) {
  uvec2 left = fragment.coverage;
#define HIDE(i)                                                                                                   \
  for (bool go = i < count && surface[i].depth > fragment.depth; go; go = false) {                                \
    vec2 turn = abs(plane[i].slopes - own.slopes);                                                                \
    precise float ahead = surface[i].depth - fragment.depth;                                                      \
    precise float reach = 0.5 * (turn.x + turn.y);                                                                \
    left &= ahead > reach ? ~surface[i].coverage : uvec2(0xffffffffu);                                            \
  }
  EACH_SURFACE(HIDE)
#undef HIDE
  return left;
}

// Adds a fragment, which brings at least one sample, to the pixel. It merges with a surface, or takes a slot; where none is
// free something leaves, which may join another. One merge at most, so that code for one serves both kinds.
void dcaa_add_shown(inout uint word, inout DcaaSurface surface[DCAA_MAX_SURFACES], inout DcaaPlane plane[DCAA_MAX_SURFACES],
                    DcaaSurface fragment, DcaaPlane own, vec3 ray, DcaaView view) {
  const uint kNone = SURFACES + 1u;
  const bool kNearest = dcaa_option(DCAA_NEAREST);
  uint count = field_of(word, 0u, DCAA_COUNT_BITS);
  uint target = kNone;
  // Loops, here and below, are skipped when no lane needs them.
  for (bool any_surface = count > 0u; any_surface; any_surface = false) {
    vec3 normal = own.normal;
    vec2 interval = dcaa_interval(own, fragment.depth);
    precise float per_cosine = 1.0 / max(1.0 - COS_NORMAL_ANGLE, 1e-6);
    float best = -1.0;
#define CONSIDER(i)                                                                                           \
  for (bool go = i < count; go; go = false) {                                                                  \
    vec3 other = plane[i].normal;                                                                              \
    precise float cosine = normal.x * other.x + normal.y * other.y + normal.z * other.z;                       \
    float share = dcaa_shared_depth(dcaa_interval(plane[i], surface[i].depth), interval);                      \
    precise float score = (cosine - COS_NORMAL_ANGLE) * per_cosine + share;                                    \
    bool better = cosine > COS_NORMAL_ANGLE && share >= 0.0 && score > best;                                   \
    best = better ? score : best;                                                                              \
    target = better ? i : target;                                                                              \
  }
    EACH_SURFACE(CONSIDER)
#undef CONSIDER
  }
  bool merges = target < kNone, full = !merges && count == SURFACES;
  uint leaving = merges ? kNone : count, partner = kNone;
  uvec2 shows = uvec2(0u);
  for (bool go = full; go; go = false)
    dcaa_find_room(surface, plane, fragment, own, ray, view, leaving, partner, shows);
  bool joins = partner < kNone;

  uint into = merges ? target : partner;
  DcaaSurface merged = fragment;
  DcaaPlane joint = own;
  for (bool go = merges || joins; go; go = false) {
    DcaaSurface part = fragment;
    DcaaPlane part_plane = own;
    for (uint i = 0u; i < SURFACES; ++i) {
      bool leaves = joins && leaving == i;
      merged = dcaa_select(into == i, surface[i], merged);
      joint = dcaa_select(into == i, plane[i], joint);
      part = dcaa_select(leaves, surface[i], part);
      part_plane.normal = leaves ? plane[i].normal : part_plane.normal;
    }
    bool stays = kNearest && joins;
    uvec3 facet = merged.facet;
    float depth = merged.depth;
    part.coverage = stays ? shows : part.coverage;
    merged = dcaa_merged(merged, joint.normal, part, part_plane.normal);
    merged.facet = stays ? facet : merged.facet;
    merged.depth = stays ? depth : merged.depth;
    for (bool moves = !stays; moves; moves = false) joint = dcaa_plane(merged, ray, view);
  }
  bool takes_merged = into == SURFACES, vanishes = kNearest && shows == uvec2(0u);
  DcaaSurface entering = dcaa_select(takes_merged, merged, fragment);
  DcaaPlane entering_plane = dcaa_select(takes_merged, joint, own);
  for (uint i = 0u; i < SURFACES; ++i) {
    surface[i] = dcaa_select(leaving == i, entering, dcaa_select(into == i, merged, surface[i]));
    plane[i] = dcaa_select(leaving == i, entering_plane, dcaa_select(into == i, joint, plane[i]));
  }
  word = count_more(word, DCAA_FIRST_SHIFT, DCAA_FIRST_BITS, merges ? 1u : 0u);
  word = count_more(word, DCAA_SECOND_SHIFT, DCAA_SECOND_BITS, joins ? 1u : 0u);
  word = count_more(word, DCAA_DISCARD_SHIFT, DCAA_DISCARD_BITS, full && !joins && !vanishes ? 1u : 0u);
  word += !merges && !full ? 1u : 0u;
}

// Adds a fragment, which covers at least one sample, to the pixel. `plane`: of each surface, dcaa_plane().
void dcaa_add(inout uint word, inout DcaaSurface surface[DCAA_MAX_SURFACES], inout DcaaPlane plane[DCAA_MAX_SURFACES],
              DcaaSurface fragment, vec3 ray, DcaaView view) {
  DcaaPlane own = dcaa_plane(fragment, ray, view);
  if (dcaa_option(DCAA_SHOWN_PART))
    fragment.coverage = dcaa_not_hidden(field_of(word, 0u, DCAA_COUNT_BITS), surface, plane, fragment, own);
  for (bool shows = fragment.coverage != uvec2(0u); shows; shows = false)
    dcaa_add_shown(word, surface, plane, fragment, own, ray, view);
}

// The same where planes are not kept.
uvec2 dcaa_not_hidden(uint count, DcaaSurface surface[DCAA_MAX_SURFACES], DcaaSurface fragment, vec3 ray, DcaaView view) {
  DcaaPlane plane[DCAA_MAX_SURFACES];
  for (uint i = 0u; i < SURFACES; ++i) plane[i] = dcaa_plane(surface[i], ray, view);
  return dcaa_not_hidden(count, surface, plane, fragment, dcaa_plane(fragment, ray, view));
}
void dcaa_add(inout uint word, inout DcaaSurface surface[DCAA_MAX_SURFACES], DcaaSurface fragment, vec3 ray, DcaaView view) {
  DcaaPlane plane[DCAA_MAX_SURFACES];
  for (uint i = 0u; i < SURFACES; ++i) plane[i] = dcaa_plane(surface[i], ray, view);
  dcaa_add(word, surface, plane, fragment, ray, view);
}

#endif
