// Who is told how a night ended: webhooks against a server of the test's own, mail by a stand-in for sendmail; watched
// folders and what a tag may hold.
#include "server/notices.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <mutex>
#include <sstream>

#include "base/error.hpp"
#include "server/watch_folder.hpp"
#include "tests/service/nights_fixture.hpp"

namespace subpixel::tests {
namespace {

using server::Delivery;
using server::Notice;
using server::NoticeOptions;

class Receiver {
 public:
  explicit Receiver(std::vector<int> answers) : answers_(std::move(answers)) {
    http_.Post("/hook", [this](const httplib::Request& request, httplib::Response& response) {
      const std::lock_guard lock(mutex_);
      response.status = answers_.at(std::min(requests_.size(), answers_.size() - 1));
      if (response.status == 302) response.set_header("Location", "/elsewhere");
      requests_.push_back(request);
    });
    http_.Post("/elsewhere", [this](const httplib::Request&, httplib::Response&) { ++elsewhere_; });
    port_ = http_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { http_.listen_after_bind(); });
    while (!http_.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ~Receiver() {
    http_.stop();
    thread_.join();
  }
  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_) + "/hook"; }
  std::vector<httplib::Request> requests() const {
    const std::lock_guard lock(mutex_);
    return requests_;
  }
  int elsewhere() const { return elsewhere_; }

