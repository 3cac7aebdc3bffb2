#include "server/watch_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>

#include "base/error.hpp"
#include "base/printable.hpp"
#include "server/capture_inspection.hpp"
#include "server/http_error.hpp"
#include "server/upload.hpp"

namespace subpixel::server {
namespace {

namespace fs = std::filesystem;

struct Found {
  fs::file_time_type written;
  fs::path path;
};

std::vector<Found> quiet_captures(const WatchedFolder& watched) {
  std::vector<Found> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(watched.folder, error)) {
    // A link may lead anywhere.
    if (entry.path().extension() != ".spcap" || entry.is_symlink(error) || !entry.is_regular_file(error)) continue;
    const fs::file_time_type written = entry.last_write_time(error);
    if (error || fs::file_time_type::clock::now() - written < std::chrono::seconds(watched.quiet_s)) continue;
    found.push_back({written, entry.path()});
  }
  if (error) throw InputError("watched folder", error.message(), watched.folder.string());
  std::ranges::sort(found, {}, [](const Found& one) { return std::pair(one.written, one.path); });
  return found;
}

void add_tag(Store& store, const std::string& hash, const std::string& tag) {
  std::vector<std::string> tags = store.capture(hash).value().tags;
  if (std::ranges::find(tags, tag) != tags.end()) return;
  tags.push_back(tag);
  store.set_tags(hash, tags);
}

}  // namespace

std::vector<std::string> take_captures(const WatchedFolder& watched, const DataFolder& folder, Store& store,
                                       const WorkerOptions& worker) {
  std::vector<std::string> lines;
  fs::create_directories(folder.uploads());  // no service may have been here
  for (const Found& found : quiet_captures(watched)) {
    const std::string name = printable(found.path.filename().string(), 200);
    try {
      // Copied first: what is checked is what is kept, whatever happens to the file meanwhile.
      Upload copy(folder);
      std::ifstream in(found.path, std::ios::binary);
      std::vector<char> block(std::size_t{1} << 20);
      while (in) {
        in.read(block.data(), static_cast<std::streamsize>(block.size()));
        copy.append({block.data(), static_cast<std::size_t>(in.gcount())});
      }
      if (!in.eof()) throw InputError("watched capture", "it can't be read", found.path.string());
      const std::string hash = copy.finish();
      if (!store.capture(hash)) {
        CaptureRecord capture = inspect_capture(copy.path(), worker, {});
        if (keep_capture(folder, copy.path(), hash) == Kept::collision)
          throw InputError("watched capture", "another one has its content hash", hash);
        capture.hash = hash;
        capture.name = name;
        capture.size_bytes = copy.size_bytes();
        capture.uploaded_utc = utc_now();
        store.add_capture(capture);
        lines.push_back(fmt::format("{}: taken as {} with the tag {}", name, hash.substr(0, 8), watched.tag));
      }
      add_tag(store, hash, watched.tag);
    } catch (const HttpError& error) {
      lines.push_back(fmt::format("{}: not taken: {}", name, error.what()));
    } catch (const Error& error) {
      lines.push_back(fmt::format("{}: not taken: {}", name, error.what()));
    }
  }
  return lines;
}

std::vector<std::string> keep_tag_limits(const TagLimit& limit, const DataFolder& folder, Store& store) {
  std::vector<CaptureRecord> tagged = store.captures_with_tag(limit.tag);
  std::ranges::sort(tagged, std::ranges::greater(), &CaptureRecord::uploaded_utc);
  std::vector<std::string> lines;
  std::uint64_t bytes = 0;
  std::size_t kept = 0;
  for (const CaptureRecord& capture : tagged) {
    const bool many = limit.keep > 0 && kept >= limit.keep;
    // The newest stays, however large it is.
    const bool large = limit.bytes > 0 && kept > 0 && bytes + capture.size_bytes > limit.bytes;
    if (!many && !large) {
      bytes += capture.size_bytes;
      ++kept;
      continue;
    }
    std::vector<std::string> tags = capture.tags;
    std::erase(tags, limit.tag);
    store.set_tags(capture.hash, tags);
    const std::string why =
        many ? fmt::format("more than {}", limit.keep) : fmt::format("more than {} bytes", limit.bytes);
    const bool deleted = tags.empty() && store.delete_capture(capture.hash) == Store::Deletion::deleted;
    if (deleted) {
      std::error_code ignored;  // upkeep finds a file that stayed
      fs::remove(folder.capture(capture.hash), ignored);
    }
    lines.push_back(fmt::format("{} {}: {} have the tag {}: {}", capture.name, capture.hash.substr(0, 8), why,
                                limit.tag, deleted ? "deleted" : "only the tag is gone"));
  }
  return lines;
}

}  // namespace subpixel::server
