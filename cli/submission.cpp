#include "cli/submission.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <httplib.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "base/error.hpp"
#include "base/hash.hpp"
#include "base/printable.hpp"
#include "cli/option_values.hpp"
#include "cli/progress_line.hpp"
#include "replay/results/parameters.hpp"
#include "replay/results/results.hpp"

namespace subpixel::cli {
namespace {

using nlohmann::json;

constexpr int kReconnects = 30;  // in a row without a word, 1 s apart: longer than a restart of the service takes

// All but the capture.
json run_request(const Submission& submission) {
  json techniques = json::array();
  for (const replay::TechniqueRequest& request : replay::parse_technique_list(submission.techniques)) {
    techniques.push_back({{"technique", request.technique}, {"parameters", json(request.parameters)}});
    if (request.parameters.empty()) techniques.back().erase("parameters");
  }
  json body = {{"techniques", techniques}};
  if (submission.samples) body["samples"] = *submission.samples;
  if (submission.repeat) body["repeat"] = *submission.repeat;
  if (submission.reference_samples) body["reference_samples"] = *submission.reference_samples;
  if (submission.point_lights) body["point_lights"] = *submission.point_lights;
  if (submission.every_light) body["every_light"] = true;
  if (!submission.memory.empty()) body["memory_mib"] = replay::parse_memory(submission.memory, "--memory");
  if (submission.priority) body["priority"] = *submission.priority;
  if (submission.retries) body["retries"] = *submission.retries;
  if (!submission.frames.empty()) {
    const auto [first, last] = parse_frames(submission.frames);
    body["frames"] = {first, last};
  }
  if (!submission.size.empty()) {
    const auto [width, height] = replay::parse_size(submission.size, "--size");
    body["width"] = width;
    body["height"] = height;
  }
  return body;
}

// The document of a successful answer; other answers are thrown as the service words them.
json answer(const httplib::Result& result, const std::string& what, const std::string& server) {
  if (!result) throw InputError(what, "no answer: " + httplib::to_string(result.error()), server);
  json document = json::parse(result->body, nullptr, false);
  if (result->status >= 200 && result->status < 300 && !document.is_discarded()) return document;
  const json error = document.is_object() ? document.value("error", json::object()) : json::object();
  const std::string why = error.value("why", fmt::format("it answered with status {}", result->status));
  const std::string where = error.value("where", server);
  if (result->status == 400) throw UsageError(what, why, where);
  throw InputError(what, why, where);
}

std::string token_of(const Submission& submission) {
  if (submission.token_file.empty()) {
    const char* const token = std::getenv("SUBPIXEL_TOKEN");
    return token != nullptr ? token : "";
  }
  std::string token;
  if (!(std::ifstream(submission.token_file) >> token)) {
    throw InputError("can't submit", "there is no token in the file", submission.token_file);
  }
  return token;
}

json send_capture(httplib::Client& client, const Submission& submission) {
  struct File {
    int fd;
    ~File() { ::close(fd); }
  };
  const File file{::open(submission.file.c_str(), O_RDONLY | O_CLOEXEC)};
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(submission.file, error);
  if (file.fd < 0 || error) throw InputError("can't send the capture", "it can't be read", submission.file);
  const std::string name = std::filesystem::path(submission.file).filename().string();
  const std::string path = "/api/captures?name=" + httplib::detail::encode_query_param(name);
  const httplib::Result result = client.Post(
      path, static_cast<std::size_t>(size),
      [&](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        std::vector<char> block(std::min<std::size_t>(length, std::size_t{1} << 20));
        const ssize_t got = ::pread(file.fd, block.data(), block.size(), static_cast<off_t>(offset));
        return got > 0 && sink.write(block.data(), static_cast<std::size_t>(got));
      },
      "application/octet-stream");
  return answer(result, "can't send the capture", submission.server);
}

void show(ProgressLine& line, const json& status) {
  const json progress = status.value("progress", json());
  const std::string detail =
      progress.is_object() ? progress.value("stage", "") + " " + progress.value("detail", "") : "";
  line.update(status.value("status", ""), status.value("stored_results", std::uint64_t{0}),
              status.value("expected_results", std::uint64_t{0}), detail);
}

// Reads the event stream until its "end", across reconnections. Returns the run's last status.
json follow(httplib::Client& client, const std::string& run_path) {
  std::string last_id, pending;
  json end;
  ProgressLine progress;
  for (int attempt = 0; attempt < kReconnects && end.is_null(); ++attempt) {
    if (attempt > 0) std::this_thread::sleep_for(std::chrono::seconds(1));
    const httplib::Headers headers =
        last_id.empty() ? httplib::Headers{} : httplib::Headers{{"Last-Event-ID", last_id}};
    pending.clear();
    client.Get(run_path + "/events", headers, [&](const char* bytes, std::size_t size) {
      attempt = 0;
      pending.append(bytes, size);
      for (std::size_t blank; (blank = pending.find("\n\n")) != std::string::npos; pending.erase(0, blank + 2)) {
        std::string event, data;
        std::istringstream lines(pending.substr(0, blank));
        for (std::string line; std::getline(lines, line);) {
          if (line.starts_with("id: ")) last_id = line.substr(4);
          if (line.starts_with("event: ")) event = line.substr(7);
          if (line.starts_with("data: ")) data = line.substr(6);
        }
        if (event == "status") show(progress, json::parse(data));
        if (event == "end") end = json::parse(data);
      }
      return end.is_null();
    });
  }
  return end;
}

// The capture's hash, once the service has it. One that it has already is not sent again.
std::string hash_at_service(httplib::Client& client, const Submission& submission) {
  std::string hash = content_hash_hex(std::filesystem::path(submission.file));
  const httplib::Result known = client.Get("/api/captures/" + hash);
  if (known && known->status == 200) return hash;
  return send_capture(client, submission).at("hash").get<std::string>();
}

int submit_to_service(const Submission& submission) {
  httplib::Client client(submission.server);
  if (!client.is_valid()) throw UsageError("can't submit", "expected http://HOST:PORT", "--server");
  if (const std::string token = token_of(submission); !token.empty()) client.set_bearer_token_auth(token);
  client.set_read_timeout(std::chrono::minutes(6));  // a service reads a large capture before it answers
  json body;
  if (!submission.techniques.empty())
    body = run_request(submission);  // what is wrong with it is said before the upload
  const std::string hash = hash_at_service(client, submission);
  fmt::print("capture {}\n", hash);
  if (body.is_null()) return 0;

  body["capture"] = hash;
  const std::string where = submission.once ? "/api/runs?once=1" : "/api/runs";
  const json run =
      answer(client.Post(where, body.dump(), "application/json"), "can't start the run", submission.server);
  const std::string path = fmt::format("/api/runs/{}", run.at("id").get<std::int64_t>());
  fmt::print("run {}/#/runs/{}\n", printable(submission.server), run.at("id").get<std::int64_t>());
  std::fflush(stdout);
  if (!submission.wait) return 0;

  const json end = follow(client, path);
  if (end.is_null()) throw InputError("the run's end is unknown", "the service does not answer", submission.server);
  if (end.at("status") != "done") {
    throw InputError("the run " + end.at("status").get<std::string>(), end.value("reason", ""),
                     submission.server + path);
  }
  const json results = answer(client.Get(path + "/results.json"), "can't read the results", submission.server);
  fmt::print("{}results {}{}/results.json\n", replay::to_table(replay::results_from_json(results)),
             printable(submission.server), path);
  return 0;
}

}  // namespace

int submit(const Submission& submission) {
  try {
    return submit_to_service(submission);
  } catch (const json::exception& error) {
    throw InputError("the answer is not of this service's kind", error.what(), submission.server);
  }
}

}  // namespace subpixel::cli
