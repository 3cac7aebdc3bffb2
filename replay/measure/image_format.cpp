#include "replay/measure/image_format.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdint>

namespace subpixel::replay {
namespace {

using namespace std::string_view_literals;

struct Signature {
  std::string_view start, format;
};

constexpr std::array kSignatures{
    Signature{"\x89PNG\r\n\x1a\n"sv, "png"},
    Signature{"\x76\x2f\x31\x01"sv, "openexr"},
    Signature{"\xff\xd8\xff"sv, "jpeg"},
    Signature{"#?"sv, "hdr"},
    Signature{"II*\0"sv, "tiff"},
    Signature{"MM\0*"sv, "tiff"},
    Signature{"II+\0"sv, "tiff"},
    Signature{"MM\0+"sv, "tiff"},
    Signature{"BM"sv, "bmp"},
    Signature{"GIF8"sv, "gif"},
    Signature{"DDS "sv, "dds"},
    Signature{"8BPS"sv, "psd"},
};

std::uint32_t big_endian(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes[at + i]);
  return value;
}

bool png_has_end(std::string_view bytes) {
  constexpr std::size_t kSignatureBytes = 8, kChunkBytes = 12;  // a chunk's length, name and check sum
  std::size_t at = kSignatureBytes;
  while (bytes.size() - at >= kChunkBytes) {
    const std::size_t length = big_endian(bytes, at, 4);
    if (length > bytes.size() - at - kChunkBytes) return false;
    if (bytes.substr(at + 4, 4) == "IEND") return true;
    at += length + kChunkBytes;
  }
  return false;
}

bool jpeg_has_end(std::string_view bytes) {
  // A thumbnail within an application's segment has an end of its own, so segments are passed over by their lengths.
  std::size_t at = 2;
  while (at + 4 <= bytes.size() && bytes[at] == '\xff') {
    const auto marker = static_cast<std::uint8_t>(bytes[at + 1]);
    if (marker == 0xff) {  // fill
      ++at;
      continue;
    }
    if (marker == 0xda) return bytes.find("\xff\xd9"sv, at) != std::string_view::npos;  // start of scan
    at += 2 + big_endian(bytes, at + 2, 2);
  }
  return false;
}

}  // namespace

std::string image_format(std::string_view start, const std::filesystem::path& path) {
  for (const Signature& signature : kSignatures)
    if (start.starts_with(signature.start)) return std::string(signature.format);
  if (start.starts_with("RIFF") && start.size() >= 12 && start.substr(8, 4) == "WEBP") return "webp";
  if (start.size() >= 3 && start[0] == 'P' && "1234567fF"sv.find(start[1]) != std::string_view::npos &&
      std::isspace(static_cast<unsigned char>(start[2])) != 0) {
    return "pnm";
  }
  std::string ending = path.extension().string();
  if (ending.size() < 2 ||
      !std::all_of(ending.begin() + 1, ending.end(), [](unsigned char c) { return std::isalnum(c) != 0; })) {
    return "";
  }
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending.substr(1);
}

bool is_cut_short(std::string_view bytes, std::string_view format) {
  if (format == "png") return !png_has_end(bytes);
  if (format == "jpeg") return !jpeg_has_end(bytes);
  return false;
}

}  // namespace subpixel::replay
