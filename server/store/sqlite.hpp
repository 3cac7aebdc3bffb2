// SQLite with RAII: a connection, a statement, a transaction. No SQL of the service in here; that is store.cpp.
#pragma once

#include <sqlite3.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace subpixel::server {

// A failed SQLite call. What failed tells what users can mend (no room, no right to write, another process in the way)
// from a file or disk that is broken and from a statement that is wrong, which is ours.
class SqliteError : public std::runtime_error {
 public:
  enum class Cause { disk_full, read_only, busy, damaged, disk, ours };
  SqliteError(sqlite3* connection, int code);
  // What is not SQLite's own part of the store went wrong.
  SqliteError(Cause cause, const std::string& what) : std::runtime_error(what), cause_(cause) {}
  Cause cause() const { return cause_; }
  bool disk_full() const { return cause_ == Cause::disk_full; }
  bool is_ours() const { return cause_ == Cause::ours; }

 private:
  Cause cause_;
};

class Connection {
 public:
  // Opens or creates the file: WAL, foreign keys on, synchronous FULL, 10 s of waiting for another writer.
  explicit Connection(const std::filesystem::path& file);
  sqlite3* handle() const { return handle_.get(); }
  // Runs statements that return nothing. Throws SqliteError.
  void execute(const std::string& sql) const;
  std::int64_t last_insert_id() const { return sqlite3_last_insert_rowid(handle()); }
  std::int64_t changes() const { return sqlite3_changes64(handle()); }

 private:
  struct Close {
    void operator()(sqlite3* connection) const { sqlite3_close_v2(connection); }
  };
  std::unique_ptr<sqlite3, Close> handle_;
};

// A prepared statement. Parameters are bound in the order of the calls of `bind`; columns are read in the same way.
class Statement {
 public:
  Statement(const Connection& connection, std::string_view sql);

  // Text and blobs must outlive the statement's steps.
  Statement& bind(std::int64_t value);
  Statement& bind(double value);
  Statement& bind(std::string_view text);
  Statement& bind(std::span<const std::byte> blob);
  Statement& bind(std::nullptr_t);
  template <typename T>
  Statement& bind(const std::optional<T>& value) {
    return value ? bind(*value) : bind(nullptr);
  }

  // True while there is a row. Throws SqliteError.
  bool step();
  // Steps a statement that returns no rows.
  void run();

  // The next column of the current row.
  std::int64_t integer();
  double real();
  std::string text();  // NULL is empty
  std::optional<std::string> optional_text();
  std::string blob();

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  void check(int code) const;

  sqlite3* connection_;
  std::unique_ptr<sqlite3_stmt, Finalize> handle_;
  int next_parameter_ = 1;
  int next_column_ = 0;
};

// A blob that is read in pieces, so that it need not fit into memory.
class BlobReader {
 public:
  BlobReader(const Connection& connection, const char* table, const char* column, std::int64_t row);
  // Fills `to` with the bytes from `offset` on, which must be there. Throws SqliteError.
  void read(std::span<char> to, std::uint64_t offset) const;

 private:
  struct Close {
    void operator()(sqlite3_blob* blob) const { sqlite3_blob_close(blob); }
  };
  sqlite3* connection_;
  std::unique_ptr<sqlite3_blob, Close> handle_;
};

// Writes the whole of a database, as it is at one moment, to the new file `to`; others may write to it meanwhile. The
// copy is on the disk then. Throws SqliteError.
void copy_database(const Connection& from, const std::filesystem::path& to);

// Takes the write lock at once, so that what it reads can't change before it writes. Rolls back unless committed.
class Transaction {
 public:
  explicit Transaction(const Connection& connection);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  const Connection& connection_;
  bool open_ = true;
};

}  // namespace subpixel::server
