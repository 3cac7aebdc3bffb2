// Who may do what: tokens, as a bearer header or as the cookie of the page's sign-in form, and how often one may be
// guessed.
#pragma once

#include <httplib.h>

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "server/store/tokens.hpp"

namespace subpixel::server {

constexpr const char* kTokenCookie = "subpixel_token";

class Access {
 public:
  // `store` outlives this. Where no token is required everybody may do everything.
  Access(bool required, Store& store) : required_(required), tokens_(store) {}

  bool required() const { return required_; }
  TokenStore& tokens() { return tokens_; }

  // Whose request it is; nothing where no token is required. Throws HttpError 401 without a token that is in force, 403
  // for one whose right is less, 429 for an address that has sent too many wrong ones.
  std::optional<TokenRecord> admit(const httplib::Request& request, Right needed);
  // The same of a token that was typed in.
  TokenRecord sign_in(const httplib::Request& request, const std::string& token);

 private:
  using Clock = std::chrono::steady_clock;
  struct Failures {
    std::uint32_t count = 0;
    Clock::time_point since;
  };
  TokenRecord look_up(const httplib::Request& request, const std::string& token);

  const bool required_;
  TokenStore tokens_;
  std::mutex mutex_;
  std::map<std::string, Failures> failures_;  // by address
};

}  // namespace subpixel::server
