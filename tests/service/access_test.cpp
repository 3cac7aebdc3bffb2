// Tokens: who may do what, what is counted, what is kept of approvals, and the form's cookie.
#include <fmt/format.h>

#include "base/error.hpp"
#include "server/nightly/night_store.hpp"
#include "server/store/tokens.hpp"
#include "tests/service/service_fixture.hpp"

namespace subpixel::tests {
namespace {

using server::Right;
using server::Store;
using server::TokenStore;

class Access : public ServiceTest {
 protected:
  void start_with_tokens() {
    server::ServiceOptions closed = options();
    closed.require_token = true;
    start(closed);
  }
  std::filesystem::path store_file() const { return folder() / "data" / "subpixel.sqlite"; }
  std::string make(const std::string& name, Right right, std::optional<std::uint64_t> quota = {},
                   std::optional<std::uint32_t> days = {}) const {
    Store store(store_file());
    return TokenStore(store).add(name, right, quota, days);
  }
  void change(const std::string& sql) const { server::Connection(store_file()).execute(sql); }
  static httplib::Headers bearer(const std::string& token) { return {{"Authorization", "Bearer " + token}}; }
  int status_of(const std::string& path, const httplib::Headers& headers) {
    const httplib::Result result = client().http().Get(path, headers);
    return result ? result->status : -1;
  }
};

TEST_F(Access, WithoutTheOptionNobodyNeedsAToken) {
  EXPECT_EQ(status_of("/api/runs", {}), 200);
  EXPECT_EQ(status_of("/api/runs", bearer("nonsense")), 200);
  EXPECT_EQ(client().get("/api/caller").at("token_required"), false);
}

// Every operation of the table, by everyone: less than its right is refused, that right is not.
TEST_F(Access, WhereOtherMachinesCanCallTokensAreTheDefault) {
  const auto status = [&](const std::vector<std::string>& options) {
    const ServiceProcess service(folder() / "process", options);
    Client other(service.port());
    const httplib::Result result = other.http().Get("/api/runs");
    return result ? result->status : -1;
  };
  EXPECT_EQ(status({"--listen", "0.0.0.0:0"}), 401);
  EXPECT_EQ(status({"--listen", "0.0.0.0:0", "--no-token"}), 200);
  EXPECT_EQ(status({"--listen", "127.0.0.1:0"}), 200);
  EXPECT_EQ(status({"--listen", "localhost:0", "--require-token"}), 401);
}

TEST_F(Access, EveryOperationAsksForItsRight) {
  start_with_tokens();
  const std::vector<std::pair<Right, std::string>> callers{{Right::none, ""},
                                                           {Right::read, make("reader", Right::read)},
                                                           {Right::submit, make("sender", Right::submit)},
                                                           {Right::approve, make("approver", Right::approve)},
                                                           {Right::admin, make("admin", Right::admin)}};
  const json description = client().get("/api/openapi.json");
  int operations = 0;
  for (const auto& [path, methods] : description.at("paths").items()) {
    for (const auto& [method, operation] : methods.items()) {
      if (operation.at("operationId") == "sign_in") continue;
      ++operations;
      std::string target;
      for (std::size_t i = 0; i < path.size(); ++i) {
        if (path[i] == '{') {
          target += path.compare(i, 6, "{hash}") == 0 ? std::string(32, '0') : "999";
          i = path.find('}', i);
        } else {
          target += path[i];
        }
      }
      const std::string needed = operation.at("x-right");
      for (const auto& [right, token] : callers) {
        SCOPED_TRACE(fmt::format("{} {} by {}", method, path, to_text(right)));
        const httplib::Headers headers = token.empty() ? httplib::Headers{} : bearer(token);
        const httplib::Result result = method == "get" ? client().http().Get(target, headers)
                                       : method == "delete"
                                           ? client().http().Delete(target, headers)
                                           : client().http().Post(target, headers, "{}", "application/json");
        ASSERT_TRUE(result);
        const bool may = needed == "none" || right >= server::right_from_text(needed);
        if (may) {
          EXPECT_TRUE(result->status != 401 && result->status != 403) << result->status << result->body;
        } else {
          error_of(result, token.empty() ? 401 : 403);
        }
      }
    }
  }
  EXPECT_GT(operations, 30);
  EXPECT_EQ(status_of("/", {}), 200) << "the page itself has no data, and asks for the token";
  EXPECT_EQ(status_of("/api/unheard-of", {}), 401);
  EXPECT_EQ(status_of("/api/unheard-of", bearer(callers[1].second)), 404);
}

TEST_F(Access, RefusedUploadsCostNoBody) {
  start_with_tokens();
  const std::string answer =
      raw_exchange(port(), "POST /api/captures HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 1000000\r\n\r\nFAKE");
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 401")) << answer;
}

TEST_F(Access, OnlyTheHashIsStored) {
  start_with_tokens();
  const std::string token = make("somebody", Right::read);
  ASSERT_EQ(token.size(), std::string("spx_1_").size() + 64);
  EXPECT_NE(token, make("somebody else", Right::read));
  stop();
  std::string bytes;
  {
    FILE* const file = std::fopen(store_file().c_str(), "rb");
    for (int c; (c = std::fgetc(file)) != EOF;) bytes += static_cast<char>(c);
    std::fclose(file);
  }
  EXPECT_NE(bytes.find("somebody"), std::string::npos);
  EXPECT_EQ(bytes.find(token.substr(6)), std::string::npos);
}

TEST_F(Access, RevokedExpiredAndAlteredTokensAreNotTaken) {
  start_with_tokens();
  const std::string good = make("good", Right::read), gone = make("gone", Right::read);
  const std::string old = make("old", Right::read, {}, 1);
  EXPECT_EQ(status_of("/api/runs", bearer(old)), 200);
  change("UPDATE tokens SET expires_utc = '2025-01-01T00:00:00.000Z' WHERE name = 'old'");
  EXPECT_EQ(status_of("/api/runs", bearer(gone)), 200);
  {
    Store store(store_file());
    EXPECT_TRUE(TokenStore(store).revoke("gone"));
    EXPECT_FALSE(TokenStore(store).revoke("gone"));
    EXPECT_THROW(TokenStore(store).add("good", Right::read, {}, {}), UsageError);
    TokenStore(store).add("gone", Right::read, {}, {});
  }
  std::string last = good, number = good;
  last.back() = last.back() == '0' ? '1' : '0';
  number.replace(0, 6, "spx_2_");
  for (const std::string& wrong : {old, gone, last, number, good + "0", good.substr(0, good.size() - 1)}) {
    EXPECT_EQ(status_of("/api/runs", bearer(wrong)), 401) << wrong;
  }
  EXPECT_EQ(status_of("/api/runs", bearer(good)), 200);
}

TEST_F(Access, GuessingIsSlowedByAddress) {
  start_with_tokens();
  const std::string good = make("good", Right::read);
  const auto from = [](const std::string& token, const std::string& address) {
    httplib::Headers headers = bearer(token);
    headers.emplace("X-Forwarded-For", "203.0.113.9, " + address);
    return headers;
  };
  for (int i = 0; i < 10; ++i) EXPECT_EQ(status_of("/api/runs", from("spx_1_guess", "192.0.2.1")), 401);
  EXPECT_EQ(status_of("/api/runs", from("spx_1_guess", "192.0.2.1")), 429);
  EXPECT_EQ(status_of("/api/runs", from(good, "192.0.2.1")), 429) << "the right one is not told from others";
  EXPECT_EQ(status_of("/api/runs", from(good, "192.0.2.2")), 200);
  EXPECT_EQ(status_of("/api/runs", bearer(good)), 200);
  EXPECT_EQ(status_of("/api/runs", {}), 401) << "no token is no guess";
}

TEST_F(Access, QuotaIsOfAllCapturesSent) {
  start_with_tokens();
  const std::string one = fake_capture({{"frames", 0}}), two = fake_capture({{"frames", 0}, {"title", "b"}});
  const httplib::Headers headers = bearer(make("sender", Right::submit, one.size() + two.size() - 1));
  const auto send = [&](const std::string& bytes) {
    return client().http().Post("/api/captures?name=a", headers, bytes, "application/octet-stream");
  };
  EXPECT_EQ(send("PK, and no capture")->status, 422);
  EXPECT_EQ(send(one)->status, 201);
  EXPECT_EQ(send(one)->status, 200) << "what is there already takes nothing";
  EXPECT_NE(error_of(send(two), 413).at("why").get<std::string>().find("quota"), std::string::npos);
  const json caller = json::parse(client().http().Get("/api/caller", headers)->body);
  EXPECT_EQ(caller.at("uploaded_bytes"), one.size());
  EXPECT_EQ(caller.at("name"), "sender");
}

TEST_F(Access, FormsCookieStandsForTheToken) {
  start_with_tokens();
  const std::string token = make("good", Right::read);
  const auto sign_in = [&](const std::string& with, const std::string& origin) {
    return client().http().Post("/api/sign-in", {{"Origin", origin}}, json{{"token", with}}.dump(), "application/json");
  };
  const std::string own = "http://127.0.0.1:" + std::to_string(port());
  error_of(sign_in("wrong", own), 401);
  error_of(sign_in(token, "http://evil.example"), 403);
  const httplib::Result signed_in = sign_in(token, own);
  ASSERT_EQ(signed_in->status, 200) << signed_in->body;
  const std::string cookie = signed_in->get_header_value("Set-Cookie");
  EXPECT_EQ(cookie, "subpixel_token=" + token + "; Path=/; HttpOnly; SameSite=Strict");
  EXPECT_EQ(status_of("/api/runs", {{"Cookie", "a=b; subpixel_token=" + token + "; c"}}), 200);
  EXPECT_EQ(status_of("/api/runs", {{"Cookie", "xsubpixel_token=" + token}}), 401);
  const httplib::Result out = client().http().Post("/api/sign-out", "", "application/json");
  EXPECT_EQ(out->status, 204);
  EXPECT_EQ(out->get_header_value("Set-Cookie"), "subpixel_token=; Path=/; HttpOnly; SameSite=Strict; Max-Age=0");
}

TEST_F(Access, ApprovalsKeepWhoWhenAndWhy) {
  start_with_tokens();
  Store store(store_file());
  server::NightStore nights(store);
  std::vector<std::int64_t> ids;
  for (int i = 0; i < 2; ++i) {
    server::NightRecord night;
    night.name = "a";
    night.config = json::object();
    ids.push_back(nights.add(night));
    nights.finish(ids.back(), server::NightStatus::passed, "");
  }
  const httplib::Headers headers = bearer(make("Ada", Right::approve));
  const auto approve = [&](std::int64_t night, const std::string& why) {
    return client().http().Post("/api/baselines", headers, json{{"name", "a"}, {"night", night}, {"why", why}}.dump(),
                                "application/json");
  };
  EXPECT_EQ(approve(ids[0], "it looked right")->status, 200);
  EXPECT_EQ(approve(ids[1], "Mesa was updated")->status, 200);
  error_of(approve(ids[1], std::string(501, 'x')), 400);
  error_of(approve(999, "no such night"), 404);
  const auto get = [&](const std::string& path) { return json::parse(client().http().Get(path, headers)->body); };
  const json baseline = get("/api/baselines").at("baselines").at(0);
  EXPECT_EQ(baseline.at("who"), "Ada");
  EXPECT_EQ(baseline.at("why"), "Mesa was updated");
  const json approvals = get("/api/approvals?name=a").at("approvals");
  ASSERT_EQ(approvals.size(), 2u);
  EXPECT_EQ(approvals.at(0), baseline);
  EXPECT_EQ(approvals.at(1).at("night"), ids[0]);
  EXPECT_EQ(approvals.at(1).at("why"), "it looked right");
  EXPECT_TRUE(approvals.at(1).at("set_utc").get<std::string>().starts_with("20"));
}

}  // namespace
}  // namespace subpixel::tests
