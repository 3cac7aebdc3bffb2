#include "scenes/import/asset_source.hpp"

#include <minizip/unzip.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <set>
#include <system_error>

#include "base/error.hpp"
#include "scenes/import/statements.hpp"
#include "scenes/import/text.hpp"

namespace subpixel::capture {
namespace {

void require_size(std::uint64_t bytes, const std::string& where) {
  if (bytes > kMaxAssetBytes) {
    throw InputError("can't read the file", "larger than " + std::to_string(kMaxAssetBytes) + " bytes", where);
  }
}

class Folder final : public AssetSource {
 public:
  explicit Folder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::optional<std::vector<std::byte>> read(const std::string& name) const override {
    const std::filesystem::path path = folder_ / normal_name(name);
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) return std::nullopt;
    const std::uint64_t size = std::filesystem::file_size(path, error);
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
    if (error || !file) throw InputError("can't read the file", "it can't be opened", path.string());
    require_size(size, path.string());
    std::vector<std::byte> bytes(size);
    if (std::fread(bytes.data(), 1, size, file.get()) != size) {
      throw InputError("can't read the file", "it ends early", path.string());
    }
    return bytes;
  }

  bool contains(const std::string& name) const override {
    std::error_code error;
    return std::filesystem::is_regular_file(folder_ / normal_name(name), error);
  }

  std::optional<std::string> find(const std::string& name) const override {
    if (contains(name)) return normal_name(name);
    std::filesystem::path found;
    for (const std::filesystem::path& component : std::filesystem::path(normal_name(name))) {
      std::error_code error;
      if (std::filesystem::exists(folder_ / found / component, error)) {
        found /= component;
      } else if (const std::optional<std::string> other = in_other_case(folder_ / found, component.string())) {
        found /= *other;
      } else {
        return std::nullopt;
      }
    }
    return contains(found.string()) ? std::optional(found.string()) : std::nullopt;
  }

  std::string describe(const std::string& name) const override { return (folder_ / normal_name(name)).string(); }

 private:
  // The first by name, so that the order of the folder's entries does not matter.
  static std::optional<std::string> in_other_case(const std::filesystem::path& folder, const std::string& name) {
    std::optional<std::string> found;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
      std::string candidate = entry.path().filename().string();
      if (lower_case(candidate) != lower_case(name) || (found && *found < candidate)) continue;
      found = std::move(candidate);
    }
    return found;
  }

  std::filesystem::path folder_;
};

class Archive final : public AssetSource {
 public:
  explicit Archive(std::filesystem::path path) : path_(std::move(path)), zip_(unzOpen64(path_.c_str()), &unzClose) {
    if (!zip_) {
      std::error_code error;
      const bool there = std::filesystem::exists(path_, error);
      throw InputError("can't open the archive", there ? "it is no zip archive" : "there is no such file",
                       path_.string());
    }
    for (int status = unzGoToFirstFile(zip_.get()); status == UNZ_OK; status = unzGoToNextFile(zip_.get())) {
      char name[1024] = {};
      unz64_file_pos position{};
      unzGetCurrentFileInfo64(zip_.get(), nullptr, name, sizeof name - 1, nullptr, 0, nullptr, 0);
      unzGetFilePos64(zip_.get(), &position);
      members_.emplace(normal_name(name), position);
    }
  }

