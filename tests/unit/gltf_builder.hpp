// glTF documents for tests: a JSON document with one buffer as a data URI, written to a folder of the test's own.
#pragma once

#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace subpixel::capture {

using nlohmann::json;

inline std::string base64(const std::string& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

class GltfBuilder {
 public:
  json document = {{"asset", {{"version", "2.0"}}}};

  template <typename T>
  std::size_t add_view(const std::vector<T>& values) {
    while (bytes_.size() % 4 != 0) bytes_ += '\0';
    const std::size_t offset = bytes_.size();
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    document["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", values.size() * sizeof(T)}});
    return document["bufferViews"].size() - 1;
  }

  // Accessor of a whole view of tightly packed values.
  template <typename T>
  std::size_t add(const std::string& type, const std::vector<T>& values, bool normalised = false) {
    const std::size_t components = type == "SCALAR" ? 1 : type == "MAT4" ? 16 : static_cast<std::size_t>(type[3] - '0');
    json accessor = {{"bufferView", add_view(values)},
                     {"componentType", component_type<T>()},
                     {"count", values.size() / components},
                     {"type", type}};
    if (normalised) accessor["normalized"] = true;
    return push("accessors", accessor);
  }

  std::size_t push(const char* list, const json& item) {
    document[list].push_back(item);
    return document[list].size() - 1;
  }

  // A triangle (0,0,0) (1,0,0) (0,1,0) with normals along z: its primitive, for a mesh.
  json triangle() {
    return {{"attributes",
             {{"POSITION", add<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0})},
              {"NORMAL", add<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1})}}}};
  }

  // A scene of one node that draws one mesh of these primitives.
  void draw(const json& primitives) {
    push("meshes", {{"primitives", primitives}});
    push("nodes", {{"mesh", document["meshes"].size() - 1}});
    document["scenes"] = json::array({{{"nodes", json::array({document["nodes"].size() - 1})}}});
  }

  const std::string& bytes() const { return bytes_; }

  std::string text() const {
    json whole = document;
    if (!bytes_.empty()) {
      whole["buffers"] = json::array(
          {{{"byteLength", bytes_.size()}, {"uri", "data:application/octet-stream;base64," + base64(bytes_)}}});
    }
    return whole.dump();
  }

  std::string glb() const {
    json whole = document;
    std::string binary = bytes_;
    if (!binary.empty()) whole["buffers"] = json::array({{{"byteLength", binary.size()}}});
    std::string text = whole.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4);
    std::string file = "glTF";
    const auto put = [&](std::size_t value) {
      for (int i = 0; i < 4; ++i) file += static_cast<char>(value >> (8 * i) & 0xff);
    };
    put(2);
    put(12 + 8 + text.size() + 8 + binary.size());
    put(text.size());
    file += "JSON" + text;
    put(binary.size());
    file += std::string("BIN\0", 4) + binary;
    return file;
  }

 private:
  template <typename T>
  static int component_type() {
    if constexpr (std::is_same_v<T, std::int8_t>) return 5120;
    if constexpr (std::is_same_v<T, std::uint8_t>) return 5121;
    if constexpr (std::is_same_v<T, std::int16_t>) return 5122;
    if constexpr (std::is_same_v<T, std::uint16_t>) return 5123;
    if constexpr (std::is_same_v<T, std::uint32_t>) return 5125;
    return 5126;
  }

  std::string bytes_;
};

// A folder that goes away with the test.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "subpixel-gltf.XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() { std::filesystem::remove_all(path_); }

  std::filesystem::path write(const std::string& name, const std::string& content) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name, std::ios::binary) << content;
    return path_ / name;
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace subpixel::capture
