// The schema's steps, embedded by the build: schema.sql and migrations/*.sql in order.
#pragma once

#include <span>

#include "base/embedded_file.hpp"

namespace subpixel::server {

std::span<const EmbeddedFile> schema_steps();

}  // namespace subpixel::server
