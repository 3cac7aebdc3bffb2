#include "server/fuzz/http_door.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "base/numbers.hpp"
#include "server/api.hpp"
#include "server/header_scan.hpp"
#include "server/http_server.hpp"
#include "server/nightly/night_store.hpp"
#include "server/store/data_folder.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

const std::string kHash(32, 'a');  // of the capture that is there

ServiceOptions door_options(const std::filesystem::path& folder, bool require_token) {
  ServiceOptions options;
  options.data = folder;
  options.require_token = require_token;
  options.reserved_bytes = 0;
  options.worker.program = "/bin/false";  // what uploads are read with
  return options;
}

replay::FrameResult result_of(std::uint32_t frame) {
  replay::FrameResult result;
  result.frame = frame;
  result.technique = "noaa";
  result.ms.passes = {{"shade", 2.5}};
  result.ms.total_ms = 2.5;
  result.error.mse = 0.25;
  return result;
}

void fill(const DataFolder& folder, Store& store) {
  std::ofstream(folder.capture(kHash), std::ios::binary) << "a capture's bytes";
  CaptureRecord capture;
  capture.hash = kHash;
  capture.name = "a";
  capture.frame_count = 2;
  capture.size_bytes = 17;
  capture.uploaded_utc = "2025-01-31T12:00:00.000Z";
  capture.summary = json::object();
  store.add_capture(capture);
  replay::ReplayOptions options;
  options.techniques = {{"noaa", {}}};
  options.frames = {0, 1};
  const std::int64_t run = store.add_run(RunKind::run, kHash, options, 2).value();
  store.start_next_run();
  for (const std::uint32_t frame : {0u, 1u})
    store.add_result(run, 0, result_of(frame), {{"image", {"image/png", "an image"}}});
  store.finish_run(run, RunStatus::done, "");
  store.add_run(RunKind::run, kHash, options, 2);

  NightStore nights(store);
  NightRecord night;
  night.name = "quick";
  night.config = json::object();
  const std::int64_t id = nights.add(night);
  nights.add_capture(id, 0,
                     {.name = "one", .source = "path", .hash = kHash, .problem = "", .head = replay::ResultsHead{}});
  NightCell cell;
  cell.technique = "noaa";
  cell.status = CellStatus::passed;
  nights.add_frame(nights.add_cell(id, cell), result_of(0), {{"image", {"image/png", "an image"}}});
  nights.finish(id, NightStatus::passed, "");
  nights.set_baseline("quick", id);
}

// All that an answer sends, as a client would read it.
std::string text_of(Outgoing answer) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends.data()) != 0)
    throw std::system_error(errno, std::generic_category(), "socketpair");
  std::string text;
  std::array<char, 1 << 16> bytes{};
  Outgoing::Sent sent = Outgoing::Sent::some;
  while (sent == Outgoing::Sent::some) {
    sent = answer.send_to(ends[0]);
    for (ssize_t got = 0; (got = ::read(ends[1], bytes.data(), bytes.size())) > 0;)
      text.append(bytes.data(), static_cast<std::size_t>(got));
  }
  ::close(ends[0]);
  ::close(ends[1]);
  return text;
}

struct Told {
  int status = 0;
  std::string header, body;

  std::string value(std::string_view name) const {
    const std::size_t at = header.find(fmt::format("\r\n{}: ", name));
    if (at == std::string::npos) return "";
    const std::size_t begin = at + name.size() + 4;
    return header.substr(begin, header.find("\r\n", begin) - begin);
  }
};

// The last one of `text`, after interim ones.
Told parse(std::string_view text) {
  while (text.starts_with("HTTP/1.1 1")) text.remove_prefix(std::min(text.find("\r\n\r\n") + 4, text.size()));
  Told answer;
  const std::size_t end = text.find("\r\n\r\n");
  if (!text.starts_with("HTTP/1.1 ") || end == std::string_view::npos) return answer;
  answer.status = parse_number<int>(text.substr(9, 3)).value_or(0);
  answer.header = text.substr(0, end + 2);
  answer.body = text.substr(end + 4);
  return answer;
}