 private:
  httplib::Server http_;
  std::thread thread_;
  int port_ = 0;
  std::vector<int> answers_;
  mutable std::mutex mutex_;
  std::vector<httplib::Request> requests_;
  std::atomic<int> elsewhere_ = 0;
};

Notice a_notice() {
  Notice notice{"night.ended", "night 7 of quick failed: 1 of 3 cells", "words", {}, "http://localhost:1"};
  notice.night.id = 7;
  notice.night.name = "quick";
  notice.night.status = server::NightStatus::failed;
  return notice;
}

std::vector<Delivery> send(const NoticeOptions& options) {
  return send_notices(options, a_notice(), std::chrono::milliseconds(1));
}

TEST(Notices, HmacIsThatOfTheRfc) {
  // RFC 4231, test case 2.
  EXPECT_EQ(server::hmac_sha256("Jefe", "what do ya want for nothing?"),
            "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
}

TEST(Notices, AWebhookIsSignedAndRetried) {
  const Receiver receiver({503, 429, 408, 200});
  ::setenv("SUBPIXEL_TEST_SECRET", "key", 1);  // NOLINT(concurrency-mt-unsafe)
  NoticeOptions options;
  options.webhooks = {{receiver.url(), "SUBPIXEL_TEST_SECRET"}};
  const std::vector<Delivery> deliveries = send(options);
  ASSERT_EQ(deliveries.size(), 1u);
  EXPECT_TRUE(deliveries[0].arrived) << deliveries[0].text;
  const std::vector<httplib::Request> requests = receiver.requests();
  ASSERT_EQ(requests.size(), 4u);
  for (const httplib::Request& request : requests) {
    const std::string signed_text = request.get_header_value("X-Subpixel-Timestamp") + "." + request.body;
    EXPECT_EQ(request.get_header_value("X-Subpixel-Signature"), "sha256=" + server::hmac_sha256("key", signed_text));
  }
  EXPECT_EQ(requests[3].get_header_value("X-Subpixel-Attempt"), "4");
  const json body = json::parse(requests[3].body);
  EXPECT_EQ(body.at("event"), "night.ended");
  EXPECT_EQ(body.at("status"), "failed");
  EXPECT_EQ(body.at("address"), "http://localhost:1/#/nights/7");
}

TEST(Notices, ABrokenNightIsToldToo) {
  const Receiver receiver({200});
  NoticeOptions options;
  options.webhooks = {{receiver.url(), ""}};
  options.only_failed = true;
  Notice notice = a_notice();
  notice.event = "night.broken";
  notice.night.id = 0;  // it had not begun
  notice.night.status = server::NightStatus::passed;
  notice.headline = "the capture \xff is none";
  notice.night.captures = {{"one", "", "", "", {}}};
  notice.night.cells.resize(150);
  for (server::NightCell& cell : notice.night.cells)
    cell.gates = {{"memory", server::GateOutcome::failed, "more"}, {"images", server::GateOutcome::passed, ""}};
  const std::vector<Delivery> deliveries = send_notices(options, notice, std::chrono::milliseconds(1));
  ASSERT_EQ(deliveries.size(), 1u);
  EXPECT_TRUE(deliveries[0].arrived) << deliveries[0].text;
  const json body = json::parse(receiver.requests().at(0).body);
  EXPECT_EQ(body.at("status"), "broken");
  EXPECT_TRUE(body.at("address").is_null());
  EXPECT_EQ(body.at("failed").size(), 100u) << "a message is no database";
  EXPECT_EQ(body.at("failed").at(99).at("gate"), "memory");
  EXPECT_TRUE(receiver.requests().at(0).get_header_value("X-Subpixel-Signature").empty());
}

TEST(Notices, AttemptsAreBoundedAndRefusalsAreFinal) {
  const Receiver busy({503}), refusing({400}), elsewhere({302});
  NoticeOptions options;
  options.attempts = 3;
  options.webhooks = {{busy.url(), ""}, {refusing.url(), ""}, {elsewhere.url(), ""}, {busy.url(), "NO_SUCH_SECRET"}};
  const std::vector<Delivery> deliveries = send(options);
  ASSERT_EQ(deliveries.size(), 4u);
  for (const Delivery& delivery : deliveries) EXPECT_FALSE(delivery.arrived) << delivery.text;
  EXPECT_EQ(busy.requests().size(), 3u) << "and not without the key that signs";
  EXPECT_NE(deliveries[0].text.find("gave up after 3 attempts: status 503"), std::string::npos) << deliveries[0].text;
  EXPECT_EQ(refusing.requests().size(), 1u);
  EXPECT_EQ(elsewhere.requests().size(), 1u);
  EXPECT_EQ(elsewhere.elsewhere(), 0) << "redirects lead where nobody configured";
  options.only_failed = true;
  Notice passed = a_notice();
  passed.night.status = server::NightStatus::passed;
  EXPECT_TRUE(send_notices(options, passed, std::chrono::milliseconds(1)).empty());
}

TEST(Notices, MailGoesToSendmail) {
  const TemporaryFolder folder;
  const std::filesystem::path program = folder.path() / "sendmail", letter = folder.path() / "letter";
  std::ofstream(program) << "#!/bin/sh\n{ echo \"$@\"; cat; } >'" << letter.string() << "'\n";
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  NoticeOptions options;
  options.mail_to = {"a@example.net", "b@example.net"};
  options.sendmail = program.string();
  options.mail_from = "nights@example.net";
  Notice notice = a_notice();
  notice.headline = "night 7 \xc3\xbc\nBcc: everybody@example.net";
  const auto letters = [] {
    const std::filesystem::directory_iterator all(std::filesystem::temp_directory_path());
    return std::ranges::count_if(
        all, [](const auto& entry) { return entry.path().filename().string().starts_with("subpixel-mail-"); });
  };
  const auto letters_before = letters();
  const std::vector<Delivery> deliveries = send_notices(options, notice);
  ASSERT_EQ(deliveries.size(), 1u);
  EXPECT_TRUE(deliveries[0].arrived) << deliveries[0].text;
  std::stringstream text;
  text << std::ifstream(letter).rdbuf();
  EXPECT_TRUE(
      text.str().starts_with("-t -oi\nTo: a@example.net, b@example.net\nFrom: nights@example.net\n"
                             "Subject: [subpixel] night 7 ??"))
      << text.str();
  EXPECT_TRUE(text.str().ends_with("\n\nwords\n")) << text.str();
  EXPECT_LE(letters(), letters_before) << "the letter's file is gone";
  EXPECT_EQ(text.str().find("\nBcc:"), std::string::npos) << text.str();
  options.sendmail = (folder.path() / "nowhere").string();
  EXPECT_FALSE(send_notices(options, notice)[0].arrived);
}

TEST(Notices, AddressesAreChecked) {
  const auto parse = [](const json& notify) {
    return server::parse_nightly_config(
        json{{"name", "a"}, {"techniques", "noaa"}, {"captures", {{{"scene", "cube"}}}}, {"notify", notify}}.dump(),
        "/tmp");
  };
  EXPECT_EQ(parse({{"webhooks", {{{"url", "https://example.net/x"}}}}}).notices.webhooks.size(), 1u);
  for (const char* url : {"ftp://example.net", "http://", "http:///x", "http://a@b/", "http://a b/", "/x"})
    EXPECT_THROW(parse({{"webhooks", {{{"url", url}}}}}), InputError) << url;
  for (const char* to : {"", "a", "@b", "a@", "-oQ@x", "a@b,c@d", "a@b\nBcc: c@d", "a b@c"})
    EXPECT_THROW(parse({{"mail", {{"to", {to}}}}}), InputError) << to;
  EXPECT_THROW(parse({{"mail", {{"to", {"a@b"}}, {"sendmail", "sendmail"}}}}), InputError);
  EXPECT_THROW(parse({{"attempts", 0}}), InputError);
}

class WatchFolder : public Nights {
 protected:
  using Store = server::Store;
  void leave(const std::string& name, const json& behaviour) const {
    std::filesystem::create_directories(folder() / "drops");
    std::ofstream(folder() / "drops" / name) << fake_capture(behaviour);
  }
  static std::vector<std::string> take(const server::DataFolder& data, Store& store, const std::filesystem::path& from,
                                       std::uint32_t quiet_s = 0) {
    return take_captures({from, "court", quiet_s}, data, store, {SUBPIXEL_FAKE_WORKER, 1, {}, {}});
  }
};

TEST_F(WatchFolder, CapturesAreTakenOnceAndTagged) {
  const server::DataFolder data_folder(data(), server::DataFolder::Claim::night);
  Store store(data_folder.store());
  leave("a.spcap", {{"frames", 1}, {"title", "a"}});
  leave("b.spcap", {{"frames", 1}, {"title", "b"}});
  leave("c.part", {{"frames", 1}, {"title", "c"}});
  std::ofstream(folder() / "drops" / "bad.spcap") << "no capture";
  std::filesystem::create_symlink("/etc/passwd", folder() / "drops" / "link.spcap");
  EXPECT_TRUE(take(data_folder, store, folder() / "drops", 3600).empty()) << "still being written";
  const std::vector<std::string> lines = take(data_folder, store, folder() / "drops");
  EXPECT_EQ(lines.size(), 3u);
  EXPECT_EQ(std::ranges::count_if(lines, [](const auto& line) { return line.find("not taken") != line.npos; }), 1);
  EXPECT_EQ(store.captures_with_tag("court").size(), 2u);
  EXPECT_EQ(take(data_folder, store, folder() / "drops").size(), 1u) << "what is there is not taken again";
  EXPECT_THROW(take(data_folder, store, folder() / "nowhere"), InputError);
}

TEST_F(WatchFolder, ATagKeepsItsNewest) {
  const server::DataFolder data_folder(data(), server::DataFolder::Claim::night);
  Store store(data_folder.store());
  for (int i = 0; i < 4; ++i) {
    leave("c.spcap", {{"frames", 1}, {"title", std::to_string(i)}});
    ASSERT_EQ(take(data_folder, store, folder() / "drops").size(), 1u);
    std::this_thread::sleep_for(std::chrono::milliseconds(3));  // their times differ in ms
  }
  const std::vector<server::CaptureRecord> before = store.captures_with_tag("court");
  ASSERT_EQ(before.size(), 4u);
  EXPECT_TRUE(keep_tag_limits({"court", 4, 0}, data_folder, store).empty());
  EXPECT_EQ(keep_tag_limits({"court", 3, 0}, data_folder, store).size(), 1u);
  EXPECT_EQ(store.captures_with_tag("court").size(), 3u);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(data_folder.captures()), {}), 3);
  // Another tag keeps a capture.
  for (const server::CaptureRecord& each : store.captures_with_tag("court"))
    store.set_tags(each.hash, {"court", "kept"});
  EXPECT_EQ(keep_tag_limits({"court", 0, 1}, data_folder, store).size(), 2u) << "the newest stays, however large";
  ASSERT_EQ(store.captures_with_tag("court").size(), 1u);
  EXPECT_EQ(store.captures_with_tag("court")[0].title, "3");
  EXPECT_EQ(store.captures_with_tag("kept").size(), 3u);
}

}  // namespace
}  // namespace subpixel::tests
