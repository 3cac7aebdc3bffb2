#include "server/store/tokens.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/rand.h>
#include <openssl/sha.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <span>
#include <stdexcept>

#include "base/error.hpp"
#include "base/numbers.hpp"
#include "base/printable.hpp"
#include "server/store/store_access.hpp"

namespace subpixel::server {
namespace {

constexpr std::string_view kPrefix = "spx_";
constexpr std::size_t kSecretBytes = 32, kMaxNameBytes = 60;
constexpr std::array<std::string_view, 5> kRights{"none", "read", "submit", "approve", "admin"};

using Hash = std::array<unsigned char, SHA256_DIGEST_LENGTH>;

Hash hash_of(std::string_view token) {
  Hash hash{};
  SHA256(reinterpret_cast<const unsigned char*>(token.data()), token.size(), hash.data());
  return hash;
}

// The number in a token, -1 for what has not the form of one.
std::int64_t number_of(std::string_view token) {
  if (!token.starts_with(kPrefix)) return -1;
  token.remove_prefix(kPrefix.size());
  return parse_number<std::int64_t>(token.substr(0, token.find('_'))).value_or(-1);
}

constexpr std::string_view kColumns =
    "SELECT id, name, rights, quota_bytes, uploaded_bytes, created_utc, expires_utc, revoked_utc, hash FROM tokens ";

TokenRecord read_token(Statement& row) {
  TokenRecord token;
  token.id = row.integer();
  token.name = row.text();
  token.right = right_from_text(row.text());
  if (const std::optional<std::string> quota = row.optional_text()) token.quota_bytes = std::stoull(*quota);
  token.uploaded_bytes = static_cast<std::uint64_t>(row.integer());
  token.created_utc = row.text();
  token.expires_utc = row.text();
  token.revoked_utc = row.text();
  return token;
}

}  // namespace

std::string_view to_text(Right right) {
  return kRights[static_cast<std::size_t>(right)];
}

Right right_from_text(std::string_view text) {
  const auto found = std::find(kRights.begin() + 1, kRights.end(), text);
  if (found == kRights.end()) {
    throw UsageError("token", "expected read, submit, approve or admin", printable(text, 40));
  }
  return static_cast<Right>(found - kRights.begin());
}

std::string TokenStore::add(const std::string& name, Right right, std::optional<std::uint64_t> quota_bytes,
                            std::optional<std::uint32_t> days) {
  if (name.empty() || printable(name, kMaxNameBytes) != name) {
    throw UsageError("token", fmt::format("expected a name of 1 to {} printable bytes", kMaxNameBytes),
                     printable(name, kMaxNameBytes));
  }
  std::array<unsigned char, kSecretBytes> secret{};
  if (RAND_bytes(secret.data(), static_cast<int>(secret.size())) != 1) {
    throw std::runtime_error("no random numbers for a token");
  }
  const std::string now = utc_now();
  std::optional<std::string> expires;
  if (days) {
    const auto then = std::chrono::system_clock::now() + std::chrono::days(*days);
    expires = fmt::format("{:%Y-%m-%dT%H:%M:%S}.000Z", fmt::gmtime(std::chrono::system_clock::to_time_t(then)));
  }
  std::optional<std::int64_t> quota;
  if (quota_bytes) quota = static_cast<std::int64_t>(*quota_bytes);

  const Store::WriteLease writer = store_.write();
  Transaction transaction(writer.connection());
  {
    Statement taken(writer.connection(), "SELECT 1 FROM tokens WHERE name = ? AND revoked_utc IS NULL");
    if (taken.bind(name).step()) throw UsageError("token", "there is one of this name; revoke it first", name);
  }
  // The number is a part of the token, so the row comes before its hash.
  const Hash none{};
  Statement(writer.connection(),
            "INSERT INTO tokens (name, hash, rights, quota_bytes, created_utc, expires_utc) VALUES (?, ?, ?, ?, ?, ?)")
      .bind(name)
      .bind(std::as_bytes(std::span(none)))
      .bind(to_text(right))
      .bind(quota)
      .bind(now)
      .bind(expires)
      .run();
  const std::int64_t id = writer.connection().last_insert_id();
  std::string token = fmt::format("{}{}_{:02x}", kPrefix, id, fmt::join(secret, ""));
  const Hash hash = hash_of(token);
  Statement(writer.connection(), "UPDATE tokens SET hash = ? WHERE id = ?")
      .bind(std::as_bytes(std::span(hash)))
      .bind(id)
      .run();
  transaction.commit();
  return token;
}

bool TokenStore::revoke(std::string_view name) {
  const Store::WriteLease writer = store_.write();
  const std::string now = utc_now();
  Statement(writer.connection(), "UPDATE tokens SET revoked_utc = ? WHERE name = ? AND revoked_utc IS NULL")
      .bind(now)
      .bind(name)
      .run();
  return writer.connection().changes() > 0;
}

std::vector<TokenRecord> TokenStore::list() const {
  const Store::ReadLease reader = store_.read();
  Statement select(reader.connection(), std::string(kColumns) + "ORDER BY id");
  std::vector<TokenRecord> tokens;
  while (select.step()) tokens.push_back(read_token(select));
  return tokens;
}

std::optional<TokenRecord> TokenStore::find(std::string_view token) const {
  const Hash given = hash_of(token);
  Hash stored{};  // of no token that is known
  std::optional<TokenRecord> record;
  {
    const Store::ReadLease reader = store_.read();
    Statement select(reader.connection(), std::string(kColumns) + "WHERE id = ?");
    select.bind(number_of(token));
    if (select.step()) {
      record = read_token(select);
      const std::string hash = select.blob();
      std::copy_n(hash.begin(), std::min(hash.size(), stored.size()), stored.begin());
    }
  }
  const bool same = CRYPTO_memcmp(given.data(), stored.data(), given.size()) == 0;
  if (!record || !same || !record->revoked_utc.empty()) return std::nullopt;
  if (!record->expires_utc.empty() && record->expires_utc <= utc_now()) return std::nullopt;
  return record;
}

bool TokenStore::charge(std::int64_t id, std::uint64_t bytes) {
  const Store::WriteLease writer = store_.write();
  Statement(writer.connection(),
            "UPDATE tokens SET uploaded_bytes = uploaded_bytes + ?1 WHERE id = ?2 AND (quota_bytes IS NULL OR "
            "uploaded_bytes + ?1 <= quota_bytes)")
      .bind(static_cast<std::int64_t>(bytes))
      .bind(id)
      .run();
  return writer.connection().changes() > 0;
}

void TokenStore::refund(std::int64_t id, std::uint64_t bytes) {
  const Store::WriteLease writer = store_.write();
  Statement(writer.connection(), "UPDATE tokens SET uploaded_bytes = max(0, uploaded_bytes - ?) WHERE id = ?")
      .bind(static_cast<std::int64_t>(bytes))
      .bind(id)
      .run();
}

}  // namespace subpixel::server