  std::optional<std::vector<std::byte>> read(const std::string& name) const override {
    const auto member = members_.find(normal_name(name));
    if (member == members_.end()) return std::nullopt;
    const std::string where = describe(name);
    unz64_file_pos position = member->second;
    unz_file_info64 info{};
    if (unzGoToFilePos64(zip_.get(), &position) != UNZ_OK ||
        unzGetCurrentFileInfo64(zip_.get(), &info, nullptr, 0, nullptr, 0, nullptr, 0) != UNZ_OK ||
        unzOpenCurrentFile(zip_.get()) != UNZ_OK) {
      throw InputError("can't read the archive's member", "the archive is damaged", where);
    }
    require_size(info.uncompressed_size, where);
    std::vector<std::byte> bytes(info.uncompressed_size);
    std::size_t at = 0;
    int got = 1;
    while (at < bytes.size() && got > 0) {
      constexpr std::size_t kBlock = std::size_t{1} << 24;
      got =
          unzReadCurrentFile(zip_.get(), bytes.data() + at, static_cast<unsigned>(std::min(kBlock, bytes.size() - at)));
      if (got > 0) at += static_cast<std::size_t>(got);
    }
    // Closing verifies the member's CRC once all of it was read.
    if (unzCloseCurrentFile(zip_.get()) != UNZ_OK || at != bytes.size()) {
      throw InputError("can't read the archive's member", "the archive is damaged", where);
    }
    return bytes;
  }

  bool contains(const std::string& name) const override { return members_.contains(normal_name(name)); }

  std::optional<std::string> find(const std::string& name) const override {
    if (contains(name)) return normal_name(name);
    const std::string wanted = lower_case(normal_name(name));
    for (const auto& [member, position] : members_) {
      if (lower_case(member) == wanted) return member;
    }
    return std::nullopt;
  }

  std::string describe(const std::string& name) const override { return path_.string() + ", member " + name; }

 private:
  std::filesystem::path path_;
  std::unique_ptr<void, int (*)(unzFile)> zip_;
  std::map<std::string, unz64_file_pos> members_;
};

constexpr const char* kRefused = "the archive is refused";
constexpr std::size_t kMaxMembers = 10'000, kMaxNameBytes = 1000;
constexpr std::uint64_t kMaxArchiveBytes = std::uint64_t{2} << 30;  // of all members, decompressed
// Deflate makes at most 1032 bytes of one; files that someone made reach a tenth of that, small ones aside.
constexpr std::uint64_t kMaxInflation = 200, kSmallBytes = std::uint64_t{16} << 20;
constexpr unsigned kMadeOnUnix = 3, kFileTypeBits = 0170000, kSymbolicLink = 0120000;  // of the zip format's appendix

struct Member {
  std::string name;
  unz_file_info64 info{};
};

std::vector<Member> list_members(const std::filesystem::path& archive) {
  const std::unique_ptr<void, int (*)(unzFile)> zip(unzOpen64(archive.c_str()), &unzClose);
  if (!zip) throw InputError(kRefused, "it is no zip archive", archive.string());
  std::vector<Member> members;
  int status = unzGoToFirstFile(zip.get());
  for (; status == UNZ_OK; status = unzGoToNextFile(zip.get())) {
    if (members.size() == kMaxMembers) {
      throw InputError(kRefused, "it has more than " + std::to_string(kMaxMembers) + " members", archive.string());
    }
    Member member;
    std::string name(kMaxNameBytes + 1, '\0');
    if (unzGetCurrentFileInfo64(zip.get(), &member.info, name.data(), static_cast<uLong>(name.size()), nullptr, 0,
                                nullptr, 0) != UNZ_OK) {
      throw InputError(kRefused, "it is damaged", archive.string());
    }
    name.resize(std::min<std::size_t>(member.info.size_filename, name.size()));
    member.name = std::move(name);
    members.push_back(std::move(member));
  }
  // An archive without members has no first one.
  if (status != UNZ_END_OF_LIST_OF_FILE && !members.empty()) {
    throw InputError(kRefused, "it is damaged", archive.string());
  }
  return members;
}

// Why a member is not taken, empty when it is.
std::string objection(const Member& member) {
  if (member.name.size() > kMaxNameBytes) return "its name is too long";
  if (member.name.find('\0') != std::string::npos) return "its name has a zero byte";
  const std::string name = normal_name(member.name);
  if (name.starts_with("/") || (name.size() > 1 && name[1] == ':')) return "its name is absolute";
  if (name == ".." || name.starts_with("../")) return "its name leads out of the archive";
  if (member.info.version >> 8 == kMadeOnUnix && ((member.info.external_fa >> 16) & kFileTypeBits) == kSymbolicLink) {
    return "it is a symbolic link";
  }
  if ((member.info.flag & 1) != 0) return "it is encrypted";
  if (member.info.uncompressed_size > kSmallBytes &&
      member.info.uncompressed_size / kMaxInflation > member.info.compressed_size) {
    return "it inflates to more than " + std::to_string(kMaxInflation) + " times its size";
  }
  return "";
}

