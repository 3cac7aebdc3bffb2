// results.json on disk.
#pragma once

#include <filesystem>

#include "replay/results/results.hpp"

namespace subpixel::replay {

// Throws InputError naming the file: not there, too long to be results, broken JSON (line and column), or the field
// that is missing or wrong.
Results read_results(const std::filesystem::path& path);

// Atomic. Throws InputError with the system's reason.
void write_results(const std::filesystem::path& path, const Results& results);

}  // namespace subpixel::replay
