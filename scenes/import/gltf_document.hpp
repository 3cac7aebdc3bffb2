// The JSON document of a glTF 2.0 file, its buffers and its accessors' values. Nothing in the file is trusted: every
// number is checked before it is used, and errors name file, element and value. Sections are those of the glTF 2.0
// specification.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/import/asset_source.hpp"

namespace subpixel::capture {

// A value of the document with its place in it ("meshes[0].primitives[1]"), for messages.
class GltfElement {
 public:
  // `value` and `file` must outlive this.
  GltfElement(const nlohmann::json& value, const std::string& file, std::string path)
      : value_(&value), file_(&file), path_(std::move(path)) {}

  const std::string& path() const { return path_; }
  const nlohmann::json& raw() const { return *value_; }

  bool has(const char* key) const { return value_->is_object() && value_->contains(key); }
  GltfElement member(const char* key) const;               // required
  std::optional<GltfElement> find(const char* key) const;  // absent members are nothing
  std::optional<GltfElement> extension(const char* name) const;
  std::size_t size() const;  // of an array
  GltfElement element(std::size_t i) const;
  std::vector<GltfElement> elements(const char* key) const;  // empty where the member is absent

  // Throw InputError for what is missing without a fallback, of another type, or out of range.
  double number(const char* key, std::optional<double> fallback = {}) const;
  double number_between(const char* key, double low, double high, std::optional<double> fallback = {}) const;
  std::uint64_t whole(const char* key, std::optional<std::uint64_t> fallback = {}) const;
  std::size_t index(const char* key, std::size_t count) const;  // below `count`
  std::optional<std::size_t> find_index(const char* key, std::size_t count) const;
  bool flag(const char* key, bool fallback) const;
  std::string text(const char* key, std::optional<std::string> fallback = {}) const;
  std::vector<double> numbers(const char* key, std::size_t count) const;
  std::size_t as_index(std::size_t count) const;  // of this value itself
  std::string as_text() const;

  [[noreturn]] void fail(const std::string& why) const;

 private:
  const nlohmann::json* value_;
  const std::string* file_;
  std::string path_;
};

// An accessor's elements as numbers, components of one element side by side; normalised integers are in 0..1 or -1..1.
struct GltfValues {
  std::size_t count = 0, components = 0;
  std::vector<double> numbers;

  const double* at(std::size_t i) const { return numbers.data() + i * components; }
};

class GltfDocument {
 public:
  // Reads .gltf or .glb, told apart by their first bytes. Throws InputError for anything else, other versions than 2,
  // and required extensions that are not in `supported`.
  GltfDocument(const AssetSource& source, const std::string& name, std::span<const std::string_view> supported);
  GltfDocument(const GltfDocument&) = delete;
  GltfDocument& operator=(const GltfDocument&) = delete;

  GltfElement root() const { return {json_, file_, ""}; }
  std::size_t count(const char* list) const;                    // of "nodes", "meshes", ...; 0 where there is none
  GltfElement item(const char* list, std::size_t index) const;  // index < count(list)
  const std::string& file() const { return file_; }

  // Of accessor `index`, referred to by `user`. Throws when its type is not one of `types` ("VEC3", ...; empty: any).
  GltfValues values(std::size_t index, const GltfElement& user, std::span<const std::string_view> types) const;
  std::vector<std::uint32_t> indices(std::size_t index, const GltfElement& user) const;

  // Bytes of a buffer view, decompressed where EXT_meshopt_compression has them compressed.
  std::span<const std::byte> view_bytes(std::size_t index, const GltfElement& user) const;

  // Bytes a URI of `user` stands for (data URIs, names relative to the model, percent-encoded or not), and for messages
  // where they come from. Throws when there are none.
  std::vector<std::byte> uri_bytes(const std::string& uri, const GltfElement& user) const;

  // Whether a URI names a file that should be beside the model and is not there.
  bool is_absent_file(const std::string& uri) const;

  // A file name from a URI for showing; empty for data URIs.
  static std::string uri_name(const std::string& uri);

 private:
  std::optional<std::string> file_of(const std::string& uri) const;  // in the source
  std::span<const std::byte> buffer_bytes(std::size_t index, const GltfElement& user) const;
  std::vector<std::byte> decompressed(const GltfElement& extension) const;
  void read_container(std::span<const std::byte> bytes);
  void read_json(std::string_view text);
  void require_supported(std::span<const std::string_view> supported) const;

  const AssetSource& source_;
  std::string folder_;  // of the model, inside the source
  std::string file_;    // for messages
  nlohmann::json json_;
  std::vector<std::byte> binary_chunk_;
  bool has_binary_chunk_ = false;
  mutable std::map<std::size_t, std::vector<std::byte>> buffers_, views_;  // read or decompressed at first use
};

}  // namespace subpixel::capture
