#include "replay/measure/image_file.hpp"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>
#include <system_error>

#include "base/error.hpp"
#include "base/printable.hpp"
#include "replay/measure/image_channels.hpp"
#include "replay/measure/image_format.hpp"

namespace subpixel::replay {
namespace {

constexpr std::size_t kSignatureBytes = 16;
constexpr int kMostParts = 4096;

[[noreturn]] void refuse(const std::string& why, const std::string& path) {
  throw InputError("image", why, path);
}

// The library's words, which may be several lines and name the file once more.
std::string library_words(std::string words, const std::string& path) {
  words = joined_lines(words);
  for (const std::string& name : {"\"" + path + "\": ", "\"" + path + "\"", path}) {
    const std::size_t at = words.find(name);
    if (at != std::string::npos) words.erase(at, name.size());
  }
  return words.empty() ? "it can't be decoded" : words;
}

// Input of a file of the given format, opened. Made by the format's name: given the file's, the library would read a
// query in it.
std::unique_ptr<OIIO::ImageInput> open_input(const std::string& format, const std::string& path) {
  std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(format);
  if (!input) {
    OIIO::geterror();
    refuse("it is of no kind that can be read", path);
  }
  OIIO::ImageSpec wanted, found;
  wanted.attribute("oiio:UnassociatedAlpha", 1);
  if (!input->open(path, found, wanted)) refuse(library_words(input->geterror(), path), path);
  return input;
}

void require_readable(const OIIO::ImageSpec& spec, const std::string& path) {
  if (spec.deep) refuse("deep data has no one colour a pixel", path);
  if (spec.depth > 1) refuse("it is a volume", path);
  const auto require_size = [&](std::int64_t width, std::int64_t height) {
    const auto in_bounds = [](std::int64_t side) { return side > 0 && side <= std::int64_t{max_image_side}; };
    if (in_bounds(width) && in_bounds(height) && width * height <= static_cast<std::int64_t>(max_image_pixels)) return;
    refuse("size " + std::to_string(width) + "x" + std::to_string(height) + " is outside of 1 to " +
               std::to_string(max_image_side) + " with up to " + std::to_string(max_image_pixels) + " pixels",
           path);
  };
  require_size(spec.width, spec.height);
  require_size(spec.full_width, spec.full_height);
}

// Channels `first` to `end`, apart by `stride_bytes` a pixel. TIFF's reader says "read" and holds an error when a strip
// is cut short.
void read_range(OIIO::ImageInput& input, int part, int first, int end, float* to, OIIO::stride_t stride_bytes,
                const std::string& path) {
  // Counts are numbers, not shares of 2^32: they come as they are, for round_integers().
  const OIIO::TypeDesc type =
      input.spec(part).format == OIIO::TypeDesc::UINT ? OIIO::TypeDesc::UINT : OIIO::TypeDesc::FLOAT;
  const bool read = input.read_image(part, 0, first, end, type, to, stride_bytes);
  if (!read || input.has_error()) refuse(library_words(input.geterror(), path), path);
}

// The library multiplies by a rounded 1 / 255 or 1 / 65535. Divided, equal shares of different depths are equal floats.
void round_integers(const OIIO::ImageSpec& spec, std::vector<float>& values) {
  if (spec.format == OIIO::TypeDesc::UINT)
    for (float& value : values) value = static_cast<float>(std::bit_cast<std::uint32_t>(value));
  const float steps = spec.format == OIIO::TypeDesc::UINT8 ? 255.0F : 65535.0F;
  if (spec.format != OIIO::TypeDesc::UINT8 && spec.format != OIIO::TypeDesc::UINT16) return;
  for (float& value : values) value = std::nearbyint(value * steps) / steps;
}

// Channels of one part in the order chosen: pixels of the data window, `chosen.size()` floats each.
std::vector<float> read_channels(OIIO::ImageInput& input, int part, const std::vector<int>& chosen,
                                 const std::string& path) {
  const OIIO::ImageSpec spec = input.spec(part);
  const auto [first, last] = std::ranges::minmax(chosen);
  const std::size_t pixels = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
  std::vector<float> values(pixels * chosen.size());
  if (static_cast<std::size_t>(last - first) + 1 == chosen.size() && std::ranges::is_sorted(chosen)) {
    read_range(input, part, first, last + 1, values.data(), OIIO::AutoStride, path);
  } else {
    // One by one, since there may be any number of others between them.
    const auto pixel_bytes = static_cast<OIIO::stride_t>(chosen.size() * sizeof(float));
    for (std::size_t c = 0; c < chosen.size(); ++c)
      read_range(input, part, chosen[c], chosen[c] + 1, values.data() + c, pixel_bytes, path);
  }
  round_integers(spec, values);
  return values;
}

// Grey or colour, with alpha always as the fourth of four.
Image as_image(const std::vector<float>& values, std::uint32_t width, std::uint32_t height, std::size_t channels,
               bool has_alpha, Encoding encoding) {
  const std::size_t colours = channels - (has_alpha ? 1 : 0);
  Image image(width, height, has_alpha ? 4U : static_cast<std::uint32_t>(colours), encoding);
  for (std::size_t i = 0; i < std::size_t{width} * height; ++i) {
    const float* const from = &values[i * channels];
    float* const to = &image.pixels[i * image.channels];
    const std::size_t written = has_alpha ? 3 : colours;
    for (std::size_t c = 0; c < written; ++c) to[c] = from[std::min(c, colours - 1)];
    if (has_alpha) to[3] = from[colours];
  }
  return image;
}

// The data window's image on a display window.
Image on_display_window(const Image& data, const OIIO::ImageSpec& spec, ImageFile& file) {
  file.window = {spec.full_x, spec.full_y, static_cast<std::uint32_t>(spec.full_width),
                 static_cast<std::uint32_t>(spec.full_height)};
  const int left = std::max(spec.x, spec.full_x), right = std::min(spec.x + spec.width, spec.full_x + spec.full_width);
  const int top = std::max(spec.y, spec.full_y), end = std::min(spec.y + spec.height, spec.full_y + spec.full_height);
  const std::uint64_t inside = right > left && end > top ? std::uint64_t(right - left) * std::uint64_t(end - top) : 0;
  file.pixels_outside = std::uint64_t{data.width} * data.height - inside;
  Image image(file.window.width, file.window.height, data.channels, data.encoding);
  if (inside == 0) return image;
  for (int y = top; y < end; ++y) {
    const std::size_t from = data.offset(left - spec.x, y - spec.y);
    std::copy_n(data.pixels.begin() + static_cast<std::ptrdiff_t>(from),
                static_cast<std::size_t>(right - left) * data.channels,
                image.pixels.begin() + static_cast<std::ptrdiff_t>(image.offset(left - spec.full_x, y - spec.full_y)));
  }
  return image;
}

std::vector<ImagePart> parts_of(OIIO::ImageInput& input) {
  std::vector<ImagePart> parts;
  for (int i = 0; i < kMostParts && input.seek_subimage(i, 0); ++i) {
    const OIIO::ImageSpec spec = input.spec(i);
    parts.push_back({std::string(spec.get_string_attribute("oiio:subimagename")), spec.channelnames});
  }
  static_cast<void>(input.geterror());  // of the part that there is not
  return parts;
}

// Formats other than OpenEXR: the first image, 1, 3 or 4 channels; two are grey with alpha.
ChosenChannels first_channels(const OIIO::ImageSpec& spec) {
  ChosenChannels chosen;
  chosen.has_alpha = spec.nchannels == 2 || spec.nchannels >= 4;
  for (int i = 0; i < std::min(spec.nchannels, 4); ++i) chosen.channels.push_back(i);
  for (int i = 4; i < spec.nchannels; ++i) chosen.left_out.push_back(spec.channelnames[i]);
  return chosen;
}

ImageFile read_opened(OIIO::ImageInput& input, bool openexr, std::string_view layer, const std::string& path) {
  ImageFile file;
  ChosenChannels chosen;
  if (openexr) {
    chosen = choose_channels(parts_of(input), layer, path);
  } else if (!layer.empty()) {
    refuse("it has no layers, and --layer names " + std::string(layer), path);
  } else {
    chosen = first_channels(input.spec());
  }
  const OIIO::ImageSpec spec = input.spec(static_cast<int>(chosen.part));
  require_readable(spec, path);
  if (spec.nchannels < 1) refuse("it has no channels", path);
  const Image data =
      as_image(read_channels(input, static_cast<int>(chosen.part), chosen.channels, path),
               static_cast<std::uint32_t>(spec.width), static_cast<std::uint32_t>(spec.height), chosen.channels.size(),
               chosen.has_alpha, spec.format.is_floating_point() ? Encoding::linear : Encoding::display);
  for (const int channel : chosen.channels) file.channels.push_back(spec.channelnames[channel]);
  file.left_out = chosen.left_out;
  file.window = {0, 0, data.width, data.height};
  file.image = openexr ? on_display_window(data, spec, file) : data;
  return file;
}

}  // namespace

ImageFile read_image_file(const std::filesystem::path& path, std::string_view layer) {
  const std::string name = path.string();
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (error) refuse("it can't be read: " + error.message(), name);
  // A pipe would be waited for, and its bytes are gone once the format is known.
  if (!std::filesystem::is_regular_file(status)) refuse("it is not a regular file", name);
  std::ifstream in(path, std::ios::binary);
  if (!in) refuse("it can't be opened", name);
  std::string bytes(kSignatureBytes, '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  if (bytes.empty()) refuse("it is empty", name);
  const std::string format = image_format(bytes, path);
  if (format.empty()) refuse("it is of no kind that can be read", name);
  if (format == "png" || format == "jpeg") {
    in.clear();
    bytes.append(std::istreambuf_iterator<char>(in), {});
    if (is_cut_short(bytes, format)) refuse("it ends early, after " + std::to_string(bytes.size()) + " bytes", name);
  }
  const std::unique_ptr<OIIO::ImageInput> input = open_input(format, name);
  ImageFile file = read_opened(*input, format == "openexr", layer, name);
  file.path = path;
  return file;
}

Image read_image(const std::filesystem::path& path) {
  return read_image_file(path).image;
}

Image decode_png(std::string_view bytes) {
  const std::string name = "PNG in memory";
  if (is_cut_short(bytes, "png")) refuse("it ends early", name);
  OIIO::Filesystem::IOMemReader memory(const_cast<char*>(bytes.data()), bytes.size());  // is only read from
  std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create("png");
  OIIO::ImageSpec wanted, found;
  wanted.attribute("oiio:UnassociatedAlpha", 1);
  if (!input || !input->set_ioproxy(&memory) || !input->open("memory.png", found, wanted)) {
    refuse(library_words(input ? input->geterror() : OIIO::geterror(), "memory.png"), name);
  }
  Image image = read_opened(*input, false, "", name).image;
  input.reset();  // before what it reads from
  return image;
}

}  // namespace subpixel::replay
