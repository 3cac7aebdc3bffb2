// Tokens of those who may call the service. A token is "spx_NUMBER_SECRET"; the store has the hash of it. Safe to call
// from any thread; throws SqliteError as the store does.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/store/store.hpp"

namespace subpixel::server {

// Each may do what those before it may.
enum class Right { none, read, submit, approve, admin };
std::string_view to_text(Right right);
// Throws UsageError naming the rights there are.
Right right_from_text(std::string_view text);

struct TokenRecord {
  std::int64_t id = 0;
  std::string name;
  Right right = Right::read;
  std::optional<std::uint64_t> quota_bytes;  // of all captures sent with it
  std::uint64_t uploaded_bytes = 0;
  std::string created_utc, expires_utc, revoked_utc;  // the last two empty until they are
};

class TokenStore {
 public:
  // `store` must outlive this.
  explicit TokenStore(Store& store) : store_(store) {}

  // Returns the token itself, which nothing can tell again. Throws UsageError when a token that is not revoked has the
  // name, or the name is not 1 to 60 printable bytes.
  std::string add(const std::string& name, Right right, std::optional<std::uint64_t> quota_bytes,
                  std::optional<std::uint32_t> days);
  // False when none of that name is in force.
  bool revoke(std::string_view name);
  std::vector<TokenRecord> list() const;
  // Whose token this is; nothing for one that is not in force, or never was. Takes the same time whatever is wrong.
  std::optional<TokenRecord> find(std::string_view token) const;
  // Counts an upload against the quota; false, counting nothing, when it would be above.
  bool charge(std::int64_t id, std::uint64_t bytes);
  void refund(std::int64_t id, std::uint64_t bytes);

 private:
  Store& store_;
};

}  // namespace subpixel::server
