// Changes of a JSON document as a document, for fuzzers and their short forms in the tests.
#pragma once

#include <cstddef>
#include <random>
#include <span>
#include <string>
#include <string_view>

namespace subpixel {

// `text` with one to three of its values changed, removed, doubled or put in another's place; `words` are texts that a
// value may become. Empty when it is no JSON.
std::string mutated_json(std::string_view text, std::span<const std::string_view> words, std::minstd_rand& random);

}  // namespace subpixel
