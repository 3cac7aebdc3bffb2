// How the files with SQL reach a connection.
#pragma once

#include <memory>
#include <utility>

#include "server/store/store.hpp"

namespace subpixel::server {

// A read connection on loan; goes back to the store's idle ones.
class Store::ReadLease {
 public:
  ReadLease(const Store& store, std::unique_ptr<Connection> connection)
      : store_(store), connection_(std::move(connection)) {}
  ~ReadLease() {
    const std::lock_guard lock(store_.readers_mutex_);
    store_.idle_readers_.push_back(std::move(connection_));
  }
  ReadLease(const ReadLease&) = delete;
  ReadLease& operator=(const ReadLease&) = delete;
  const Connection& connection() const { return *connection_; }

 private:
  const Store& store_;
  std::unique_ptr<Connection> connection_;
};

class Store::WriteLease {
 public:
  explicit WriteLease(Store& store) : lock_(store.write_mutex_), connection_(store.writer_) {}
  const Connection& connection() const { return connection_; }

 private:
  std::unique_lock<std::mutex> lock_;
  const Connection& connection_;
};

}  // namespace subpixel::server
