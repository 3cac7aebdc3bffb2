// Which of a file's channels are its colours.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace subpixel::replay {

// One image of a file, as OpenEXR's parts are.
struct ImagePart {
  std::string name;
  std::vector<std::string> channels;  // "R", "diffuse.R", ...: before the last dot the layer's name
};

struct ChosenChannels {
  std::size_t part = 0;
  std::vector<int> channels;  // 1 or 3 colours, and alpha after them where there is one
  bool has_alpha = false;
  std::vector<std::string> left_out;  // names of all others; of several parts with the part's
};

// By the rules of read_image_file(). Throws InputError that ends in `path`.
ChosenChannels choose_channels(const std::vector<ImagePart>& parts, std::string_view layer, const std::string& path);

}  // namespace subpixel::replay
