// Image files as they come: other programs' formats, channels, layers, parts and windows.
#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "replay/measure/image.hpp"

namespace subpixel::replay {

// Most pixels that are read; beyond them, too, an image is taken for damaged.
inline constexpr std::uint64_t max_image_pixels = std::uint64_t{1} << 28;

// A rectangle of pixels, `x` and `y` its top left.
struct PixelWindow {
  std::int32_t x = 0, y = 0;
  std::uint32_t width = 0, height = 0;
  auto operator<=>(const PixelWindow&) const = default;
};

struct ImageFile {
  std::filesystem::path path;
  Image image;                        // of the display window; 1, 3 or, with alpha, 4 channels
  PixelWindow window;                 // OpenEXR's display window; of other formats 0, 0 and the size
  std::vector<std::string> channels;  // the file's names of the image's channels
  std::vector<std::string> left_out;  // and of all others, as "Z" or "part:Z"
  std::uint64_t pixels_outside = 0;   // of the data window, outside of the display window: they are not in `image`
};

// The format is told by the first bytes, by the name's ending only where it has none; nothing else of the name means
// anything. Integer formats give display values, float formats linear ones. Of an OpenEXR file the colours are R, G, B
// or, as grey, Y, with A where there is one: those without a layer's name, else those of the only layer that has
// colours, else, or in any case where `layer` is not empty, those of that layer or part. Pixels of the display window
// that the data window does not have are 0, as OpenEXR says. Grey with alpha becomes 4 channels.
// Throws InputError, in one line that ends in the path: no file, not an image, cut short, too large, deep data, no
// colours, several layers to choose from.
ImageFile read_image_file(const std::filesystem::path& path, std::string_view layer = {});

// The same file's image alone.
Image read_image(const std::filesystem::path& path);

// A PNG in memory, as encode_png() makes them. Throws InputError.
Image decode_png(std::string_view bytes);

}  // namespace subpixel::replay