std::string what_is_wrong(const Told& answer, bool only_header, bool follows) {
  if (answer.status < 200 || answer.status > 599) return "it has no status";
  if (answer.status == 500) return "it is our mistake: " + answer.body;
  if (only_header && answer.status == 400) return "";  // of a line that is malformed it may not be known what it asks
  if (follows || answer.status == 204 || answer.status == 304) return answer.body.empty() ? "" : "it has a body";
  if (only_header) return answer.body.empty() ? "" : "it has a body";
  const auto length = parse_number<std::size_t>(answer.value("Content-Length"));
  if (!length) return "it has no length";
  if (*length != answer.body.size()) return "its length is not that of its body";
  if (!answer.value("Content-Encoding").empty()) return "";
  if (answer.value("Content-Type") == "application/json" && !json::accept(answer.body)) return "its JSON is none";
  if (answer.status >= 400 && !json::parse(answer.body, nullptr, false).contains("error"))
    return "it does not say its error";
  return "";
}

std::string with(std::string text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

}  // namespace

struct HttpDoor::State {
  State(const std::filesystem::path& path, bool require_token)
      : options(door_options(path, require_token)),
        folder(path),
        store(folder.store()),
        http(options.http, folder.uploads()),
        events([](std::int64_t) {}),
        queue(store, folder, events, options.worker),
        api(options, folder, store, events, queue) {
    fill(folder, store);
    token = TokenStore(store).add("door", Right::admin, std::nullopt, std::nullopt);
    api.route(http);
    // Without a socket the library takes itself for ended.
    if (http.bind_to_any_port("127.0.0.1") <= 0) throw std::runtime_error("no port is free");
  }

  ServiceOptions options;
  DataFolder folder;
  std::filesystem::path uploads = folder.uploads();
  Store store;
  HttpServer http;
  RunEvents events;
  JobQueue queue;
  Api api;
  std::string token;
  OpenBody open_body = [this](std::uint64_t) { return std::make_unique<Upload>(folder); };
};

HttpDoor::HttpDoor(const std::filesystem::path& folder, bool require_token)
    : state_(std::make_unique<State>(folder, require_token)) {
  spdlog::set_level(spdlog::level::off);
}

HttpDoor::~HttpDoor() = default;

HttpDoor::Taken HttpDoor::take(std::string_view bytes) {
  State& s = *state_;
  const std::string all = with(std::string(bytes), "Bearer DOOR", "Bearer " + s.token);
  std::string_view input = all;
  Taken taken;
  while (taken.wrong.empty()) {
    HeaderScan scan;
    if (scan.scan(input, s.options.http) != HeaderScan::Found::end) return taken;
    const std::string header(input.substr(0, scan.header_bytes()));
    input.remove_prefix(header.size());
    Exchange exchange(header, {"127.0.0.1", 1}, false, s.open_body, s.uploads);
    s.http.answer(exchange);
    if (exchange.waits_for_body()) {
      const std::string_view body = input.substr(0, exchange.body_left());
      input.remove_prefix(body.size());
      exchange.add_to_body(body);
      if (exchange.body_left() > 0) exchange.end_body();
      s.http.answer(exchange);
    }
    const bool follows = exchange.take_following().has_value();
    const Told answer = parse(text_of(exchange.take_answer()));
    taken.statuses.push_back(answer.status);
    if (const std::string wrong = what_is_wrong(answer, header.starts_with("HEAD "), follows); !wrong.empty())
      taken.wrong = fmt::format("{}\n-- asked --\n{}\n-- answered --\n{}{}", wrong, header, answer.header, answer.body);
    if (follows || !exchange.keeps_connection()) return taken;
  }
  return taken;
}

}  // namespace subpixel::server
