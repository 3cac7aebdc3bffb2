#include "server/store/sqlite.hpp"

#include <cmath>

namespace subpixel::server {
namespace {

SqliteError::Cause cause_of(int code) {
  using Cause = SqliteError::Cause;
  // A file-size limit or a full quota reports as an I/O error of a write, not as SQLITE_FULL.
  if (code == SQLITE_IOERR_WRITE) return Cause::disk_full;
  switch (code & 0xff) {
    case SQLITE_FULL:
      return Cause::disk_full;
    case SQLITE_READONLY:
    case SQLITE_PERM:
      return Cause::read_only;
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
    case SQLITE_PROTOCOL:
      return Cause::busy;
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return Cause::damaged;
    case SQLITE_ERROR:
    case SQLITE_INTERNAL:
    case SQLITE_CONSTRAINT:
    case SQLITE_MISMATCH:
    case SQLITE_MISUSE:
    case SQLITE_RANGE:
      return Cause::ours;
    default:
      return Cause::disk;
  }
}

}  // namespace

SqliteError::SqliteError(sqlite3* connection, int code)
    : std::runtime_error(connection != nullptr ? sqlite3_errmsg(connection) : sqlite3_errstr(code)),
      cause_(cause_of(code)) {}

Connection::Connection(const std::filesystem::path& file) {
  sqlite3* opened = nullptr;
  // Each connection is used by one thread at a time, which its owner sees to.
  constexpr int kFlags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
  const int code = sqlite3_open_v2(file.c_str(), &opened, kFlags, nullptr);
  handle_.reset(opened);
  if (code != SQLITE_OK) throw SqliteError(opened, code);
  sqlite3_extended_result_codes(opened, 1);
  sqlite3_busy_timeout(opened, 10'000);
  execute("PRAGMA journal_mode = WAL; PRAGMA foreign_keys = ON; PRAGMA synchronous = FULL;");
}

void Connection::execute(const std::string& sql) const {
  const int code = sqlite3_exec(handle(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) throw SqliteError(handle(), code);
}

Statement::Statement(const Connection& connection, std::string_view sql) : connection_(connection.handle()) {
  sqlite3_stmt* prepared = nullptr;
  const int code = sqlite3_prepare_v2(connection_, sql.data(), static_cast<int>(sql.size()), &prepared, nullptr);
  handle_.reset(prepared);
  check(code);
}

void Statement::check(int code) const {
  if (code != SQLITE_OK) throw SqliteError(connection_, code);
}

Statement& Statement::bind(std::int64_t value) {
  check(sqlite3_bind_int64(handle_.get(), next_parameter_++, value));
  return *this;
}

Statement& Statement::bind(double value) {
  if (std::isnan(value)) return bind(nullptr);
  check(sqlite3_bind_double(handle_.get(), next_parameter_++, value));
  return *this;
}

Statement& Statement::bind(std::string_view text) {
  check(sqlite3_bind_text64(handle_.get(), next_parameter_++, text.data() != nullptr ? text.data() : "", text.size(),
                            SQLITE_STATIC, SQLITE_UTF8));
  return *this;
}

Statement& Statement::bind(std::span<const std::byte> blob) {
  if (blob.empty()) {
    check(sqlite3_bind_zeroblob64(handle_.get(), next_parameter_++, 0));
  } else {
    check(sqlite3_bind_blob64(handle_.get(), next_parameter_++, blob.data(), blob.size(), SQLITE_STATIC));
  }
  return *this;
}

Statement& Statement::bind(std::nullptr_t) {
  check(sqlite3_bind_null(handle_.get(), next_parameter_++));
  return *this;
}

bool Statement::step() {
  next_column_ = 0;
  const int code = sqlite3_step(handle_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  throw SqliteError(connection_, sqlite3_extended_errcode(connection_));
}

void Statement::run() {
  while (step()) {
  }
}

std::int64_t Statement::integer() {
  return sqlite3_column_int64(handle_.get(), next_column_++);
}

double Statement::real() {
  return sqlite3_column_double(handle_.get(), next_column_++);
}

std::string Statement::text() {
  return optional_text().value_or(std::string());
}

std::optional<std::string> Statement::optional_text() {
  const int column = next_column_++;
  const unsigned char* text = sqlite3_column_text(handle_.get(), column);
  if (text == nullptr) return std::nullopt;
  return std::string(reinterpret_cast<const char*>(text),
                     static_cast<std::size_t>(sqlite3_column_bytes(handle_.get(), column)));
}

std::string Statement::blob() {
  const int column = next_column_++;
  const void* bytes = sqlite3_column_blob(handle_.get(), column);
  if (bytes == nullptr) return {};
  return std::string(static_cast<const char*>(bytes),
                     static_cast<std::size_t>(sqlite3_column_bytes(handle_.get(), column)));
}

BlobReader::BlobReader(const Connection& connection, const char* table, const char* column, std::int64_t row)
    : connection_(connection.handle()) {
  sqlite3_blob* blob = nullptr;
  const int code = sqlite3_blob_open(connection_, "main", table, column, row, 0, &blob);
  handle_.reset(blob);
  if (code != SQLITE_OK) throw SqliteError(connection_, code);
}

void BlobReader::read(std::span<char> to, std::uint64_t offset) const {
  const int code = sqlite3_blob_read(handle_.get(), to.data(), static_cast<int>(to.size()), static_cast<int>(offset));
  if (code != SQLITE_OK) throw SqliteError(connection_, code);
}

void copy_database(const Connection& from, const std::filesystem::path& to) {
  // Not a Connection: that would be in WAL mode before it has the original's page size.
  sqlite3* opened = nullptr;
  const int code = sqlite3_open_v2(to.c_str(), &opened, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
  const std::unique_ptr<sqlite3, decltype(&sqlite3_close_v2)> target(opened, &sqlite3_close_v2);
  if (code != SQLITE_OK) throw SqliteError(opened, code);
  sqlite3_extended_result_codes(opened, 1);
  sqlite3_backup* const backup = sqlite3_backup_init(opened, "main", from.handle(), "main");
  if (backup == nullptr) throw SqliteError(opened, sqlite3_extended_errcode(opened));
  // All pages in one step: between steps another process's write would start it over.
  sqlite3_backup_step(backup, -1);
  if (const int end = sqlite3_backup_finish(backup); end != SQLITE_OK) throw SqliteError(opened, end);
}

Transaction::Transaction(const Connection& connection) : connection_(connection) {
  connection_.execute("BEGIN IMMEDIATE");
}

Transaction::~Transaction() {
  // A failed rollback means SQLite has rolled back already (disk full, I/O error).
  if (open_) sqlite3_exec(connection_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::commit() {
  connection_.execute("COMMIT");
  open_ = false;
}

}  // namespace subpixel::server
