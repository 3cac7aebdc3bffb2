// Where the importer finds model, material and texture files: a folder or a zip archive (Sweet Home 3D's .sh3f is one).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace subpixel::capture {

inline constexpr std::uint64_t kMaxAssetBytes = 1ull << 30;  // of one file, decompressed

class AssetSource {
 public:
  AssetSource() = default;
  AssetSource(const AssetSource&) = delete;
  AssetSource& operator=(const AssetSource&) = delete;
  virtual ~AssetSource() = default;

  // The file's bytes, or nothing when there is none of that name. Throws InputError when it is there but larger than
  // kMaxAssetBytes or damaged.
  virtual std::optional<std::vector<std::byte>> read(const std::string& name) const = 0;
  virtual bool contains(const std::string& name) const = 0;

  // The name of the file as it is there: `name` itself, else one that differs in the case of ASCII letters alone, as
  // files from systems that know no case do; nothing when there is none.
  virtual std::optional<std::string> find(const std::string& name) const = 0;

  // For messages: where `name` was looked for.
  virtual std::string describe(const std::string& name) const = 0;
};

// Names are relative to the folder, or absolute.
std::unique_ptr<AssetSource> open_folder(const std::filesystem::path& folder);

// Names are those of the archive's members. Throws InputError when it is no zip archive.
std::unique_ptr<AssetSource> open_archive(const std::filesystem::path& archive);

// An archive that anyone may have made, and its one model: the glTF, GLB or OBJ that is least deep in its folders.
// Throws InputError naming the member that leads out of the archive, is a link, encrypted, there twice or inflates
// beyond reason, and for too many members, too many bytes and none or several models.
struct ModelArchive {
  std::unique_ptr<AssetSource> source;
  std::string model;
};
ModelArchive open_model_archive(const std::filesystem::path& archive);

// The file that a name inside a model's file means: in the first of `folders` that has it, in any case of its letters;
// names in Latin-1 as UTF-8, quotes removed; else, as for paths of other people's machines, its last part in one of
// the folders. Nothing when there is none.
std::optional<std::string> find_beside(const AssetSource& source, const std::vector<std::string>& folders,
                                       const std::string& name);

// `name` with '\' made '/', and "." and ".." resolved: file names inside models come from every system.
std::string normal_name(std::string name);

}  // namespace subpixel::capture
