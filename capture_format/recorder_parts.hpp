// What both recorders do alike. Private to them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "capture_format/capture.hpp"
#include "capture_format/checks.hpp"

namespace subpixel::capture {

// Equal for textures of equal texels, encoding and sampler, whatever their names.
std::string texture_key(const Texture& texture);

// A report that throws UsageError: can't record the `what`. `what` has to outlive it.
Report refuse_to_record(std::string_view what);

// So that the next push_back() can't throw, at the same cost over many.
template <typename T>
void make_room(std::vector<T>& values) {
  if (values.size() == values.capacity()) values.reserve(std::max<std::size_t>(16, 2 * values.size()));
}

// Throws UsageError(what, why) unless it holds.
void require_of_caller(bool holds, const char* what, const char* why);

}  // namespace subpixel::capture
