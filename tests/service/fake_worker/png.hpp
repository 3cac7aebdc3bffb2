// The smallest PNG writer: 8-bit RGB, stored without compression (RFC 2083; RFC 1951, section 3.2.4).
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace subpixel::tests {

inline std::uint32_t png_crc(const std::string& bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (const char byte : bytes) {
    crc ^= static_cast<std::uint8_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xedb88320u : 0u);
  }
  return ~crc;
}

inline std::string big_endian(std::uint32_t value) {
  return {static_cast<char>(value >> 24), static_cast<char>(value >> 16), static_cast<char>(value >> 8),
          static_cast<char>(value)};
}

inline std::string png_chunk(const std::string& type, const std::string& payload) {
  return big_endian(static_cast<std::uint32_t>(payload.size())) + type + payload + big_endian(png_crc(type + payload));
}

// `rgb`: 3 * width * height bytes, top row first.
inline void write_png(const std::filesystem::path& path, std::uint32_t width, std::uint32_t height,
                      const std::vector<std::uint8_t>& rgb) {
  std::string rows;
  for (std::uint32_t y = 0; y < height; ++y) {
    rows += '\0';  // no filter
    rows.append(reinterpret_cast<const char*>(rgb.data()) + std::size_t{3} * width * y, std::size_t{3} * width);
  }
  std::uint32_t a = 1, b = 0;  // Adler-32
  for (const char byte : rows) {
    a = (a + static_cast<std::uint8_t>(byte)) % 65521;
    b = (b + a) % 65521;
  }
  std::string stream = "\x78\x01";
  for (std::size_t at = 0; at < rows.size(); at += 65535) {
    const std::size_t length = std::min<std::size_t>(65535, rows.size() - at);
    stream += at + length == rows.size() ? '\1' : '\0';
    for (const std::size_t value : {length, ~length}) {
      stream += static_cast<char>(value & 0xff);
      stream += static_cast<char>((value >> 8) & 0xff);
    }
    stream.append(rows, at, length);
  }
  stream += big_endian((b << 16) | a);
  std::ofstream file(path, std::ios::binary);
  file << "\x89PNG\r\n\x1a\n"
       << png_chunk("IHDR", big_endian(width) + big_endian(height) + std::string("\x08\x02\0\0\0", 5))
       << png_chunk("IDAT", stream) << png_chunk("IEND", "");
}

}  // namespace subpixel::tests
