// How the store's own files reach a connection for reading.
#pragma once

#include <memory>
#include <utility>

#include "server/store.hpp"

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

}  // namespace subpixel::server
