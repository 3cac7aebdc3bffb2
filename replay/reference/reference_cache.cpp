#include "replay/reference/reference_cache.hpp"

#include <zstd.h>

#include <array>
#include <cstring>
#include <fstream>
#include <vector>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/hash.hpp"
#include "capture_format/writer.hpp"
#include "shaders/embedded.hpp"

namespace subpixel::replay {
namespace {

// Raised when the host's part of the reference (triangle list, turns, textures) changes what comes out.
constexpr std::uint32_t kHostRevision = 2;

constexpr std::array<char, 8> kMagic{'S', 'P', 'X', 'L', 'R', 'E', 'F', '\n'};
constexpr std::uint32_t kForm = 1;
constexpr std::size_t kFloatsPerPixel = 6;

struct Header {
  std::array<char, 8> magic = kMagic;
  std::uint32_t form = kForm, width = 0, height = 0, reserved = 0;
  std::uint64_t payload_bytes = 0;
  std::uint64_t checksum[2] = {};
};
static_assert(sizeof(Header) == 48);

class Hasher {
 public:
  void add(const void* data, std::size_t bytes) { hasher_.add({static_cast<const std::byte*>(data), bytes}); }
  template <typename T>
  void add_value(const T& value) {
    add(&value, sizeof value);
  }
  // The length too, so that neighbouring texts can't trade characters.
  void add_text(std::string_view text) {
    add_value(std::uint64_t{text.size()});
    add(text.data(), text.size());
  }
  ContentHash hash() const { return hasher_.hash(); }

 private:
  ContentHasher hasher_;
};

ContentHash checksum_of(Header header, const std::vector<std::uint8_t>& payload) {
  header.checksum[0] = header.checksum[1] = 0;
  Hasher hasher;
  hasher.add_value(header);
  hasher.add(payload.data(), payload.size());
  return hasher.hash();
}

// Byte b of float i at b * count + i: neighbouring floats share their high bytes, which then compress.
std::vector<std::uint8_t> split_planes(const std::vector<float>& values) {
  std::vector<std::uint8_t> planes(values.size() * 4);
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::uint8_t bytes[4];
    std::memcpy(bytes, &values[i], 4);
    for (std::size_t b = 0; b < 4; ++b) planes[b * values.size() + i] = bytes[b];
  }
  return planes;
}

std::vector<float> join_planes(const std::vector<std::uint8_t>& planes) {
  std::vector<float> values(planes.size() / 4);
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::uint8_t bytes[4];
    for (std::size_t b = 0; b < 4; ++b) bytes[b] = planes[b * values.size() + i];
    std::memcpy(&values[i], bytes, 4);
  }
  return values;
}

std::optional<std::vector<std::uint8_t>> read_payload(const std::filesystem::path& path, Header& header) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return std::nullopt;
  const auto bytes = static_cast<std::uint64_t>(file.tellg());
  file.seekg(0);
  if (bytes < sizeof header || !file.read(reinterpret_cast<char*>(&header), sizeof header)) return std::nullopt;
  if (header.magic != kMagic || header.form != kForm || header.payload_bytes != bytes - sizeof header ||
      header.width == 0 || header.height == 0 || header.width > max_image_side || header.height > max_image_side)
    return std::nullopt;
  std::vector<std::uint8_t> payload(header.payload_bytes);
  if (!file.read(reinterpret_cast<char*>(payload.data()), static_cast<std::streamsize>(payload.size())))
    return std::nullopt;
  const ContentHash found = checksum_of(header, payload);
  if (found.low != header.checksum[0] || found.high != header.checksum[1]) return std::nullopt;
  return payload;
}

}  // namespace

