#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <random>
#include <span>
#include <utility>

#include "base/fuzz/json_mutator.hpp"
#include "server/fuzz/http_door.hpp"

namespace subpixel::server {
namespace {

using Random = std::minstd_rand;

const std::string kHash(32, 'a');

struct Message {
  std::vector<std::string> lines;  // the request's line and the fields
  std::string body;
};

std::string_view pick(std::span<const std::string_view> words, Random& random) {
  return words[random() % words.size()];
}

Message split(const std::string& text) {
  Message message;
  std::size_t at = 0;
  const std::size_t end = std::min(text.find("\r\n\r\n"), text.size());
  while (at < end) {
    const std::size_t next = std::min(text.find("\r\n", at), end);
    message.lines.push_back(text.substr(at, next - at));
    at = next + 2;
  }
  if (end + 4 <= text.size()) message.body = text.substr(end + 4);
  return message;
}

std::string join(const Message& message) {
  std::string text;
  for (const std::string& line : message.lines) text += line + "\r\n";
  return text + "\r\n" + message.body;
}

void set_length(Message& message) {
  std::erase_if(message.lines, [](const std::string& line) { return line.starts_with("Content-Length:"); });
  message.lines.push_back(fmt::format("Content-Length: {}", message.body.size()));
}

void change_target(std::string& line, Random& random) {
  static constexpr std::array<std::string_view, 24> kParts{"/",
                                                           "//",
                                                           "/api/runs",
                                                           "/api/captures",
                                                           "/api/nights",
                                                           "/events",
                                                           "/results.json",
                                                           "/plot.svg",
                                                           "/advice",
                                                           "?",
                                                           "&",
                                                           "limit=",
                                                           "before=",
                                                           "after=",
                                                           "max_mse=",
                                                           "cost=time",
                                                           "=",
                                                           "%",
                                                           "%00",
                                                           "%2e%2e/",
                                                           "1",
                                                           "18446744073709551616",
                                                           "-1",
                                                           "nan"};
  static constexpr std::array<std::string_view, 8> kMethods{"GET", "POST",    "DELETE", "HEAD",
                                                            "PUT", "OPTIONS", "get",    "PRI"};
  const std::size_t first = line.find(' '), last = line.rfind(' ');
  if (first == std::string::npos || last <= first) return;
  switch (random() % 4) {
    case 0:
      line.replace(0, first, pick(kMethods, random));
      break;
    case 1:
      line.insert(first + 1 + random() % (last - first), pick(kParts, random));
      break;
    case 2:
      line.erase(first + 1 + random() % (last - first), 1 + random() % 4);
      break;
    default:
      line.replace(last + 1, std::string::npos, random() % 2 == 0 ? "HTTP/1.0" : "HTTP/1.1");
  }
}

void change_fields(Message& message, Random& random) {
  static constexpr std::array<std::string_view, 26> kFields{
      "Host: localhost",
      "Host: evil.example",
      "Host: [::1]:8080",
      "Origin: http://127.0.0.1",
      "Origin: null",
      "Sec-Fetch-Site: cross-site",
      "Content-Type: application/json",
      "Content-Type: multipart/form-data; boundary=x",
      "Content-Type: application/x-www-form-urlencoded",
      "Content-Length: 0",
      "Content-Length: 18446744073709551616",
      "Content-Length: -1",
      "Transfer-Encoding: chunked",
      "Content-Encoding: gzip",
      "Accept-Encoding: gzip, br",
      "Expect: 100-continue",
      "Connection: close",
      "Connection: keep-alive, Upgrade",
      "Range: bytes=0-3",
      "Range: bytes=-1,2-,5-4",
      "Range: bytes=99999999999999999999-",
      "If-None-Match: *",
      "Authorization: Bearer DOOR",
      "Authorization: Basic YTpi",
      "Cookie: subpixel_token=x; =; ;",
      "X-Request-Id: a\tb",
  };
  if (message.lines.size() < 2 || random() % 2 == 0) {
    message.lines.emplace_back(pick(kFields, random));
    return;
  }
  std::string& line = message.lines[1 + random() % (message.lines.size() - 1)];
  switch (random() % 4) {
    case 0:
      line = pick(kFields, random);
      break;
    case 1:
      message.lines.push_back(std::string(line));
      break;
    case 2:
      line.insert(random() % (line.size() + 1), 1, static_cast<char>(random()));
      break;
    default:
      std::swap(line, message.lines.back());
      message.lines.pop_back();
  }
}

void change_body(Message& message, Random& random) {
  static constexpr std::array<std::string_view, 16> kWords{"",
                                                           "noaa",
                                                           "msaa",
                                                           "streaming:samples=4|8",
                                                           "msaa:samples=5",
                                                           "all",
                                                           "quick",
                                                           "a",
                                                           "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa",
                                                           "\n",
                                                           "dcaa:samples=64:surfaces=2",
                                                           "*",
                                                           "0",
                                                           "hybrid",
                                                           "taa",
                                                           "\xf0\x9f\x98\x80"};
  const std::string made = mutated_json(message.body, kWords, random);
  if (!made.empty()) {
    message.body = made;
  } else if (!message.body.empty()) {
    message.body.erase(random() % message.body.size(), 1 + random() % 8);
  }
  if (random() % 8 != 0) set_length(message);
}

std::string request(std::string_view line, std::string_view fields = "", std::string_view body = "") {
  const std::string length = body.empty() ? "" : fmt::format("Content-Length: {}\r\n", body.size());
  return fmt::format("{} HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer DOOR\r\n{}{}\r\n{}", line, fields, length,
                     body);
}

}  // namespace

std::vector<std::string> example_requests() {
  std::vector<std::string> all;
  for (const std::string& path : {std::string("/"),
                                  std::string("/app.js"),
                                  std::string("/healthz"),
                                  std::string("/readyz"),
                                  std::string("/metrics"),
                                  std::string("/api/openapi.json"),
                                  std::string("/api/health"),
                                  std::string("/api/caller"),
                                  std::string("/api/techniques"),
                                  std::string("/api/limits"),
                                  std::string("/api/palettes"),
                                  std::string("/api/captures?limit=2&offset=0"),
                                  "/api/captures/" + kHash,
                                  "/api/captures/" + kHash + "/file",
                                  std::string("/api/runs?limit=1&before=9&capture=" + kHash),
                                  std::string("/api/runs/1"),
                                  std::string("/api/runs/1/results.json"),
                                  std::string("/api/runs/1/results.csv"),
                                  std::string("/api/runs/1/plot.svg?cost=memory&error=flip"),
                                  std::string("/api/runs/1/points.md"),
                                  std::string("/api/runs/1/advice?max_mse=1"),
                                  std::string("/api/runs/2/events?after=0"),
                                  std::string("/api/nights?limit=1&before=99&name=quick"),
                                  std::string("/api/nights/1"),
                                  std::string("/api/nights/1/summary.md"),
                                  std::string("/api/nights/1/summary.xml"),
                                  std::string("/api/nights/1/cells/1"),
                                  std::string("/api/baselines"),
                                  std::string("/api/approvals?name=quick")}) {
    all.push_back(request("GET " + path));
  }
  const std::string_view json = "Content-Type: application/json\r\n";
  all.push_back(request("POST /api/runs", json,
                        fmt::format(R"({{"capture":"{}","techniques":["msaa:samples=4|8",{{"technique":"noaa",)"
                                    R"("parameters":{{"shading":"ggx"}}}}],"samples":8,"frames":[0,1],"width":32,)"
                                    R"("height":18,"repeat":1,"reference_samples":64,"point_lights":2,"priority":1,)"
                                    R"("retries":0}})",
                                    kHash)));
  all.push_back(request("POST /api/captures/" + kHash + "/tags", json, R"({"tags":["nightly","b"]})"));
  all.push_back(request("POST /api/captures?name=a.spcap", "Content-Type: application/octet-stream\r\n", "SPCAP"));
  all.push_back(request("POST /api/baselines", json, R"({"name":"quick","night":1,"why":"good"})"));
  all.push_back(request("POST /api/sign-in", json, R"({"token":"DOOR"})"));
  all.push_back(request("POST /api/sign-out"));
  all.push_back(request("POST /api/runs/2/cancel"));
  all.push_back(request("DELETE /api/runs/3"));
  all.push_back(request("HEAD /api/runs/1"));
  return all;
}

std::string mutated_requests(std::string_view text, std::size_t most, unsigned int seed) {
  static const std::vector<std::string> kExamples = example_requests();
  Random random(seed + 1);
  Message message = split(std::string(text));
  if (message.lines.empty() || random() % 16 == 0) message = split(kExamples[random() % kExamples.size()]);
  for (unsigned long count = 1 + random() % 3; count > 0; --count) {
    switch (random() % 8) {
      case 0:
      case 1:
      case 2:
        change_target(message.lines[0], random);
        break;
      case 3:
      case 4:
        change_fields(message, random);
        break;
      case 5:
      case 6:
        change_body(message, random);
        break;
      default:  // what follows on the same connection
        message.body += kExamples[random() % kExamples.size()];
    }
  }
  std::string made = join(message);
  made.resize(std::min(made.size(), most));
  return made;
}

}  // namespace subpixel::server
