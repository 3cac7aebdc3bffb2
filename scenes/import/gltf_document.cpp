#include "scenes/import/gltf_document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "base/error.hpp"
#include "scenes/import/text.hpp"

namespace subpixel::capture {
namespace {

constexpr const char* kWhat = "can't import the model";

std::uint32_t word_at(std::span<const std::byte> bytes, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

// RFC 3986 section 2.1; a '%' that two digits don't follow stands for itself.
std::string percent_decoded(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const int high = text[i] == '%' && i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
    const int low = high >= 0 ? hex_digit(text[i + 2]) : -1;
    if (low < 0) {
      decoded += text[i];
      continue;
    }
    decoded += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return decoded;
}

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+' || c == '-') return 62;  // '-' and '_': the alphabet for URLs, RFC 4648 section 5
  if (c == '/' || c == '_') return 63;
  return -1;
}

// RFC 4648; white space and padding are skipped. Nothing for other characters.
std::optional<std::vector<std::byte>> base64_decoded(std::string_view text) {
  std::vector<std::byte> bytes;
  bytes.reserve(text.size() / 4 * 3);
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=' || c == '\n' || c == '\r' || c == ' ') continue;
    const int digit = base64_digit(c);
    if (digit < 0) return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<std::byte>(bits >> count & 0xff));
  }
  return bytes;
}

std::string shortened(std::string text) {
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return to_utf8(text);
}

}  // namespace

void GltfElement::fail(const std::string& why) const {
  throw InputError(kWhat, why, *file_ + (path_.empty() ? "" : ", " + path_));
}

std::optional<GltfElement> GltfElement::find(const char* key) const {
  if (!value_->is_object()) fail("not an object");
  const auto found = value_->find(key);
  if (found == value_->end()) return std::nullopt;
  return GltfElement(*found, *file_, path_.empty() ? key : path_ + "." + key);
}

GltfElement GltfElement::member(const char* key) const {
  std::optional<GltfElement> found = find(key);
  if (!found) fail(fmt::format("{} is missing", key));
  return *found;
}

std::optional<GltfElement> GltfElement::extension(const char* name) const {
  const std::optional<GltfElement> all = find("extensions");
  return all ? all->find(name) : std::nullopt;
}

std::size_t GltfElement::size() const {
  if (!value_->is_array()) fail("not an array");
  return value_->size();
}

GltfElement GltfElement::element(std::size_t i) const {
  return {(*value_)[i], *file_, fmt::format("{}[{}]", path_, i)};
}

std::vector<GltfElement> GltfElement::elements(const char* key) const {
  std::vector<GltfElement> result;
  const std::optional<GltfElement> list = find(key);
  const std::size_t count = list ? list->size() : 0;
  result.reserve(count);
  for (std::size_t i = 0; i < count; ++i) result.push_back(list->element(i));
  return result;
}

double GltfElement::number(const char* key, std::optional<double> fallback) const {
  const std::optional<GltfElement> found = fallback ? find(key) : member(key);
  if (!found) return *fallback;
  if (!found->raw().is_number()) found->fail("not a number");
  const double value = found->raw().get<double>();
  if (!std::isfinite(value)) found->fail("not finite");
  return value;
}

double GltfElement::number_between(const char* key, double low, double high, std::optional<double> fallback) const {
  const double value = number(key, fallback);
  if (!(value >= low && value <= high)) member(key).fail(fmt::format("{} is outside {} to {}", value, low, high));
  return value;
}

std::uint64_t GltfElement::whole(const char* key, std::optional<std::uint64_t> fallback) const {
  constexpr double kLargest = 9007199254740992.0;  // 2^53: a double holds all below
  const double value = number(key, fallback ? std::optional(static_cast<double>(*fallback)) : std::nullopt);
  if (!(value >= 0 && value < kLargest && value == std::floor(value))) {
    member(key).fail(fmt::format("{} is not a whole number from 0", value));
  }
  return static_cast<std::uint64_t>(value);
}

std::size_t GltfElement::as_index(std::size_t count) const {
  if (!value_->is_number_integer() || value_->get<std::int64_t>() < 0 ||
      value_->get<std::uint64_t>() >= static_cast<std::uint64_t>(count)) {
    fail(fmt::format("{} is not below {}", shortened(value_->dump()), count));
  }
  return value_->get<std::size_t>();
}

std::size_t GltfElement::index(const char* key, std::size_t count) const {
  return member(key).as_index(count);
}

std::optional<std::size_t> GltfElement::find_index(const char* key, std::size_t count) const {
  const std::optional<GltfElement> found = find(key);
  return found ? std::optional(found->as_index(count)) : std::nullopt;
}

