#include "cli/renderdoc_import.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string_view>

#include "base/error.hpp"
#include "base/json_document.hpp"
#include "base/python_interpreter.hpp"
#include "capture_format/reading/reader.hpp"
#include "python/embedded.hpp"

namespace subpixel::cli {
namespace {

constexpr const char* kFailed = "the RenderDoc capture can't be imported";

class Scratch {
 public:
  explicit Scratch(const std::filesystem::path& parent) {
    std::string name = (parent / "renderdoc.XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw InputError(kFailed, std::strerror(errno), parent.string());
    folder_ = name;
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
};

void unpack(const std::filesystem::path& folder) {
  const auto write = [&](const char* package, std::span<const EmbeddedFile> files) {
    std::filesystem::create_directories(folder / package);
    for (const EmbeddedFile& file : files) {
      const std::filesystem::path path = folder / package / file.path;
      std::ofstream out(path, std::ios::binary);
      out << file.content;
      if (!out.flush()) throw InputError(kFailed, "its exporter can't be written", path.string());
    }
  };
  write("subpixel_capture", python::capture_files());
  write("subpixel_renderdoc", python::renderdoc_files());
}

std::string with_variable(const char* name, const std::string& value) {
  return std::string(name) + "=" + value;
}

// This process's environment with what the exporter needs.
std::vector<std::string> environment_with(const std::filesystem::path& package, const std::filesystem::path& temporary,
                                          bool on_display) {
  std::vector<std::string> added{with_variable("PYTHONPATH", package.string()),
                                 with_variable("PYTHONDONTWRITEBYTECODE", "1"),
                                 with_variable("RENDERDOC_TEMP", temporary.string()),
                                 // Of this import alone: RenderDoc compiles the frame's shaders at each of its many
                                 // replays, and what a stranger's file makes must not be read by the next import.
                                 with_variable("MESA_SHADER_CACHE_DIR", (temporary / "mesa").string()),
                                 with_variable("MESA_SHADER_CACHE_DISABLE", "false")};
  if (!on_display) {
    added.insert(added.end(), {with_variable("DISPLAY", ""), with_variable("WAYLAND_DISPLAY", ""),
                               with_variable("LIBGL_ALWAYS_SOFTWARE", "1")});
  }
  std::vector<std::string> all = added;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text = *entry;
    const bool is_replaced = std::any_of(added.begin(), added.end(), [&](const std::string& mine) {
      return text.substr(0, text.find('=') + 1) == mine.substr(0, mine.find('=') + 1);
    });
    if (!is_replaced) all.emplace_back(text);
  }
  // Empty is not enough: RenderDoc would look for a display of that name.
  std::erase_if(all, [](const std::string& text) { return text == "DISPLAY=" || text == "WAYLAND_DISPLAY="; });
  return all;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> out;
  out.reserve(texts.size() + 1);
  for (std::string& text : texts) out.push_back(text.data());
  out.push_back(nullptr);
  return out;
}

// The lines of a child that shares this process's group, which is ended as a whole.
class Lines {
 public:
  explicit Lines(int descriptor) : file_(::fdopen(descriptor, "r")) {}
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;
  ~Lines() {
    std::free(line_);
    if (file_ != nullptr) std::fclose(file_);
  }
  std::optional<std::string> next() {
    const ssize_t size = file_ == nullptr ? -1 : ::getline(&line_, &capacity_, file_);
    if (size < 0) return std::nullopt;
    return std::string(line_, static_cast<std::size_t>(size));
  }

 private:
  std::FILE* file_;
  char* line_ = nullptr;
  std::size_t capacity_ = 0;
};

struct Ended {
  int status = 0;
  std::optional<std::string> error;  // what the exporter said
};

Ended run(std::vector<std::string> arguments, std::vector<std::string> environment) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw InputError(kFailed, std::strerror(errno), "");
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, ends[1], 1);
  pid_t child = 0;
  const int error = ::posix_spawn(&child, arguments[0].c_str(), &actions, nullptr, pointers(arguments).data(),
                                  pointers(environment).data());
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  Lines lines(ends[0]);
  if (error != 0) throw InputError(kFailed, std::strerror(error), arguments[0]);
  Ended ended;
  while (const auto line = lines.next()) {
    const std::optional<nlohmann::json> message = parse_json_line(*line);
    if (!message) continue;  // a library's own word
    if (text_or_empty(*message, "type") == "error") {
      ended.error = text_or_empty(*message, "text");
    } else {
      std::fputs(line->c_str(), stdout);
      std::fflush(stdout);
    }
  }
  ::waitpid(child, &ended.status, 0);
  return ended;
}

}  // namespace

bool is_renderdoc(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".rdc";
}

capture::Capture import_renderdoc(const std::string& in, const RenderDocOptions& options,
                                  const std::filesystem::path& scratch) {
  std::vector<std::string> inputs{in};
  inputs.insert(inputs.end(), options.more.begin(), options.more.end());
  for (const std::string& input : inputs) {
    if (!std::ifstream(input, std::ios::binary)) throw InputError(kFailed, "the file can't be opened", input);
  }
  const Scratch made(scratch);
  const std::filesystem::path package = made.folder() / "package", exported = made.folder() / "exported.spcap";
  unpack(package);
  std::vector<std::string> arguments{python_interpreter(), "-m", "subpixel_renderdoc"};
  arguments.emplace_back("--json");
  arguments.insert(arguments.end(), options.arguments.begin(), options.arguments.end());
  arguments.emplace_back("--");
  for (const std::string& input : inputs) arguments.push_back(std::filesystem::absolute(input).string());
  arguments.push_back(exported.string());

  const Ended ended = run(arguments, environment_with(package, made.folder(), options.on_display));
  if (ended.error) throw InputError(kFailed, *ended.error, "");
  // A shell between says 128 and the signal.
  const int code = WIFSIGNALED(ended.status) ? 128 + WTERMSIG(ended.status) : WEXITSTATUS(ended.status);
  if (code > 128) throw InputError(kFailed, fmt::format("RenderDoc crashed (signal {})", code - 128), in);
  if (code != 0) throw InputError(kFailed, fmt::format("its exporter ended with exit code {} and no reason", code), in);
  return capture::read_capture(exported);
}

}  // namespace subpixel::cli
