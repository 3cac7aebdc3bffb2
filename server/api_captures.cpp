// Captures and blobs over HTTP.
#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <memory>

#include "base/hash.hpp"
#include "base/json_document.hpp"
#include "base/printable.hpp"
#include "server/api.hpp"
#include "server/byte_range.hpp"
#include "server/capture_inspection.hpp"
#include "server/http_error.hpp"
#include "server/request_context.hpp"
#include "server/run_request.hpp"
#include "server/upload.hpp"

namespace subpixel::server {
namespace {

constexpr std::size_t kMaxNameBytes = 120;
constexpr std::int64_t kMaxListedCaptures = 500;
constexpr std::size_t kMaxImports = 6;  // uploads have 16 threads: those that are captures must get through
constexpr std::int64_t kMostViewSide = 2048;
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

// What an upload takes of its sender's quota, given back unless it is kept. Throws HttpError 413 when it would be
// above.
class QuotaCharge {
 public:
  QuotaCharge(TokenStore& tokens, const std::optional<TokenRecord>& caller, std::uint64_t bytes)
      : tokens_(tokens), token_(caller ? caller->id : 0), bytes_(bytes) {
    if (token_ != 0 && !tokens_.charge(token_, bytes_)) {
      throw HttpError(413, "the capture is not stored",
                      fmt::format("with its {} bytes the token's quota would be exceeded", bytes),
                      "header Authorization");
    }
  }
  ~QuotaCharge() {
    if (token_ == 0) return;
    try {
      tokens_.refund(token_, bytes_);
    } catch (const std::exception& error) {
      spdlog::error("{} bytes stay counted against token {}: {}", bytes_, token_, error.what());
    }
  }
  QuotaCharge(const QuotaCharge&) = delete;
  QuotaCharge& operator=(const QuotaCharge&) = delete;
  void keep() { token_ = 0; }

