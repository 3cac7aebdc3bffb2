#include "server/notices.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <httplib.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <thread>

#include "base/printable.hpp"
#include "process/child_process.hpp"
#include "server/nightly/summaries.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

constexpr auto kLongestWait = std::chrono::minutes(1);
constexpr auto kMailTime = std::chrono::minutes(2);
constexpr time_t kConnectSeconds = 5, kAnswerSeconds = 10;

json body_of(const Notice& notice) {
  const CellCounts counts = count_cells(notice.night);
  json failed = json::array();
  for (const NightCell& cell : notice.night.cells) {
    for (const GateResult& gate : cell.gates) {
      if (gate.outcome != GateOutcome::failed || failed.size() >= 100) continue;
      failed.push_back({{"capture", notice.night.captures.at(cell.capture).name},
                        {"technique", cell.technique},
                        {"gate", gate.gate},
                        {"detail", printable(gate.detail, 500)}});
    }
  }
  return {{"event", notice.event},
          {"night", notice.night.id},
          {"name", notice.night.name},
          {"status", notice.event == "night.broken" ? "broken" : std::string(to_text(notice.night.status))},
          {"headline", notice.headline},
          {"commit", notice.night.commit},
          {"counts",
           {{"passed", counts.passed}, {"failed", counts.failed}, {"new", counts.new_}, {"missing", counts.missing}}},
          {"failed", failed},
          {"address", notice.address.empty() || notice.night.id == 0
                          ? json(nullptr)
                          : json(fmt::format("{}/#/nights/{}", notice.address, notice.night.id))}};
}

std::string secret_of(const Webhook& hook) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing changes the environment here
  const char* const secret = hook.secret_variable.empty() ? nullptr : std::getenv(hook.secret_variable.c_str());
  return secret != nullptr ? secret : "";
}

Delivery deliver(const Webhook& hook, std::uint32_t attempts, const std::string& body, std::chrono::milliseconds wait) {
  const std::size_t host = hook.url.find("://") + 3, slash = std::min(hook.url.find('/', host), hook.url.size());
  const std::string path = slash < hook.url.size() ? hook.url.substr(slash) : "/";
  const std::string secret = secret_of(hook);
  if (!hook.secret_variable.empty() && secret.empty())
    return {false, fmt::format("{}: not sent: {} is not set, so it can't be signed", hook.url, hook.secret_variable)};
  httplib::Client client(hook.url.substr(0, slash));
  if (!client.is_valid()) return {false, hook.url + ": not sent: this build does not speak that scheme"};
  client.set_follow_location(false);
  client.set_connection_timeout(kConnectSeconds);
  client.set_read_timeout(kAnswerSeconds);
  client.set_write_timeout(kAnswerSeconds);
  std::string why;
  for (std::uint32_t attempt = 1; attempt <= attempts; ++attempt) {
    if (attempt > 1) {
      std::this_thread::sleep_for(wait);
      wait = std::min<std::chrono::milliseconds>(2 * wait, kLongestWait);
    }
    const std::string now = std::to_string(std::time(nullptr));
    httplib::Headers headers{
        {"User-Agent", "subpixel"}, {"X-Subpixel-Timestamp", now}, {"X-Subpixel-Attempt", std::to_string(attempt)}};
    if (!secret.empty())
      headers.emplace("X-Subpixel-Signature", "sha256=" + hmac_sha256(secret, fmt::format("{}.{}", now, body)));
    const httplib::Result result = client.Post(path, headers, body, "application/json");
    if (result && result->status >= 200 && result->status < 300)
      return {true, fmt::format("{}: {}", hook.url, result->status)};
    why = result ? fmt::format("status {}", result->status) : httplib::to_string(result.error());
    // What the other side does not want it will not want later.
    if (result && result->status < 500 && result->status != 408 && result->status != 429)
      return {false, fmt::format("{}: refused: {}", hook.url, why)};
  }
  return {false, fmt::format("{}: gave up after {} attempts: {}", hook.url, attempts, why)};
}

// RFC 5322 lines end where they would begin a header of their own.
std::string header_text(const std::string& text) {
  std::string out;
  for (const char c : printable(text, 200)) out += static_cast<unsigned char>(c) < 0x80 ? c : '?';
  return out;
}

Delivery send_mail(const NoticeOptions& options, const Notice& notice) {
  std::string to;
  for (const std::string& address : options.mail_to) to += (to.empty() ? "" : ", ") + address;
  std::string file = (std::filesystem::temp_directory_path() / "subpixel-mail-XXXXXX").string();
  const int descriptor = ::mkstemp(file.data());
  if (descriptor < 0) return {false, "mail: no temporary file can be made"};
  ::close(descriptor);
  {
    std::ofstream out(file, std::ios::binary);
    out << "To: " << to << "\n";
    if (!options.mail_from.empty()) out << "From: " << options.mail_from << "\n";
    out << "Subject: [subpixel] " << header_text(notice.headline) << "\n"
        << "Auto-Submitted: auto-generated\nMIME-Version: 1.0\nContent-Type: text/plain; charset=utf-8\n"
        << "Content-Transfer-Encoding: 8bit\n\n"
        << notice.text << "\n";
  }
  ChildLimits limits;
  limits.silence = limits.duration = kMailTime;
  const ChildOutcome outcome = run_child({"/bin/sh", "-c", "exec \"$0\" -t -oi <\"$1\"", options.sendmail, file},
                                         limits, {}, [](std::string_view) { return true; });
  std::error_code ignored;
  std::filesystem::remove(file, ignored);
  if (outcome.reason.empty()) return {true, "mail to " + to + ": given to " + options.sendmail};
  return {false, "mail to " + to + ": " + printable(outcome.reason + " " + outcome.error_tail, 300)};
}

}  // namespace

std::string hmac_sha256(const std::string& key, const std::string& text) {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int length = 0;
  ::HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()), reinterpret_cast<const unsigned char*>(text.data()),
         text.size(), digest, &length);
  std::string hex;
  for (unsigned int i = 0; i < length; ++i) hex += fmt::format("{:02x}", digest[i]);
  return hex;
}

std::vector<Delivery> send_notices(const NoticeOptions& options, const Notice& notice,
                                   std::chrono::milliseconds first_wait) {
  std::vector<Delivery> deliveries;
  if (options.only_failed && notice.event == "night.ended" && notice.night.status == NightStatus::passed)
    return deliveries;
  const std::string body = body_of(notice).dump(-1, ' ', false, json::error_handler_t::replace);
  for (const Webhook& hook : options.webhooks) deliveries.push_back(deliver(hook, options.attempts, body, first_wait));
  if (!options.mail_to.empty()) deliveries.push_back(send_mail(options, notice));
  return deliveries;
}

}  // namespace subpixel::server