bool GltfElement::flag(const char* key, bool fallback) const {
  const std::optional<GltfElement> found = find(key);
  if (found && !found->raw().is_boolean()) found->fail("neither true nor false");
  return found ? found->raw().get<bool>() : fallback;
}

std::string GltfElement::as_text() const {
  if (!value_->is_string()) fail("not a text");
  return value_->get<std::string>();
}

std::string GltfElement::text(const char* key, std::optional<std::string> fallback) const {
  const std::optional<GltfElement> found = fallback ? find(key) : member(key);
  return found ? found->as_text() : *fallback;
}

std::vector<double> GltfElement::numbers(const char* key, std::size_t count) const {
  const GltfElement list = member(key);
  if (list.size() != count) list.fail(fmt::format("{} numbers, not {}", list.size(), count));
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) {
    const nlohmann::json& value = list.raw()[i];
    if (!value.is_number()) list.element(i).fail("not a number");
    values.push_back(value.get<double>());
    if (!std::isfinite(values.back())) list.element(i).fail("not finite");
  }
  return values;
}

GltfDocument::GltfDocument(const AssetSource& source, const std::string& name,
                           std::span<const std::string_view> supported)
    : source_(source),
      folder_(std::filesystem::path(normal_name(name)).parent_path().generic_string()),
      file_(source.describe(name)) {
  const std::optional<std::vector<std::byte>> bytes = source.read(name);
  if (!bytes) throw InputError(kWhat, "there is no such file", file_);
  read_container(*bytes);
  require_supported(supported);
}

// Section 4.4, the binary container: a header of 12 bytes, then chunks of length, type and data.
void GltfDocument::read_container(std::span<const std::byte> bytes) {
  constexpr std::uint32_t kMagic = 0x46546c67, kJson = 0x4e4f534a, kBinary = 0x004e4942;
  const auto fail = [&](const std::string& why) { throw InputError(kWhat, why, file_); };
  const auto text_of = [](std::span<const std::byte> part) {
    return std::string_view(reinterpret_cast<const char*>(part.data()), part.size());
  };
  if (bytes.size() < 12 || word_at(bytes, 0) != kMagic) {
    read_json(text_of(bytes));
    return;
  }
  if (word_at(bytes, 4) != 2) fail(fmt::format("binary glTF version {}; 2 is read", word_at(bytes, 4)));
  const std::size_t length = word_at(bytes, 8);
  if (length > bytes.size()) fail(fmt::format("cut off: {} of {} bytes", bytes.size(), length));
  bool has_json = false;
  for (std::size_t at = 12; at + 8 <= length;) {
    const std::size_t size = word_at(bytes, at);
    const std::uint32_t type = word_at(bytes, at + 4);
    if (size > length - at - 8)
      fail(fmt::format("the chunk at byte {} says {} bytes, {} are left", at, size, length - at - 8));
    const std::span<const std::byte> part = bytes.subspan(at + 8, size);
    if (!has_json) {
      if (type != kJson) fail(fmt::format("the chunk at byte {} is not the JSON that comes first", at));
      read_json(text_of(part));
      has_json = true;
    } else if (type == kBinary && !has_binary_chunk_) {
      binary_chunk_.assign(part.begin(), part.end());
      has_binary_chunk_ = true;
    }
    at += 8 + (size + 3) / 4 * 4;
  }
  if (!has_json) fail("it has no JSON chunk");
}

void GltfDocument::read_json(std::string_view text) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  while (!text.empty() && text.back() == '\0') text.remove_suffix(1);  // chunks padded by zeros instead of blanks
  try {
    json_ = nlohmann::json::parse(text.begin(), text.end());
  } catch (const nlohmann::json::exception& error) {
    // The message reads "[json.exception...] parse error at line 3, column 5: ..."; only what follows the tag helps.
    const std::string message = error.what();
    const auto from = message.find("] ");
    throw InputError(kWhat, "broken JSON: " + to_utf8(from == std::string::npos ? message : message.substr(from + 2)),
                     file_);
  }
  const GltfElement asset = root().member("asset");
  const std::string version = asset.text("version"), least = asset.text("minVersion", "2.0");
  if (!version.starts_with("2.")) asset.fail("glTF version " + shortened(version) + "; 2 is read");
  if (!least.starts_with("2.0")) asset.fail("it needs glTF version " + shortened(least) + "; 2.0 is read");
}