std::string reference_key(const gpu::Device& device, const GpuScene& scene, std::string_view capture_hash,
                          std::uint32_t frame, const ReferenceOptions& options) {
  Hasher hasher;
  hasher.add_value(kHostRevision);
  hasher.add_text(capture_hash);
  hasher.add_value(frame);
  hasher.add_value(scene.constants());
  hasher.add_value(scene.features().bits);
  hasher.add_value(scene.shadow_map.description().width);
  hasher.add_value(options.samples);
  hasher.add_value(options.shading_model);
  hasher.add_value(static_cast<std::uint32_t>(options.tone_map_samples));
  const auto& info = device.info();
  for (const auto& text : {info.device, info.driver, info.driver_version, info.cpu_model}) hasher.add_text(text);
  for (const auto& shader : shaders::all()) {
    if (!shader.name.starts_with("reference/") && !shader.name.starts_with("scene/")) continue;
    hasher.add_text(shader.name);
    const auto words = device.shaders().words(shader.name);
    hasher.add(words.data(), words.size_bytes());
  }
  return hasher.hash().hex();
}

std::filesystem::path ReferenceCache::path_of(std::string_view key) const {
  return folder_ / (std::string(key) + ".spref");
}

std::optional<ReferenceImage> ReferenceCache::load(std::string_view key) const {
  Header header;
  const auto payload = read_payload(path_of(key), header);
  if (!payload) return std::nullopt;
  const std::size_t floats = std::size_t{header.width} * header.height * kFloatsPerPixel;
  std::vector<std::uint8_t> planes(floats * 4);
  const std::size_t decoded = ZSTD_decompress(planes.data(), planes.size(), payload->data(), payload->size());
  if (ZSTD_isError(decoded) || decoded != planes.size()) return std::nullopt;
  const std::vector<float> values = join_planes(planes);
  ReferenceImage image{Image(header.width, header.height, 3, Encoding::linear),
                       Image(header.width, header.height, 3, Encoding::display)};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(floats / 2);
  image.linear.pixels.assign(values.begin(), middle);
  image.display.pixels.assign(middle, values.end());
  return image;
}

void ReferenceCache::store(std::string_view key, const ReferenceImage& image) const {
  std::vector<float> values = image.linear.pixels;
  values.insert(values.end(), image.display.pixels.begin(), image.display.pixels.end());
  const std::vector<std::uint8_t> planes = split_planes(values);
  std::vector<std::uint8_t> payload(ZSTD_compressBound(planes.size()));
  const std::size_t stored = ZSTD_compress(payload.data(), payload.size(), planes.data(), planes.size(), 1);
  if (ZSTD_isError(stored)) throw InputError("reference cache", ZSTD_getErrorName(stored), path_of(key).string());
  payload.resize(stored);
  Header header;
  header.width = image.linear.width;
  header.height = image.linear.height;
  header.payload_bytes = stored;
  const ContentHash checksum = checksum_of(header, payload);
  header.checksum[0] = checksum.low;
  header.checksum[1] = checksum.high;
  std::vector<std::uint8_t> file(sizeof header);
  std::memcpy(file.data(), &header, sizeof header);
  file.insert(file.end(), payload.begin(), payload.end());
  write_file_atomically(path_of(key), file);
}

CachedReference cached_reference(gpu::Device& device, GpuScene& scene, std::string_view capture_hash,
                                 std::uint32_t frame, const ReferenceOptions& options, const ReferenceCache& cache,
                                 const ReferenceProgress& progress) {
  const std::string key = reference_key(device, scene, capture_hash, frame, options);
  const auto& size = scene.constants().viewport;
  if (auto image = cache.load(key); image && image->linear.width == static_cast<std::uint32_t>(size.x) &&
                                    image->linear.height == static_cast<std::uint32_t>(size.y))
    return {std::move(*image), true, {}};
  CachedReference result{render_reference(device, scene, options, progress), false, {}};
  try {
    cache.store(key, result.image);
  } catch (const InputError& error) {
    result.store_error = error.what();
  }
  return result;
}

CachedReference cached_reference(gpu::Device& device, GpuScene& scene, std::uint32_t frame,
                                 const ReferenceOptions& options, const ReferenceCache& cache) {
  const std::string hash = content_hash_hex(capture::encode_capture(scene.capture(), {.zstd_level = 0}));
  return cached_reference(device, scene, hash, frame, options, cache);
}

}  // namespace subpixel::replay
