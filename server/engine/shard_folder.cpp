#include "server/engine/shard_folder.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/hash.hpp"
#include "base/json_document.hpp"
#include "base/json_text.hpp"
#include "base/plain_file.hpp"
#include "base/printable.hpp"
#include "server/store/worker_files.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::uint64_t kMaxDocumentBytes = std::uint64_t{8} << 20;  // as a worker's line
constexpr std::size_t kHashDigits = 32;

bool is_hash(std::string_view text) {
  return text.size() == kHashDigits &&
         std::ranges::all_of(text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

std::string hash_of(std::string_view bytes) {
  return content_hash_hex(std::as_bytes(std::span(bytes)));
}

fs::path blob_path(const fs::path& blobs, const std::string& hash) {
  return blobs / hash.substr(0, 2) / hash;
}

// A document under a name with its hash: STEM.HASH.json.
void write_named(const fs::path& folder, const std::string& stem, const json& document) {
  const std::string text = json_text(document);
  write_file_atomically(folder / fmt::format("{}.{}.json", stem, hash_of(text)), std::string_view(text));
}

// The document of a file that write_named() wrote; `stem` is what it is about. Throws InputError.
json read_named(const fs::path& file, std::string& stem) {
  const std::string name = file.filename().string();
  const std::string shown = printable(name, 80);
  const std::size_t dot = name.find('.');
  if (dot == std::string::npos || !name.ends_with(".json") || name.size() != dot + 1 + kHashDigits + 5) {
    throw InputError("shard result", "its file has another name than one has", shown);
  }
  const std::string text = read_plain_file(file, kMaxDocumentBytes, "shard result", shown);
  if (name.substr(dot + 1, kHashDigits) != hash_of(text)) {
    throw InputError("shard result", "its bytes have another hash than its name says", shown);
  }
  stem = name.substr(0, dot);
  return parse_json_document(text, "shard result", "the file " + shown);
}

ShardResult result_from_json(const json& document) {
  const JsonField field(document, "shard result");
  ShardResult read;
  read.ordinal = field.member("ordinal").u32();
  read.result = replay::frame_result_from_json(field.member("result").raw());
  const JsonField images = field.member("images");
  if (images.object().size() > kMaxImages) images.fail("too many images");
  for (const auto& item : images.object().items()) {
    const JsonField each = images.member(item.key());
    ImageName image{each.member("file").text(), each.member("hash").text(), each.member("bytes").u64()};
    const bool plain = !image.file.empty() && image.file.size() < 200 && image.file.front() != '.' &&
                       image.file.find('/') == std::string::npos && image.file.find('\0') == std::string::npos;
    if (!plain) each.fail("the image's name is not a plain file name");
    if (!is_hash(image.hash)) each.fail("no content hash");
    if (image.bytes > kMaxImageBytes) each.fail("the image is too large");
    read.images[item.key()] = std::move(image);
  }
  read.result.images.clear();
  for (const auto& [role, image] : read.images) read.result.images[role] = image.file;
  return read;
}

ShardEnd end_from_json(const json& document) {
  const JsonField field(document, "shard result");
  ShardEnd read;
  if (!field.member("head").raw().is_null()) {
    read.end.head = replay::results_head_from_json(field.member("head").raw());
  }
  read.end.problem = printable(field.member("problem").text(), 1000);
  const std::uint32_t code = field.member("exit").u32();
  for (const ExitCode known : {kUsageExit, kInputExit, kInternalExit}) {
    if (code == static_cast<std::uint32_t>(known)) read.end.exit_code = known;
  }
  read.node = printable(field.member("node").text(), 100);
  read.seconds = field.member("seconds").number();
  return read;
}

// Throws InputError for a result that the shard was not asked for.
void require_wanted(const ShardResult& read, const std::string& stem, const replay::ReplayJob& job,
                    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) {
  const std::pair pair{read.result.frame, read.ordinal};
  const bool wanted = std::ranges::find(pairs, pair) != pairs.end() &&
                      job.options.techniques.at(read.ordinal).technique == read.result.technique &&
                      stem == fmt::format("{}-{}", pair.first, pair.second);
  if (!wanted) throw InputError("shard result", "it is not of this shard", printable(stem, 60));
}

}  // namespace

json to_json(const ShardTask& task) {
  return {{"job", replay::to_json(task.job)},
          {"results", task.results.string()},
          {"blobs", task.blobs.string()},
          {"worker", task.worker.string()},
          {"silence_s", task.silence_s}};
}

ShardTask read_shard_task(const fs::path& file) {
  const std::string text = read_plain_file(file, kMaxDocumentBytes, "shard task", printable(file.string(), 300));
  const json document = parse_json_document(text, "shard task", "the file");
  const JsonField field(document, "shard task");
  ShardTask task;
  task.job = replay::replay_job_from_json(field.member("job").raw());
  task.results = field.member("results").text();
  task.blobs = field.member("blobs").text();
  task.worker = field.member("worker").text();
  task.silence_s = std::min<std::uint64_t>(field.member("silence_s").u64(), 1'000'000);
  return task;
}

ImageName write_blob(const fs::path& blobs, const std::string& file, const Blob& blob) {
  ImageName name{file, hash_of(blob.bytes), blob.bytes.size()};
  const fs::path path = blob_path(blobs, name.hash);
  std::error_code none_yet;
  // Whoever reads it compares the hash; what is damaged is deleted then and written again.
  if (fs::file_size(path, none_yet) == name.bytes && !none_yet) return name;
  write_file_atomically(path, std::string_view(blob.bytes));
  return name;
}

Blob read_blob(const fs::path& blobs, const ImageName& name) {
  const fs::path path = blob_path(blobs, name.hash);
  Blob blob{media_type_of(name.file), read_plain_file(path, kMaxImageBytes, "shard result: an image", name.hash)};
  if (blob.bytes.size() != name.bytes || hash_of(blob.bytes) != name.hash) {
    std::error_code ignored;
    fs::remove(path, ignored);
    throw InputError("shard result", "an image's bytes have another hash than its name says", name.hash);
  }
  return blob;
}

void write_result(const fs::path& results, const ShardResult& result) {
  json images = json::object();
  for (const auto& [role, image] : result.images) {
    images[role] = {{"file", image.file}, {"hash", image.hash}, {"bytes", image.bytes}};
  }
  write_named(results, fmt::format("{}-{}", result.result.frame, result.ordinal),
              {{"ordinal", result.ordinal}, {"result", replay::to_json(result.result)}, {"images", images}});
}

void write_end(const fs::path& results, const ShardEnd& end) {
  json head = nullptr;
  if (end.end.head) head = replay::to_json(*end.end.head);
  write_named(results, "end",
              {{"head", head},
               {"problem", end.end.problem},
               {"exit", end.end.exit_code},
               {"node", end.node},
               {"seconds", end.seconds}});
}

ShardOutcome read_outcome(const fs::path& results, const replay::ReplayJob& job,
                          const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) {
  ShardOutcome outcome;
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(results, error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    // A file in the making begins with a dot.
    if (!entry->path().filename().string().starts_with(".")) files.push_back(entry->path());
  }
  std::ranges::sort(files);  // of several attempts the same one counts every time
  for (const fs::path& file : files) {
    try {
      std::string stem;
      const json document = read_named(file, stem);
      if (stem == "end") {
        ShardEnd end = end_from_json(document);
        if (!outcome.end || outcome.end->end.problem.empty() < end.end.problem.empty()) outcome.end = std::move(end);
        continue;
      }
      ShardResult read = result_from_json(document);
      require_wanted(read, stem, job, pairs);
      outcome.results.try_emplace({read.result.frame, read.ordinal}, std::move(read));
    } catch (const Error& refusal) {
      outcome.refused.push_back(printable(refusal.what(), 300));
      std::error_code ignored;
      fs::remove(file, ignored);
    } catch (const json::exception& refusal) {
      outcome.refused.push_back(printable(refusal.what(), 300));
      std::error_code ignored;
      fs::remove(file, ignored);
    }
  }
  return outcome;
}

}  // namespace subpixel::server
