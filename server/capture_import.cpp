#include "server/capture_import.hpp"

#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "base/failure.hpp"
#include "base/json_document.hpp"
#include "base/printable.hpp"
#include "base/python_interpreter.hpp"
#include "server/http_error.hpp"

namespace subpixel::server {
namespace {

constexpr const char* kWhat = "the file can't be imported";
constexpr std::chrono::minutes kLongest{5};
constexpr std::chrono::minutes kLongestFrame{60};  // RenderDoc replays the frame up to each draw that is asked about
constexpr std::uint64_t kMostMemory = std::uint64_t{8} << 30;
constexpr std::size_t kMaxStemBytes = 60;

// A file name of plain letters, whatever the user's is: it becomes a path, a title and a part of messages.
std::string plain_stem(const std::string& name) {
  std::string stem = std::filesystem::path(name).stem().string();
  stem.resize(std::min(stem.size(), kMaxStemBytes));
  for (char& c : stem) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
    if (!is_plain) c = '_';
  }
  return stem.empty() ? "unnamed" : stem;
}

std::string without(std::string text, const std::string& part) {
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos;) text.erase(at, part.size());
  return text;
}

}  // namespace

std::optional<std::string> imported_kind(const std::filesystem::path& upload) {
  std::array<char, 4> first{};
  std::ifstream(upload, std::ios::binary).read(first.data(), first.size());
  const std::string_view magic(first.data(), first.size());
  if (magic == "glTF") return ".glb";
  if (magic == "RDOC") return ".rdc";
  // A zip archive begins with a member, an empty one with its end.
  if (magic == "PK\x03\x04" || magic == "PK\x05\x06") return ".zip";
  return std::nullopt;
}

CaptureImport::CaptureImport(const DataFolder& folder, const std::filesystem::path& upload, const std::string& kind,
                             const std::string& name, const WorkerOptions& worker, std::uint64_t largest_bytes,
                             std::stop_token stop) {
  std::string made = (folder.uploads() / "import-XXXXXX").string();
  if (::mkdtemp(made.data()) == nullptr) throw HttpError(500, kWhat, std::strerror(errno), "data folder");
  folder_ = made;
  try {
    const std::filesystem::path model = folder_ / "in" / (plain_stem(name) + kind);
    std::filesystem::create_directory(folder_ / "in");
    std::filesystem::create_directory(folder_ / "out");
    std::filesystem::create_hard_link(upload, model);
    run(model, kind, worker, largest_bytes, std::move(stop));
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
    throw;
  }
}

CaptureImport::~CaptureImport() {
  std::error_code ignored;  // what stays is removed at the next start
  std::filesystem::remove_all(folder_, ignored);
}

void CaptureImport::run(const std::filesystem::path& model, const std::string& kind, const WorkerOptions& worker,
                        std::uint64_t largest_bytes, std::stop_token stop) const {
  const bool is_frame = kind == ".rdc";
  ChildLimits limits = worker.limits;
  limits.duration = std::min<std::chrono::milliseconds>(limits.duration, is_frame ? kLongestFrame : kLongest);
  limits.silence = limits.duration;
  limits.processor_s = static_cast<std::uint64_t>(limits.duration / std::chrono::seconds(1)) + 1;
  if (limits.address_space_bytes != 0) limits.address_space_bytes = std::min(limits.address_space_bytes, kMostMemory);
  limits.file_bytes = largest_bytes;
  limits.confinement = confined(worker, {model.parent_path()}, {folder_ / "out"});
  if (is_frame) limits.confinement->interpreter = python_interpreter();
  limits.environment.push_back("TMPDIR=" + (folder_ / "out").string());

  std::string error;
  bool done = false;
  const auto take = [&](std::string_view line) {
    const std::optional<nlohmann::json> message = parse_json_line(line);
    if (!message) return true;  // some library's own word
    const std::string type = text_or_empty(*message, "type");
    if (type == "error") error = text_or_empty(*message, "text");
    if (type == "done") done = true;
    return true;
  };
  const ChildOutcome outcome = run_child(
      {worker.program.string(), "import-worker", "--", model.string(), file().string()}, limits, std::move(stop), take);
  if (outcome.kind == ChildOutcome::Kind::stopped) throw HttpError(503, kWhat, "the service is ending", "");
  if (outcome.kind == ChildOutcome::Kind::exited && outcome.code == 0 && done) return;
  const int status = outcome.kind == ChildOutcome::Kind::exited && outcome.code == kInternalExit ? 500 : 422;
  // Paths of this machine mean nothing to who sent the file.
  const std::string where = model.filename().string();
  if (error.empty()) {
    throw HttpError(status, kWhat, outcome.reason.empty() ? "the reader did not say that it was done" : outcome.reason,
                    where);
  }
  throw HttpError(status, kWhat, printable(without(error, model.parent_path().string() + "/"), 1000), where);
}

}  // namespace subpixel::server
