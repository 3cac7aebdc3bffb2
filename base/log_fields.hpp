// What a thread is busy with, for its lines of the log: the request it answers, the run it works on.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace subpixel {

using LogFields = std::vector<std::pair<std::string, std::string>>;

// Of this thread, oldest first.
inline LogFields& log_fields() {
  thread_local LogFields fields;
  return fields;
}

// A field of this thread's log lines for as long as it lives.
class LogField {
 public:
  LogField(std::string name, std::string value) { log_fields().emplace_back(std::move(name), std::move(value)); }
  ~LogField() { log_fields().pop_back(); }
  LogField(const LogField&) = delete;
  LogField& operator=(const LogField&) = delete;
};

}  // namespace subpixel