bool is_model(const std::string& name) {
  const std::filesystem::path path(name);
  const std::string extension = lower_case(path.extension().string());
  // macOS adds files of attributes, "__MACOSX/._chair.obj".
  const bool is_attribute = path.filename().string().starts_with("._");
  return !is_attribute && (extension == ".gltf" || extension == ".glb" || extension == ".obj");
}

std::string choose_model(const std::vector<std::string>& names, const std::filesystem::path& archive) {
  std::vector<std::string> models;
  std::ptrdiff_t least = 0;
  for (const std::string& name : names) {
    if (!is_model(name)) continue;
    const std::ptrdiff_t depth = std::count(name.begin(), name.end(), '/');
    if (models.empty() || depth < least) models.clear();
    if (models.empty()) least = depth;
    if (depth == least) models.push_back(name);
  }
  if (models.empty()) throw InputError("can't import the archive", "it has no .gltf, .glb or .obj", archive.string());
  if (models.size() > 1) {
    throw InputError("can't import the archive",
                     "it has several models, among them " + in_quotes(models[0]) + " and " + in_quotes(models[1]),
                     archive.string());
  }
  return models[0];
}

}  // namespace

ModelArchive open_model_archive(const std::filesystem::path& archive) {
  std::vector<std::string> names;
  std::set<std::string> known;
  std::uint64_t bytes = 0;
  for (const Member& member : list_members(archive)) {
    const std::string where = archive.string() + ", member " + member.name.substr(0, kMaxNameBytes);
    std::string reason = objection(member);
    if (reason.empty() && !known.insert(normal_name(member.name)).second) reason = "it is there twice";
    if (reason.empty() && member.info.uncompressed_size > kMaxArchiveBytes - bytes) {
      reason = "with it the members are larger than " + std::to_string(kMaxArchiveBytes) + " bytes";
    }
    if (!reason.empty()) throw InputError(kRefused, reason, where);
    bytes += member.info.uncompressed_size;
    if (!member.name.ends_with('/')) names.push_back(normal_name(member.name));
  }
  std::string model = choose_model(names, archive);
  return {open_archive(archive), std::move(model)};
}

std::unique_ptr<AssetSource> open_folder(const std::filesystem::path& folder) {
  return std::make_unique<Folder>(folder);
}

std::unique_ptr<AssetSource> open_archive(const std::filesystem::path& archive) {
  return std::make_unique<Archive>(archive);
}

std::optional<std::string> find_beside(const AssetSource& source, const std::vector<std::string>& folders,
                                       const std::string& name) {
  std::string bare = name;
  if (bare.size() >= 2 && bare.front() == '"' && bare.back() == '"') bare = bare.substr(1, bare.size() - 2);
  if (bare.empty()) return std::nullopt;
  const auto in_folders = [&](const std::string& spelling) -> std::optional<std::string> {
    for (const std::string& folder : folders) {
      const std::filesystem::path path = std::filesystem::path(folder) / normal_name(spelling);
      if (std::optional<std::string> found = source.find(path.generic_string())) return found;
    }
    return std::nullopt;
  };
  for (const std::string& spelling : {bare, to_utf8(bare)}) {
    if (std::optional<std::string> found = in_folders(spelling)) return found;
  }
  const std::string last = std::filesystem::path(normal_name(bare)).filename().string();
  if (last.empty()) return std::nullopt;
  for (const std::string& spelling : {last, to_utf8(last)}) {
    if (std::optional<std::string> found = in_folders(spelling)) return found;
  }
  return std::nullopt;
}

std::string normal_name(std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  return std::filesystem::path(name).lexically_normal().generic_string();
}

}  // namespace subpixel::capture
