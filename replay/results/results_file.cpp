#include "replay/results/results_file.hpp"

#include <cerrno>
#include <fstream>
#include <sstream>
#include <system_error>

#include "base/atomic_file.hpp"
#include "base/error.hpp"

namespace subpixel::replay {
namespace {

// A night of 1000 captures x 20 techniques is some 40 MB; far more is some other file.
constexpr std::uintmax_t max_results_bytes = std::uintmax_t{1} << 30;

std::string read_text(const std::filesystem::path& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) throw InputError("results", error.message(), path.string());
  if (size > max_results_bytes) throw InputError("results", "longer than 1 GiB", path.string());
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (!file) throw InputError("results", std::generic_category().message(errno), path.string());
  text << file.rdbuf();
  if (file.bad()) throw InputError("results", "cannot be read", path.string());
  return text.str();
}

// The library's message without its own name in front: "parse error at line 3, column 7: ...".
std::string parser_words(const nlohmann::json::exception& error) {
  const std::string words = error.what();
  const std::size_t end = words.find("] ");
  return end == std::string::npos ? words : words.substr(end + 2);
}

}  // namespace

Results read_results(const std::filesystem::path& path) {
  nlohmann::json document;
  try {
    document = nlohmann::json::parse(read_text(path));
  } catch (const nlohmann::json::exception& error) {
    throw InputError("results", parser_words(error), path.string());
  }
  try {
    return results_from_json(document);
  } catch (const InputError& error) {
    throw InputError(path.string(), error.what(), "");
  }
}

void write_results(const std::filesystem::path& path, const Results& results) {
  write_file_atomically(
      path, std::string_view(to_json(results).dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n"));
}

}  // namespace subpixel::replay
