// The applications' shaders as glslang writes them.
#pragma once

#include <cstdint>

#include "vulkan_shaders/scene.frag.h"
#include "vulkan_shaders/scene.vert.h"
#include "vulkan_shaders/screen.frag.h"
#include "vulkan_shaders/screen.vert.h"
