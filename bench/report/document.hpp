// docs/results.md from stored runs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/report/claims.hpp"
#include "bench/report/measured.hpp"

namespace subpixel::report {

// Beside the page: the files it was written from (publish()).
inline constexpr const char* kMeasuredFolder = "measured";

struct Document {
  std::string markdown;
  std::vector<std::pair<std::string, std::string>> images;  // path from the page's folder, SVG
};

// `command` is what regenerates the page; it stands at its top, as does what it makes and is not stored: `missing`
// runs.
Document make_document(const Measured& measured, const std::vector<Claim>& claims, const std::string& command,
                       const std::vector<std::string>& missing = {});

// The page at `file` and its images beside it, each whole or not at all. Images of an earlier page are removed.
void write_document(const Document& document, const std::filesystem::path& file);

}  // namespace subpixel::report