 private:
  TokenStore& tokens_;
  std::int64_t token_;
  std::uint64_t bytes_;
};

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

void Api::route_captures(Routes& routes) {
  routes.add(
      {.method = "POST",
       .path = "/api/captures",
       .id = "upload_capture",
       .meaning = "Stores the body, an .spcap file, or the capture it makes of a .glb, .zip or .rdc",
       .right = Right::submit,
       .answers = {{201, "UploadedCapture"}, {200, "UploadedCapture"}, {409, ""}, {413, ""}, {415, ""}, {422, ""}},
       .query = {{"name", R"({"type":"string"})", "the file's name"}},
       .body = "application/octet-stream"},
      [this](const Request& request, Response& response) { post_capture(request, response); });
  routes.add({.method = "GET",
              .path = "/api/captures",
              .id = "list_captures",
              .meaning = "Captures, newest first",
              .answers = {{200, "CaptureList"}, {400, ""}},
              .query = {{"limit", R"({"type":"integer","minimum":1,"maximum":500,"default":100})", "at most so many"},
                        {"offset", R"({"type":"integer","minimum":0,"default":0})", "after so many"}}},
             [this](const Request& request, Response& response) { list_captures(request, response); });
  routes.add({.method = "GET",
              .path = "/api/captures/{hash}",
              .id = "get_capture",
              .meaning = "One capture with its summary",
              .answers = {{200, "CaptureWithSummary"}, {404, ""}}},
             [this](const Request&, Response& response) { get_capture(path_part(0), response); });
  routes.add(
      {.method = "GET",
       .path = "/api/captures/{hash}/file",
       .id = "download_capture",
       .meaning = "The file, or with Range a part of it",
       .answers =
           {{200, "application/octet-stream"}, {206, "application/octet-stream"}, {304, ""}, {404, ""}, {416, ""}}},
      [this](const Request& request, Response& response) { send_capture_file(request, path_part(0), response); });
  const std::string number = R"({"type":"integer","minimum":0})";
  routes.add({.method = "GET",
              .path = "/api/captures/{hash}/pixel",
              .id = "tell_story",
              .meaning = "What happens in a pixel of a frame, by a technique, msaa and the reference",
              .answers = {{200, "PixelStory"}, {400, ""}, {404, ""}},
              .query = {{"technique", R"({"type":"string"})", "as the command line has it"},
                        {"x", number, "pixels from the left"},
                        {"y", number, "pixels from the top"},
                        {"frame", number, "its number"},
                        {"width", number, "of the image, pixels; as recorded when absent"},
                        {"height", number, "the same"},
                        {"samples", number, "of techniques that do not say how many"},
                        {"reference_samples", number, "0: no reference"},
                        {"point_lights", number, "this many, as of a run; as recorded when absent"}}},
             [this](const Request& request, Response& response) { send_story(request, path_part(0), response); });
  const std::string side = R"({"type":"integer","minimum":1,"maximum":2048,"default":)";
  routes.add({.method = "GET",
              .path = "/api/captures/{hash}/frame",
              .id = "show_frame",
              .meaning = "A frame's draws in their order, its picture, and which draw each pixel shows",
              .answers = {{200, "FrameView"}, {400, ""}, {404, ""}},
              .query = {{"frame", number, "its number"},
                        {"width", side + "640}", "of the picture, pixels"},
                        {"height", side + "360}", "the same"}}},
             [this](const Request& request, Response& response) { send_frame_view(request, path_part(0), response); });
  routes.add({.method = "POST",
              .path = "/api/captures/{hash}/tags",
              .id = "set_tags",
              .meaning = "Replaces its tags",
              .right = Right::submit,
              .answers = {{200, "Capture"}, {400, ""}, {404, ""}, {415, ""}},
              .body = "Tags"},
             [this](const Request& request, Response& response) { post_tags(path_part(0), request, response); });
  routes.add({.method = "DELETE",
              .path = "/api/captures/{hash}",
              .id = "delete_capture",
              .meaning = "Deletes it with its runs",
              .right = Right::admin,
              .answers = {{204, ""}, {404, ""}, {409, ""}}},
             [this](const Request&, Response& response) { delete_capture(path_part(0), response); });
  routes.add({.method = "GET",
              .path = "/api/blobs/{hash}",
              .id = "download_blob",
              .meaning = "An image or map, or with Range a part of it",
              .answers = {{200, "image/*"}, {206, "image/*"}, {304, ""}, {404, ""}, {416, ""}}},
             [this](const Request& request, Response& response) { send_blob(request, path_part(0), response); });
}

void Api::list_captures(const Request& request, Response& response) const {
  const auto limit = static_cast<std::uint32_t>(query_number(request, "limit", 1, kMaxListedCaptures, 100));
  const auto offset = static_cast<std::uint64_t>(query_number(request, "offset", 0, INT64_MAX, 0));
  nlohmann::json list = nlohmann::json::array();
  for (const CaptureRecord& capture : store_.captures(limit, offset)) list.push_back(capture_json(capture));
  response.set_header("Cache-Control", "no-store");
  write_json(response, 200, {{"captures", list}, {"total", store_.counts().captures}});
}

void Api::get_capture(const std::string& hash, Response& response) const {
  const std::optional<CaptureRecord> capture = store_.capture(hash);
  if (!capture) throw no_capture(hash);
  nlohmann::json document = capture_json(*capture);
  document["summary"] = capture->summary;
  response.set_header("Cache-Control", "no-store");
  write_json(response, 200, document);
}

std::unique_ptr<CaptureImport> Api::import_upload(const Upload& upload, const std::string& kind,
                                                  const std::string& name) {
  const std::size_t others = imports_.fetch_add(1);
  const std::shared_ptr<const void> place(nullptr, [this](const void*) { --imports_; });
  if (others >= kMaxImports) {
    throw HttpError(503, "the file is not imported", fmt::format("{} others are being imported; try again", others),
                    "");
  }
  const std::lock_guard lock(imports_mutex_);
  return std::make_unique<CaptureImport>(folder_, upload.path(), kind, name, options_.worker,
                                         options_.upload_limit_bytes, stop_.get_token());
}

void Api::post_capture(const Request& request, Response& response) {
  if (request.is_multipart_form_data()) {
    throw HttpError(415, "the upload is refused", "the body must be the capture's bytes, not a form",
                    "header Content-Type");
  }
  Upload& upload = Exchange::current().body();
  std::string hash = upload.finish();
  std::filesystem::path file = upload.path();
  const std::string name = display_name(request.get_param_value("name"));
  std::unique_ptr<CaptureImport> imported;
  if (const std::optional<std::string> kind = imported_kind(file)) {
    imported = import_upload(upload, *kind, name);
    file = imported->file();
    hash = content_hash_hex(file);
  }
  std::optional<CaptureRecord> capture = store_.capture(hash);
  CaptureRecord inspected;
  if (!capture) inspected = inspect_capture(file, options_.worker, stop_.get_token());

  const std::lock_guard lock(captures_mutex_);
  std::optional<QuotaCharge> charge;  // before the file takes room
  if (!capture) charge.emplace(access_.tokens(), request_context().caller, std::filesystem::file_size(file));
  if (keep_capture(folder_, file, hash) == Kept::collision) {
    throw HttpError(409, "the capture can't be stored", "another one has its content hash", hash);
  }
  bool added = false;
  if (!capture) {
    inspected.hash = hash;
    inspected.name = name;
    inspected.size_bytes = std::filesystem::file_size(file);
    inspected.uploaded_utc = utc_now();
    added = store_.add_capture(inspected);
    if (added) charge->keep();
    // Upkeep in another process deletes files that no row names, by now no longer this one.
    if (!std::filesystem::exists(folder_.capture(hash))) keep_capture(folder_, file, hash);
    if (added && inspected.frame_count > 0 && store_.add_run(RunKind::thumbnail, hash, thumbnail_options(), 1)) {
      queue_.notify();
    }
  }
  capture = store_.capture(hash);
  if (!capture) throw HttpError(409, "the capture is not stored", "it was deleted meanwhile; send it again", hash);
  response.set_header("Location", "/api/captures/" + hash);
  nlohmann::json document = capture_json(*capture);
  document["notices"] = capture->summary.value("notices", nlohmann::json::array());
  write_json(response, added ? 201 : 200, document);
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
  if (request.has_param("point_lights")) options.push_back(fmt::format("--lights={}", number("point_lights", kAny, 0)));
  response.set_header("Cache-Control", "no-store");
  write_json(response, 200, ask_about_pixels(hash, {"pixel", std::move(options), "the pixel's story is not told"}));
}

// A story or view takes a device for seconds; more at a time would only make all of them, and the runs, slower.
nlohmann::json Api::ask_about_pixels(const std::string& hash, const Question& question) {
  const std::unique_lock lock(story_mutex_, std::try_to_lock);
  if (!lock) throw HttpError(503, question.what, "another story or view is being made; ask again in a moment", "");
  return ask_program(folder_.capture(hash), question, options_.worker, stop_.get_token());
}

void Api::send_frame_view(const Request& request, const std::string& hash, Response& response) {
  if (!store_.capture(hash)) throw no_capture(hash);
  const auto frame = query_number(request, "frame", 0, UINT32_MAX, 0);
  const auto width = query_number(request, "width", 1, kMostViewSide, 640);
  const auto height = query_number(request, "height", 1, kMostViewSide, 360);
  std::vector<std::string> options{"--draws", "--seen", fmt::format("--frame={}", frame),
                                   fmt::format("--size={}x{}", width, height)};
  const std::string what = "the frame is not shown";
  const nlohmann::json document = ask_about_pixels(hash, {"info", std::move(options), what});
  const auto view = document.find("draws_of_frame");
  if (view == document.end()) throw HttpError(500, what, "the worker's document has no draws", "");
  // The hash names the content; another version of the program may light it otherwise.
  response.set_header("Cache-Control", "private, max-age=600");
  write_json(response, 200, *view);
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
