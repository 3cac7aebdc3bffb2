// Captures and blobs over HTTP.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <memory>

#include "base/json_document.hpp"
#include "base/printable.hpp"
#include "server/api.hpp"
#include "server/byte_range.hpp"
#include "server/capture_inspection.hpp"
#include "server/http_error.hpp"
#include "server/run_request.hpp"
#include "server/upload.hpp"

namespace subpixel::server {
namespace {

constexpr std::size_t kMaxNameBytes = 120;
constexpr std::int64_t kMaxListedCaptures = 500;
constexpr std::size_t kMaxTags = 20, kMaxTagBytes = 40;

nlohmann::json capture_json(const CaptureRecord& capture) {
  const auto features = capture.summary.find("features");
  return {{"hash", capture.hash},
          {"name", capture.name},
          {"size_bytes", capture.size_bytes},
          {"uploaded_utc", capture.uploaded_utc},
          {"title", capture.title},
          {"frame_count", capture.frame_count},
          {"width", capture.width},
          {"height", capture.height},
          {"triangles", capture.triangles},
          {"features", features != capture.summary.end() ? *features : nlohmann::json::array()},
          {"tags", capture.tags},
          {"thumbnail", capture.thumbnail ? nlohmann::json(*capture.thumbnail) : nlohmann::json(nullptr)}};
}

HttpError no_capture(const std::string& hash) {
  return {404, "there is no such capture", "none has this hash", hash};
}

// The file name of a path of either kind of system: browsers and scripts send both.
std::string display_name(const std::string& given) {
  const std::size_t slash = given.find_last_of("/\\");
  const std::string name = printable(slash == std::string::npos ? given : given.substr(slash + 1), kMaxNameBytes);
  return name.find_first_not_of(' ') == std::string::npos ? "unnamed" : name;
}

}  // namespace

void Api::route_captures(HttpServer& http) {
  route_post(http, "/api/captures",
             [this](const Request& request, Response& response) { post_capture(request, response); });
  http.Get("/api/captures", [this](const Request& request, Response& response) {
    const auto limit = static_cast<std::uint32_t>(query_number(request, "limit", 1, kMaxListedCaptures, 100));
    const auto offset = static_cast<std::uint64_t>(query_number(request, "offset", 0, INT64_MAX, 0));
    nlohmann::json list = nlohmann::json::array();
    for (const CaptureRecord& capture : store_.captures(limit, offset)) list.push_back(capture_json(capture));
    response.set_header("Cache-Control", "no-store");
    write_json(response, 200, {{"captures", list}, {"total", store_.counts().captures}});
  });
  http.Get("/api/captures/([0-9a-f]{32})", [this](const Request& request, Response& response) {
    const std::string hash = request.matches[1];
    const std::optional<CaptureRecord> capture = store_.capture(hash);
    if (!capture) throw no_capture(hash);
    nlohmann::json document = capture_json(*capture);
    document["summary"] = capture->summary;
    response.set_header("Cache-Control", "no-store");
    write_json(response, 200, document);
  });
  http.Get("/api/captures/([0-9a-f]{32})/file", [this](const Request& request, Response& response) {
    send_capture_file(request, request.matches[1], response);
  });
  http.Get("/api/captures/([0-9a-f]{32})/pixel",
           [this](const Request& request, Response& response) { send_story(request, request.matches[1], response); });
  route_post(http, "/api/captures/([0-9a-f]{32})/tags",
             [this](const Request& request, Response& response) { post_tags(request.matches[1], request, response); });
  http.Delete("/api/captures/([0-9a-f]{32})",
              [this](const Request& request, Response& response) { delete_capture(request.matches[1], response); });
  http.Get("/api/blobs/([0-9a-f]{32})",
           [this](const Request& request, Response& response) { send_blob(request, request.matches[1], response); });
}

void Api::post_capture(const Request& request, Response& response) {
  if (request.is_multipart_form_data()) {
    throw HttpError(415, "the upload is refused", "the body must be the capture's bytes, not a form",
                    "header Content-Type");
  }
  Upload& upload = Exchange::current().body();
  const std::string hash = upload.finish();
  std::optional<CaptureRecord> capture = store_.capture(hash);
  CaptureRecord inspected;
  if (!capture) inspected = inspect_capture(upload.path(), options_.worker, stop_.get_token());

  const std::lock_guard lock(captures_mutex_);
  if (upload.keep(hash) == Upload::Kept::collision) {
    throw HttpError(409, "the capture can't be stored", "another one has its content hash", hash);
  }
  bool added = false;
  if (!capture) {
    inspected.hash = hash;
    inspected.name = display_name(request.get_param_value("name"));
    inspected.size_bytes = upload.size_bytes();
    inspected.uploaded_utc = utc_now();
    added = store_.add_capture(inspected);
    if (added && inspected.frame_count > 0 && store_.add_run(RunKind::thumbnail, hash, thumbnail_options(), 1)) {
      queue_.notify();
    }
  }
  capture = store_.capture(hash);
  if (!capture) throw HttpError(409, "the capture is not stored", "it was deleted meanwhile; send it again", hash);
  response.set_header("Location", "/api/captures/" + hash);
  write_json(response, added ? 201 : 200, capture_json(*capture));
}

void Api::post_tags(const std::string& hash, const Request& request, Response& response) {
  const std::string what = "tags";
  const nlohmann::json document = parse_json_document(read_json_body(request, "the list of tags"), what, "the body");
  const JsonField top(document, what);
  check_names(top, {"tags"}, what, "top level");
  const JsonField list = top.member("tags");
  if (list.array_size() > kMaxTags) list.fail(fmt::format("more than {} tags", kMaxTags));
  std::vector<std::string> tags;
  for (std::size_t i = 0; i < list.array_size(); ++i) {
    const std::string tag = list.element(i).text();
    if (tag.empty() || tag.size() > kMaxTagBytes || printable(tag, kMaxTagBytes) != tag) {
      list.element(i).fail(fmt::format("expected 1 to {} printable bytes", kMaxTagBytes));
    }
    tags.push_back(tag);
  }
  if (!store_.set_tags(hash, tags)) throw no_capture(hash);
  response.set_header("Cache-Control", "no-store");
  write_json(response, 200, capture_json(store_.capture(hash).value()));
}

void Api::delete_capture(const std::string& hash, Response& response) {
  const std::lock_guard lock(captures_mutex_);
  switch (store_.delete_capture(hash)) {
    case Store::Deletion::missing:
      throw no_capture(hash);
    case Store::Deletion::in_use:
      throw HttpError(409, "the capture can't be deleted", "a run of it is queued or running; cancel that first", hash);
    case Store::Deletion::deleted:
      break;
  }
  std::error_code ignored;  // an orphaned file is overwritten by the next upload of the same capture
  std::filesystem::remove(folder_.capture(hash), ignored);
  response.status = 204;
}

void Api::send_capture_file(const Request& request, const std::string& hash, Response& response) const {
  const std::optional<CaptureRecord> capture = store_.capture(hash);
  if (!capture) throw no_capture(hash);
  const auto file = std::make_shared<const OpenFile>(::open(folder_.capture(hash).c_str(), O_RDONLY | O_CLOEXEC));
  struct stat status {};
  if (file->descriptor() < 0 || ::fstat(file->descriptor(), &status) != 0) {
    throw HttpError(500, "the capture can't be read", "its file is missing", hash);
  }
  const std::optional<BytePart> part =
      choose_bytes(request, response, static_cast<std::uint64_t>(status.st_size), "\"" + hash + "\"");
  if (!part) return;
  response.set_header("Content-Disposition", fmt::format("attachment; filename=\"{}.spcap\"", hash));
  response.set_content_provider(part->length, "application/octet-stream",
                                [file, part = *part](std::size_t, std::size_t, httplib::DataSink&) {
                                  Exchange::current().send_file(file, part.first, part.length);
                                  return false;
                                });
}

void Api::send_story(const Request& request, const std::string& hash, Response& response) {
  if (!store_.capture(hash)) throw no_capture(hash);
  const auto number = [&](const char* name, std::int64_t most, std::int64_t absent) {
    return query_number(request, name, 0, most, absent);
  };
  constexpr std::int64_t kAny = UINT32_MAX;
  std::vector<std::string> options{fmt::format("--technique={}", request.get_param_value("technique")),
                                   fmt::format("--at={},{}", number("x", kAny, 0), number("y", kAny, 0)),
                                   fmt::format("--frame={}", number("frame", kAny, 0)),
                                   fmt::format("--samples={}", number("samples", kAny, 8)),
                                   fmt::format("--reference-samples={}", number("reference_samples", kAny, 64))};
  if (request.has_param("width"))
    options.push_back(fmt::format("--size={}x{}", number("width", kAny, 0), number("height", kAny, 0)));
  // A story takes a device for seconds; more at a time would only make all of them, and the runs, slower.
  const std::unique_lock lock(story_mutex_, std::try_to_lock);
  if (!lock)
    throw HttpError(503, "the pixel's story is not told", "another one is being told; ask again in a moment", "");
  response.set_header("Cache-Control", "no-store");
  response.set_content(tell_story(folder_.capture(hash), options, options_.worker, stop_.get_token()),
                       "application/json");
}

void Api::send_blob(const Request& request, const std::string& hash, Response& response) const {
  const std::optional<BlobInfo> blob = store_.blob_info(hash);
  if (!blob) throw HttpError(404, "there is no such blob", "none has this hash", hash);
  // The name is the content's hash, so what it names never changes.
  response.set_header("Cache-Control", "private, max-age=31536000, immutable");
  const std::optional<BytePart> part = choose_bytes(request, response, blob->size_bytes, "\"" + hash + "\"");
  if (!part) return;
  // Piece by piece: images may be large, and many clients may ask for them at once.
  response.set_content_provider(
      part->length, blob->media_type, [this, hash, part = *part](std::size_t, std::size_t, httplib::DataSink& sink) {
        return store_.read_blob(hash, part.first, part.length,
                                [&](std::string_view bytes) { return sink.write(bytes.data(), bytes.size()); });
      });
}

}  // namespace subpixel::server
