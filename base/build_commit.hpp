// The commit that this program was built from.
#pragma once

#include <string_view>

namespace subpixel {

// 40 hexadecimal digits, "-changed" after them when the sources had uncommitted changes; empty when the sources were
// not in a git repository.
std::string_view build_commit();

}  // namespace subpixel
