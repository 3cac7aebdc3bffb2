// Lights and camera of an assimp scene in our form. Private to the loader by assimp.
#pragma once

#include "scenes/import/model.hpp"

struct aiScene;

namespace subpixel::capture {

// Adds point and spot lights, and the last directional one as the sun. Older formats' lights have a brightness without
// a unit, in which 1 makes a white surface white, and a fall-off of their own: they shine as they should at the
// distance of the model's middle, whose bounds must be set. Others are named in model.notices.
void add_assimp_lights(const aiScene& scene, Model& model);

// The first camera, if there is one.
void add_assimp_camera(const aiScene& scene, Model& model);

}  // namespace subpixel::capture
