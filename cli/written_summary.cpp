#include "cli/written_summary.hpp"

#include <fmt/format.h>

#include "base/hash.hpp"
#include "capture_format/reading/summary.hpp"

namespace subpixel::cli {

std::string written_summary(const capture::Capture& made, const std::filesystem::path& path) {
  // A device or a pipe can't be read again.
  const bool is_file = std::filesystem::is_regular_file(path);
  const nlohmann::json summary =
      capture::summarize(made, is_file ? content_hash_hex(path) : "", is_file ? std::filesystem::file_size(path) : 0);
  std::string counts = fmt::format("{} frames, {} draws, {} triangles", summary["frame_count"].get<std::uint64_t>(),
                                   summary["draws"].get<std::uint64_t>(), summary["triangles"].get<std::uint64_t>());
  if (!is_file) return counts;
  return fmt::format("{}, {:.1f} MB, hash {}", counts, summary["file_bytes"].get<double>() * 1e-6,
                     summary["hash"].get<std::string>());
}

}  // namespace subpixel::cli
