// JSON Schema of what the API takes and answers, embedded by the build: api_schemas.json.
#pragma once

#include <span>

#include "base/embedded_file.hpp"

namespace subpixel::server {

std::span<const EmbeddedFile> api_schemas();

}  // namespace subpixel::server
