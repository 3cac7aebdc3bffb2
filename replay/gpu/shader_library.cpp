#include "replay/gpu/shader_library.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>

#include "base/error.hpp"
#include "replay/gpu/spirv.hpp"
#include "shaders/embedded.hpp"

namespace subpixel::gpu {
namespace {

std::vector<std::uint32_t> read_words(const std::filesystem::path& path, std::string_view shader) {
  const auto refuse = [&](const std::string& why) { throw InputError("shader", why, path.string()); };
  std::error_code error;
  const auto bytes = std::filesystem::file_size(path, error);
  if (error) refuse("can't be read: " + error.message());
  if (bytes % 4 != 0) refuse(fmt::format("{} bytes are not whole SPIR-V words", bytes));
  std::vector<std::uint32_t> words(bytes / 4);
  std::ifstream file(path, std::ios::binary);
  if (!file.read(reinterpret_cast<char*>(words.data()), static_cast<std::streamsize>(bytes)))
    refuse("can't be read: " + std::generic_category().message(errno));
  if (const std::string fault = fault_in_spirv(words, shader); !fault.empty()) refuse(fault);
  return words;
}

}  // namespace

std::filesystem::path shader_folder_of_environment() {
  const char* const folder = std::getenv("SUBPIXEL_SHADERS");
  return folder ? folder : "";
}

std::filesystem::path spirv_file(std::string_view shader) {
  std::string file(shader);
  std::ranges::replace(file, ':', '.');
  return file + ".spv";
}

ShaderLibrary::ShaderLibrary(const std::filesystem::path& folder) {
  if (folder.empty()) return;
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error))
    throw InputError("shaders", "SUBPIXEL_SHADERS does not name a folder", folder.string());
  for (const auto& shader : shaders::all())
    files_.emplace(shader.name, read_words(folder / spirv_file(shader.name), shader.name));
}

std::span<const std::uint32_t> ShaderLibrary::words(std::string_view shader) const {
  if (!embedded()) {
    const auto found = files_.find(shader);
    if (found != files_.end()) return found->second;
  } else {
    const auto shaders = shaders::all();
    const auto found = std::ranges::find(shaders, shader, &shaders::Embedded::name);
    if (found != shaders.end()) return found->words;
  }
  throw std::logic_error(fmt::format("no such shader: {}", shader));
}

}  // namespace subpixel::gpu
