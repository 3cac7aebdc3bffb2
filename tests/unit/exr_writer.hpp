// OpenEXR files with any channels, windows and parts, uncompressed, after the format's description ("OpenEXR File
// Layout"): what other programs write and encode_exr() does not.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

namespace subpixel::tests {

struct ExrBox {
  std::int32_t left = 0, top = 0, right = 0, bottom = 0;  // the last two are within
};

struct ExrPart {
  std::string name;                   // needed in files of several
  std::vector<std::string> channels;  // 32-bit floats
  ExrBox data, display;
  std::function<float(const std::string& channel, int x, int y)> value;
};

class ExrBytes {
 public:
  template <class T>
  ExrBytes& put(T value) {
    const auto* const from = reinterpret_cast<const char*>(&value);
    bytes_.append(from, sizeof value);
    return *this;
  }
  ExrBytes& text(const std::string& value) {
    bytes_.append(value.c_str(), value.size() + 1);
    return *this;
  }
  ExrBytes& attribute(const std::string& name, const std::string& type, const ExrBytes& value) {
    text(name).text(type).put(static_cast<std::int32_t>(value.bytes_.size()));
    bytes_ += value.bytes_;
    return *this;
  }
  std::string& bytes() { return bytes_; }

 private:
  std::string bytes_;
};

inline std::string exr_file(std::vector<ExrPart> parts) {
  const bool several = parts.size() > 1;
  ExrBytes out;
  out.put(std::uint32_t{20000630}).put(std::uint32_t{several ? 0x1002U : 0x2U});
  for (ExrPart& part : parts) {
    std::ranges::sort(part.channels);
    ExrBytes channels;
    for (const std::string& name : part.channels)
      channels.text(name).put(std::int32_t{2}).put(std::int32_t{0}).put(std::int32_t{1}).put(std::int32_t{1});
    channels.put(std::uint8_t{0});
    out.attribute("channels", "chlist", channels);
    out.attribute("compression", "compression", ExrBytes().put(std::uint8_t{0}));
    out.attribute("dataWindow", "box2i", ExrBytes().put(part.data));
    out.attribute("displayWindow", "box2i", ExrBytes().put(part.display));
    out.attribute("lineOrder", "lineOrder", ExrBytes().put(std::uint8_t{0}));
    out.attribute("pixelAspectRatio", "float", ExrBytes().put(1.0F));
    out.attribute("screenWindowCenter", "v2f", ExrBytes().put(0.0F).put(0.0F));
    out.attribute("screenWindowWidth", "float", ExrBytes().put(1.0F));
    if (several) {
      ExrBytes name, type;
      name.bytes() = part.name;
      type.bytes() = "scanlineimage";
      out.attribute("name", "string", name).attribute("type", "string", type);
      out.attribute("chunkCount", "int", ExrBytes().put(part.data.bottom - part.data.top + 1));
    }
    out.put(std::uint8_t{0});
  }
  if (several) out.put(std::uint8_t{0});
  std::size_t lines = 0;
  for (const ExrPart& part : parts) lines += static_cast<std::size_t>(part.data.bottom - part.data.top + 1);
  const std::size_t table = out.bytes().size();
  out.bytes().append(lines * sizeof(std::uint64_t), '\0');
  std::size_t line = 0;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const ExrPart& part = parts[p];
    const int width = part.data.right - part.data.left + 1;
    for (int y = part.data.top; y <= part.data.bottom; ++y, ++line) {
      const std::uint64_t offset = out.bytes().size();
      std::memcpy(&out.bytes()[table + line * sizeof offset], &offset, sizeof offset);
      if (several) out.put(static_cast<std::int32_t>(p));
      out.put(std::int32_t{y}).put(static_cast<std::int32_t>(part.channels.size() * sizeof(float)) * width);
      for (const std::string& channel : part.channels)
        for (int x = part.data.left; x <= part.data.right; ++x) out.put(part.value(channel, x, y));
    }
  }
  return out.bytes();
}

}  // namespace subpixel::tests
