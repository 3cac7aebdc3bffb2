// The SPIR-V a device makes its pipelines from: what the build embedded, or the files of a folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace subpixel::gpu {

// The folder that the environment variable SUBPIXEL_SHADERS names; empty when it is not set.
std::filesystem::path shader_folder_of_environment();

// The file of a shader below such a folder: "a/b.frag" is in a/b.frag.spv, "a/b.frag:NAME" in a/b.frag.NAME.spv.
std::filesystem::path spirv_file(std::string_view shader);

class ShaderLibrary {
 public:
  // Of the embedded shaders when `folder` is empty. Otherwise reads from there, in place of every embedded shader, the
  // file of its name; throws InputError naming the first that is missing or no SPIR-V for its stage.
  explicit ShaderLibrary(const std::filesystem::path& folder);

  // Throws std::logic_error when there is no such shader.
  std::span<const std::uint32_t> words(std::string_view shader) const;
  bool embedded() const { return files_.empty(); }

 private:
  std::map<std::string, std::vector<std::uint32_t>, std::less<>> files_;
};

}  // namespace subpixel::gpu
