// `subpixel store migrate --blobs-outside`: blobs from the store's file to files of their own, and back.
#include <fmt/format.h>

#include "base/error.hpp"
#include "base/hash.hpp"
#include "server/store/store_access.hpp"
#include "server/store/upkeep.hpp"

namespace subpixel::server {
namespace {

constexpr std::size_t kMovedAtATime = 32;  // in one transaction

struct Row {
  std::int64_t id = 0;
  std::string hash;
  std::uint64_t size = 0;
};

std::vector<Row> some_rows(const Connection& connection, const std::string& which, std::int64_t after) {
  Statement select(connection, fmt::format("SELECT rowid, hash, coalesce(outside, length(bytes)) FROM blobs WHERE "
                                           "rowid > ? AND {} ORDER BY rowid LIMIT {}",
                                           which, kMovedAtATime));
  select.bind(after);
  std::vector<Row> rows;
  while (select.step()) {
    Row row;
    row.id = select.integer();
    row.hash = select.text();
    row.size = static_cast<std::uint64_t>(select.integer());
    rows.push_back(std::move(row));
  }
  return rows;
}

// The bytes of a row, which are what its hash says.
std::string bytes_of(const Store& store, const Row& row) {
  std::optional<Blob> blob = store.blob(row.hash);
  if (!blob || content_hash_hex(std::as_bytes(std::span(blob->bytes))) != row.hash) {
    throw InputError("can't move a blob", "it is damaged; see subpixel store check", row.hash);
  }
  return std::move(blob->bytes);
}

}  // namespace

Moved place_blobs(const DataFolder& folder, std::optional<std::uint64_t> large_bytes) {
  Store store(folder.store());
  Moved moved;
  if (large_bytes) store.large_blobs().prepare();
  {
    const Store::WriteLease writer = store.write();
    if (large_bytes) {
      Statement(writer.connection(), "INSERT OR REPLACE INTO settings (name, value) VALUES ('large_blob_bytes', ?)")
          .bind(static_cast<std::int64_t>(*large_bytes))
          .run();
    } else {
      writer.connection().execute("DELETE FROM settings WHERE name = 'large_blob_bytes'");
    }
  }
  const auto each = [&](const std::string& which, const std::function<void(const std::vector<Row>&)>& move) {
    for (std::int64_t last = 0;;) {
      std::vector<Row> rows;
      {
        const Store::ReadLease reader = store.read();
        rows = some_rows(reader.connection(), which, last);
      }
      if (rows.empty()) return;
      move(rows);
      for (const Row& row : rows) moved.bytes += row.size;
      last = rows.back().id;
    }
  };
  // The bytes are in the new place, lasting, before the row says so, and leave the old one after that.
  if (large_bytes) {
    each(fmt::format("outside IS NULL AND length(bytes) >= {}", *large_bytes), [&](const std::vector<Row>& rows) {
      for (const Row& row : rows) store.large_blobs().put(row.hash, bytes_of(store, row));
      const Store::WriteLease writer = store.write();
      Transaction transaction(writer.connection());
      for (const Row& row : rows) {
        Statement(writer.connection(), "UPDATE blobs SET outside = length(bytes), bytes = x'' WHERE rowid = ?")
            .bind(row.id)
            .run();
      }
      transaction.commit();
      moved.out += rows.size();
    });
  }
  const std::string smaller = large_bytes ? fmt::format("outside < {}", *large_bytes) : "outside IS NOT NULL";
  each(smaller, [&](const std::vector<Row>& rows) {
    std::vector<std::string> hashes;
    {
      std::vector<std::string> bytes;
      bytes.reserve(rows.size());
      for (const Row& row : rows) bytes.push_back(bytes_of(store, row));
      const Store::WriteLease writer = store.write();
      Transaction transaction(writer.connection());
      for (std::size_t i = 0; i < rows.size(); ++i) {
        Statement(writer.connection(), "UPDATE blobs SET outside = NULL, bytes = ? WHERE rowid = ?")
            .bind(std::as_bytes(std::span(bytes[i])))
            .bind(rows[i].id)
            .run();
        hashes.push_back(rows[i].hash);
      }
      transaction.commit();
    }
    store.remove_outside(hashes);
    moved.in += rows.size();
  });
  return moved;
}

}  // namespace subpixel::server
