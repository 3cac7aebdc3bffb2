// Other people's files in: scene files by assimp, and scenes described in JSON.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

struct ImportOptions {
  // "" : the camera of the file or description, else an orbit; "orbit": around the whole model, a quarter of a degree
  // a frame; anything else: a camera file (docs/scenes.md).
  std::string camera{};
  std::optional<std::uint32_t> frames{};           // 10 where the file does not say
  std::optional<std::uint32_t> width{}, height{};  // pixels; 1280 x 720 where the file does not say
  // Where archives and models of a description are looked for, after its own folder. Empty: the folders of the
  // environment variable SUBPIXEL_ASSETS (separated by ':'), else /usr/share/sweethome3d/furniture, where Debian's
  // package sweethome3d-furniture puts its archives.
  std::vector<std::filesystem::path> asset_folders{};
  std::function<void(const std::string&)> progress{};  // one line for each model read
};

// The capture of a model file (glTF, GLB, OBJ, and what else assimp reads), of the one glTF or OBJ in a .zip, or of a
// scene description (.json). Throws UsageError for options out of range and for .rdc files, which `subpixel import` has
// another reader for; InputError naming what is missing, damaged or wrong.
Capture import_file(const std::filesystem::path& path, const ImportOptions& options = {});

}  // namespace subpixel::capture
