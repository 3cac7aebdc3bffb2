// Runs the `subpixel` binary as a user would and keeps what it said.
#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace subpixel::tests {

struct Finished {
  int code = -1;  // exit code, or -1 when a signal ended it
  std::string out, error;
};

// `arguments` and `environment` go through the shell; `limits` is a shell prefix such as "ulimit -f 1; ".
inline Finished run_binary(const std::string& arguments, const std::filesystem::path& folder,
                           const std::string& environment = "", const std::string& limits = "") {
  const std::string out = (folder / "stdout").string(), error = (folder / "stderr").string();
  const std::string command = limits + "cd '" + folder.string() + "' && " + environment + " '" SUBPIXEL_BINARY "' " +
                              arguments + " >'" + out + "' 2>'" + error + "'";
  const int status = std::system(command.c_str());
  const auto text = [](const std::string& path) {
    std::stringstream content;
    content << std::ifstream(path).rdbuf();
    return content.str();
  };
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text(out), text(error)};
}

}  // namespace subpixel::tests