void GltfDocument::require_supported(std::span<const std::string_view> supported) const {
  for (const GltfElement& required : root().elements("extensionsRequired")) {
    const std::string name = required.as_text();
    if (std::ranges::find(supported, name) == supported.end()) {
      required.fail("it requires the extension " + shortened(name) + ", which is not supported");
    }
  }
}

std::size_t GltfDocument::count(const char* list) const {
  const std::optional<GltfElement> found = root().find(list);
  return found ? found->size() : 0;
}

GltfElement GltfDocument::item(const char* list, std::size_t index) const {
  return root().member(list).element(index);
}

namespace {

bool is_elsewhere(const std::string& uri) {
  return uri.find("://") != std::string::npos && !uri.starts_with("file:");
}

std::string path_of(const std::string& uri) {
  return uri.starts_with("file://") ? uri.substr(7) : uri;
}

}  // namespace

std::string GltfDocument::uri_name(const std::string& uri) {
  if (uri.starts_with("data:")) return "";
  return to_utf8(std::filesystem::path(normal_name(percent_decoded(uri))).filename().string());
}

std::vector<std::byte> GltfDocument::uri_bytes(const std::string& uri, const GltfElement& user) const {
  if (uri.starts_with("data:")) {  // RFC 2397: data:[type][;parameters][;base64],content
    const auto comma = uri.find(',');
    if (comma == std::string::npos) user.fail("a data URI without a comma");
    const std::string_view content = std::string_view(uri).substr(comma + 1);
    if (!std::string_view(uri).substr(0, comma).ends_with(";base64")) {
      const std::string decoded = percent_decoded(content);
      const auto bytes = std::as_bytes(std::span(decoded));
      return {bytes.begin(), bytes.end()};
    }
    std::optional<std::vector<std::byte>> bytes = base64_decoded(percent_decoded(content));
    if (!bytes) user.fail("a data URI that is no base64");
    return std::move(*bytes);
  }
  if (is_elsewhere(uri)) {
    user.fail(shortened(uri) + " is elsewhere; only files beside the model are read");
  }
  if (const std::optional<std::string> file = file_of(uri)) {
    if (std::optional<std::vector<std::byte>> bytes = source_.read(*file)) return std::move(*bytes);
  }
  user.fail("the file " + shortened(percent_decoded(path_of(uri))) + " is missing");
}

std::optional<std::string> GltfDocument::file_of(const std::string& uri) const {
  const std::string path = path_of(uri);
  // Names are percent-encoded by the specification, but not by every exporter.
  for (const std::string& name : {percent_decoded(path), path}) {
    const std::string inside =
        folder_.empty() || std::filesystem::path(name).is_absolute() ? name : folder_ + "/" + name;
    if (source_.contains(inside)) return inside;
  }
  return std::nullopt;
}

bool GltfDocument::is_absent_file(const std::string& uri) const {
  return !uri.starts_with("data:") && !is_elsewhere(uri) && !file_of(uri);
}

std::span<const std::byte> GltfDocument::buffer_bytes(std::size_t index, const GltfElement& user) const {
  const auto known = buffers_.find(index);
  if (known != buffers_.end()) return known->second;
  const GltfElement buffer = item("buffers", index);
  const std::uint64_t length = buffer.whole("byteLength");
  std::vector<std::byte> bytes;
  if (buffer.has("uri")) {
    bytes = uri_bytes(buffer.text("uri"), buffer);
  } else if (index == 0 && has_binary_chunk_) {
    bytes = binary_chunk_;
  } else {
    user.fail(fmt::format("buffers[{}] has neither a file nor a binary chunk", index));
  }
  if (bytes.size() < length) buffer.fail(fmt::format("byteLength is {}, its file has {} bytes", length, bytes.size()));
  bytes.resize(length);
  return buffers_.emplace(index, std::move(bytes)).first->second;
}

std::span<const std::byte> GltfDocument::view_bytes(std::size_t index, const GltfElement& user) const {
  const GltfElement view = item("bufferViews", index);
  for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    const std::optional<GltfElement> compressed = view.extension(name);
    if (!compressed) continue;
    const auto known = views_.find(index);
    return known != views_.end() ? known->second : views_.emplace(index, decompressed(*compressed)).first->second;
  }
  const std::span<const std::byte> buffer = buffer_bytes(view.index("buffer", count("buffers")), user);
  const std::uint64_t offset = view.whole("byteOffset", 0), length = view.whole("byteLength");
  if (offset > buffer.size() || length > buffer.size() - offset) {
    view.fail(fmt::format("bytes {} to {} are not in its buffer of {}", offset, offset + length, buffer.size()));
  }
  return buffer.subspan(offset, length);
}

}  // namespace subpixel::capture
