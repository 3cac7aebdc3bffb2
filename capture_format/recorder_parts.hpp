// What both recorders do alike. Private to them.
#pragma once

#include <string>
#include <string_view>

#include "capture_format/capture.hpp"
#include "capture_format/checks.hpp"

namespace subpixel::capture {

// Equal for textures of equal texels, encoding and sampler, whatever their names.
std::string texture_key(const Texture& texture);

// A report that throws UsageError: can't record the `what`. `what` has to outlive it.
Report refuse_to_record(std::string_view what);

// Throws UsageError(what, why) unless it holds.
void require_of_caller(bool holds, const char* what, const char* why);

}  // namespace subpixel::capture
