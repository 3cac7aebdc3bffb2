// The records of SPEC.md as bytes. Private to the writer, and trusts that the capture obeys checks.hpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "capture_format/capture.hpp"

namespace subpixel::capture {

class ByteWriter {
 public:
  std::vector<std::byte> bytes;

  template <typename T>
  requires std::is_trivially_copyable_v<T>
  void put(const T& value) { raw(std::as_bytes(std::span(&value, 1))); }
  void text(const std::string& value) {
    put(static_cast<std::uint32_t>(value.size()));
    raw(std::as_bytes(std::span(value)));
  }
  void raw(std::span<const std::byte> from) { bytes.insert(bytes.end(), from.begin(), from.end()); }
};

// The oldest version of the format that can say all of the capture: what version 1 could say keeps its bytes and its
// hash.
std::uint32_t needed_version(const Capture& capture);

// Payloads of chunks in one version, at least the capture's needed_version().
class RecordWriter {
 public:
  explicit RecordWriter(std::uint32_t version) : version_(version) {}

  std::uint32_t version() const { return version_; }

  std::vector<std::byte> metadata(const Metadata& metadata) const;
  std::vector<std::byte> buffer(const Buffer& buffer, std::uint32_t data) const;
  std::vector<std::byte> texture(const Texture& texture, std::uint32_t data) const;
  std::vector<std::byte> materials(const std::vector<Material>& materials) const;
  std::vector<std::byte> frame(const Frame& frame) const;

 private:
  bool has_version_2() const { return version_ >= 2; }
  void put_material(ByteWriter& out, const Material& material) const;
  void put_point_light(ByteWriter& out, const PointLight& light) const;
  void put_draw(ByteWriter& out, const Draw& draw) const;

  std::uint32_t version_;
};

}  // namespace subpixel::capture
