#include "tests/service/fake_worker/fake_capture.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iostream>

namespace subpixel::tests {

using nlohmann::json;

json read_fake_capture(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text;
  std::getline(file, text);  // what follows only makes the file larger
  if (!text.starts_with("FAKE ")) {
    std::cerr << "subpixel: can't read the capture: the file does not begin as one: " << path << ", byte offset 0\n";
    ::_exit(3);
  }
  return json::parse(text.substr(5));
}

std::string reached(const json& fake) {
  const int file = ::open(fake.value("reach", "").c_str(), O_RDONLY | O_CLOEXEC);
  return std::string("reach: ") + (file >= 0 ? "done" : ::strerror(errno));
}

}  // namespace subpixel::tests
