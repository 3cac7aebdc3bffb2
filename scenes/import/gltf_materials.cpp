#include "scenes/import/gltf_materials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "base/error.hpp"
#include "scenes/builder/camera.hpp"
#include "scenes/import/statements.hpp"
#include "scenes/import/text.hpp"

namespace subpixel::capture {
namespace {

// Which texture of our material a slot is, in the order of the mappings.
constexpr int kBaseColour = 0, kMetallicRoughness = 1, kNormal = 2, kEmissive = 3;

std::array<UvMapping*, 4> mappings(Material& material) {
  return {&material.base_colour_uv, &material.metallic_roughness_uv, &material.normal_uv, &material.emissive_uv};
}

float unit_factor(const GltfElement& from, const char* key, double fallback) {
  return static_cast<float>(from.number_between(key, 0, 1, fallback));
}

template <std::size_t N>
std::array<float, N> colour(const GltfElement& from, const char* key, std::array<float, N> fallback, double most) {
  if (!from.has(key)) return fallback;
  const std::vector<double> values = from.numbers(key, N);
  for (std::size_t i = 0; i < N; ++i) {
    if (!(values[i] >= 0 && values[i] <= most)) {
      from.member(key).element(i).fail(fmt::format("{} is outside 0 to {}", values[i], most));
    }
    fallback[i] = static_cast<float>(values[i]);
  }
  return fallback;
}

Wrap wrap_of(const GltfElement& sampler, const char* key) {
  switch (const std::uint64_t mode = sampler.whole(key, 10497)) {
    case 10497:
      return Wrap::repeat;
    case 33071:
      return Wrap::clamp_to_edge;
    case 33648:
      return Wrap::mirrored_repeat;
    default:
      sampler.fail(fmt::format("unknown {} {}", key, mode));
  }
}

// IEC 61966-2-1.
double linear_of_srgb(double c) {
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}
double srgb_of_linear(double c) {
  return c <= 0.0031308 ? c * 12.92 : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
}

std::uint8_t to_byte(double value) {
  return static_cast<std::uint8_t>(std::floor(std::clamp(value, 0.0, 1.0) * 255 + 0.5));
}

struct MetallicRoughness {
  std::array<double, 3> base{};
  double metallic = 0;
};

// KHR_materials_pbrSpecularGlossiness, appendix "converting between workflows": the metallic value for which a
// dielectric of 4% and a metal mix to these diffuse and specular colours, solved for the perceived brightness of both.
MetallicRoughness converted(const std::array<double, 3>& diffuse, const std::array<double, 3>& specular) {
  constexpr double kDielectric = 0.04;
  const auto brightness = [](const std::array<double, 3>& c) {
    return std::sqrt(0.299 * c[0] * c[0] + 0.587 * c[1] * c[1] + 0.114 * c[2] * c[2]);
  };
  const double strongest = std::max({specular[0], specular[1], specular[2]});
  const double diffuse_brightness = brightness(diffuse), specular_brightness = brightness(specular);
  MetallicRoughness result;
  if (specular_brightness > kDielectric) {
    const double a = kDielectric;
    const double b = diffuse_brightness * (1 - strongest) / (1 - kDielectric) + specular_brightness - 2 * kDielectric;
    const double c = kDielectric - specular_brightness;
    result.metallic = std::clamp((-b + std::sqrt(std::max(b * b - 4 * a * c, 0.0))) / (2 * a), 0.0, 1.0);
  }
  const double m = result.metallic;
  for (std::size_t i = 0; i < 3; ++i) {
    const double from_diffuse = diffuse[i] * (1 - strongest) / (1 - kDielectric) / std::max(1 - m, 1e-6);
    const double from_specular = (specular[i] - kDielectric * (1 - m)) / std::max(m, 1e-6);
    result.base[i] = std::clamp(from_diffuse + (from_specular - from_diffuse) * m * m, 0.0, 1.0);
  }
  return result;
}

void require_alpha_mode(const GltfElement& from, Material& material) {
  const std::string mode = from.text("alphaMode", "OPAQUE");
  if (mode == "MASK") {
    material.alpha_mode = AlphaMode::test;
    const double cutoff = from.number("alphaCutoff", 0.5);
    if (cutoff < 0) from.member("alphaCutoff").fail(fmt::format("{} is below 0", cutoff));
    material.alpha_cutoff = static_cast<float>(std::min(cutoff, 1.0));
    if (cutoff > 1) material.base_colour[3] = 0;  // no alpha reaches it: nothing shows
  } else if (mode == "BLEND") {
    material.alpha_mode = AlphaMode::blend;
  } else if (mode != "OPAQUE") {
    from.member("alphaMode").fail("neither OPAQUE, MASK nor BLEND");
  }
}

}  // namespace

void GltfMaterials::notice(const std::string& text) {
  if (std::ranges::find(notices_, text) == notices_.end()) notices_.push_back(text);
}

// KHR_texture_transform: offset, then a rotation counter-clockwise as seen with v down, then scale, applied from the
// right.
GltfMaterials::Slot GltfMaterials::read_slot(const GltfElement& info) const {
  Slot slot;
  slot.path = info.path();
  slot.texture = info.index("index", document_.count("textures"));
  slot.mapping.set = static_cast<std::uint32_t>(std::min<std::uint64_t>(info.whole("texCoord", 0), 1u << 16));
  const std::optional<GltfElement> transform = info.extension("KHR_texture_transform");
  if (!transform) return slot;
  if (transform->has("texCoord")) {
    slot.mapping.set = static_cast<std::uint32_t>(std::min<std::uint64_t>(transform->whole("texCoord"), 1u << 16));
  }
  const std::vector<double> offset =
      transform->has("offset") ? transform->numbers("offset", 2) : std::vector<double>{0, 0};
  const std::vector<double> scale =
      transform->has("scale") ? transform->numbers("scale", 2) : std::vector<double>{1, 1};
  const double angle = transform->number("rotation", 0.0);
  const double c = cosine(angle), s = sine(angle);
  const double matrix[6] = {c * scale[0], s * scale[1], offset[0], -s * scale[0], c * scale[1], offset[1]};
  std::ranges::transform(matrix, slot.mapping.matrix.begin(), [](double value) { return static_cast<float>(value); });
  return slot;
}

std::optional<GltfMaterials::Slot> GltfMaterials::find_slot(const GltfElement& parent, const char* key) {
  const std::optional<GltfElement> info = parent.find(key);
  if (!info) return std::nullopt;
  Slot slot = read_slot(*info);
  const GltfElement image = document_.item("images", image_of(slot.texture));
  if (image.has("bufferView") || !document_.is_absent_file(image.text("uri"))) return slot;
  notice("ignored: texture " + in_quotes(GltfDocument::uri_name(image.text("uri"))) + " of " + image.path() +
         ", whose file is missing");
  return std::nullopt;
}

// EXT_texture_webp and MSFT_texture_dds name an image in a format of their own beside, or instead of, `source`.
std::size_t GltfMaterials::image_of(std::size_t texture) {
  const GltfElement from = document_.item("textures", texture);
  const std::size_t images = document_.count("images");
  for (const char* name : {"EXT_texture_webp", "MSFT_texture_dds"}) {
    if (const std::optional<GltfElement> other = from.extension(name)) return other->index("source", images);
  }
  if (const std::optional<std::size_t> source = from.find_index("source", images)) {
    if (from.extension("KHR_texture_basisu"))
      notice("ignored: KHR_texture_basisu; the textures' other images are used");
    return *source;
  }
  if (from.extension("KHR_texture_basisu")) {
    from.fail("its only image is in the extension KHR_texture_basisu, which is not supported");
  }
  if (const std::optional<GltfElement> all = from.find("extensions"); all && !all->raw().empty()) {
    from.fail("its only image is in the extension " + to_utf8(all->raw().begin().key()) + ", which is not supported");
  }
  from.fail("it has no image");
}

const GltfMaterials::SourceImage& GltfMaterials::open(std::size_t image) {
  const auto known = images_.find(image);
  if (known != images_.end()) return known->second;
  const GltfElement from = document_.item("images", image);
  SourceImage opened;
  opened.name = to_utf8(from.text("name", ""));
  if (const std::optional<std::size_t> view = from.find_index("bufferView", document_.count("bufferViews"))) {
    const std::span<const std::byte> bytes = document_.view_bytes(*view, from);
    opened.file.assign(bytes.begin(), bytes.end());
  } else {
    const std::string uri = from.text("uri");
    opened.file = document_.uri_bytes(uri, from);
    if (const std::string file = GltfDocument::uri_name(uri); !file.empty()) opened.name = file;
  }
  if (opened.name.empty()) opened.name = fmt::format("image {}", image);
  opened.decoded = decode_image(opened.file, document_.file() + ", " + from.path() + " " + opened.name);
  return images_.emplace(image, std::move(opened)).first->second;
}

Sampler GltfMaterials::sampler_of(std::size_t texture) const {
  Sampler sampler;
  const std::optional<std::size_t> number =
      document_.item("textures", texture).find_index("sampler", document_.count("samplers"));
  if (!number) return sampler;
  const GltfElement from = document_.item("samplers", *number);
  sampler.wrap_u = wrap_of(from, "wrapS");
  sampler.wrap_v = wrap_of(from, "wrapT");
  constexpr std::uint64_t kNearest = 9728, kLinear = 9729,
                          kFirstMipmapped = 9984;  // then nearest/linear, mip nearest/linear
  const std::uint64_t magnify = from.whole("magFilter", kLinear), minify = from.whole("minFilter", kFirstMipmapped + 3);
  if (magnify != kNearest && magnify != kLinear) from.fail(fmt::format("unknown magFilter {}", magnify));
  sampler.magnify = magnify == kNearest ? TexelFilter::nearest : TexelFilter::linear;
  if (minify == kNearest || minify == kLinear) {
    sampler.minify = minify == kNearest ? TexelFilter::nearest : TexelFilter::linear;
    sampler.mip = MipFilter::none;
  } else if (minify >= kFirstMipmapped && minify < kFirstMipmapped + 4) {
    sampler.minify = (minify & 1) == 0 ? TexelFilter::nearest : TexelFilter::linear;
    sampler.mip = (minify & 2) == 0 ? MipFilter::nearest : MipFilter::linear;
  } else {
    from.fail(fmt::format("unknown minFilter {}", minify));
  }
  return sampler;
}

std::uint32_t GltfMaterials::add(const Slot& slot, bool srgb) {
  const std::size_t image = image_of(slot.texture);
  const Sampler s = sampler_of(slot.texture);
  const std::array<std::uint32_t, 5> sampler{static_cast<std::uint32_t>(s.wrap_u), static_cast<std::uint32_t>(s.wrap_v),
                                             static_cast<std::uint32_t>(s.magnify),
                                             static_cast<std::uint32_t>(s.minify), static_cast<std::uint32_t>(s.mip)};
  const auto known = numbers_.find({image, sampler, srgb});
  if (known != numbers_.end()) return known->second;
  const SourceImage& source = open(image);
  const auto number = static_cast<std::uint32_t>(textures_.size());
  textures_.push_back({source.name, TextureEncoding::image_file, srgb, 0, 0, source.file, s});
  numbers_.emplace(std::tuple(image, sampler, srgb), number);
  return number;
}

void GltfMaterials::read_metallic_roughness(const GltfElement& from, Material& material,
                                            std::vector<std::pair<Slot, int>>& slots) {
  material.metallic = material.roughness = 1;
  const std::optional<GltfElement> pbr = from.find("pbrMetallicRoughness");
  if (!pbr) return;
  material.base_colour = colour<4>(*pbr, "baseColorFactor", material.base_colour, 1);
  material.metallic = unit_factor(*pbr, "metallicFactor", 1);
  material.roughness = unit_factor(*pbr, "roughnessFactor", 1);
  if (const std::optional<Slot> slot = find_slot(*pbr, "baseColorTexture")) {
    material.base_colour_texture = add(*slot, true);
    slots.emplace_back(*slot, kBaseColour);
  }
  if (const std::optional<Slot> slot = find_slot(*pbr, "metallicRoughnessTexture")) {
    material.metallic_roughness_texture = add(*slot, false);
    slots.emplace_back(*slot, kMetallicRoughness);
  }
}

// Colours convert exactly where there is no texture. With textures, every texel of the larger one is converted, factors
// included, and the material's factors are 1.
void GltfMaterials::read_specular_glossiness(const GltfElement& extension, Material& material,
                                             std::vector<std::pair<Slot, int>>& slots) {
  const std::array<float, 4> diffuse = colour<4>(extension, "diffuseFactor", {1, 1, 1, 1}, 1);
  const std::array<float, 3> specular = colour<3>(extension, "specularFactor", {1, 1, 1}, 1);
  const double glossiness = unit_factor(extension, "glossinessFactor", 1);
  const std::optional<Slot> diffuse_slot = find_slot(extension, "diffuseTexture");
  const std::optional<Slot> specular_slot = find_slot(extension, "specularGlossinessTexture");
  material.base_colour[3] = diffuse[3];
  if (!specular_slot && !diffuse_slot) {
    const MetallicRoughness result =
        converted({diffuse[0], diffuse[1], diffuse[2]}, {specular[0], specular[1], specular[2]});
    for (std::size_t i = 0; i < 3; ++i) material.base_colour[i] = static_cast<float>(result.base[i]);
    material.metallic = static_cast<float>(result.metallic);
    material.roughness = static_cast<float>(1 - glossiness);
    return;
  }
  DecodedImage white;
  white.width = white.height = 1;
  white.rgba.assign(4, 255);
  const DecodedImage& from_diffuse = diffuse_slot ? open(image_of(diffuse_slot->texture)).decoded : white;
  const DecodedImage& from_specular = specular_slot ? open(image_of(specular_slot->texture)).decoded : white;
  const std::uint32_t width = std::max(from_diffuse.width, from_specular.width);
  const std::uint32_t height = std::max(from_diffuse.height, from_specular.height);
  if (diffuse_slot && specular_slot &&
      (diffuse_slot->mapping != specular_slot->mapping ||
       sampler_of(diffuse_slot->texture) != sampler_of(specular_slot->texture))) {
    notice("approximated: KHR_materials_pbrSpecularGlossiness whose two textures are placed differently: " +
           extension.path());
  }
  const auto at_size = [&](const DecodedImage& image) {
    return image.width == width && image.height == height ? image : resized(image, width, height);
  };
  const DecodedImage d = at_size(from_diffuse), s = at_size(from_specular);
  Texture base{"base colour of specular-glossiness", TextureEncoding::rgba8, true, width, height, {}};
  Texture surface{"metallic-roughness of specular-glossiness", TextureEncoding::rgba8, false, width, height, {}};
  base.bytes.reserve(d.rgba.size());
  surface.bytes.reserve(d.rgba.size());
  for (std::size_t i = 0; i < d.rgba.size(); i += 4) {
    std::array<double, 3> texel_diffuse{}, texel_specular{};
    for (std::size_t c = 0; c < 3; ++c) {
      texel_diffuse[c] = diffuse[c] * linear_of_srgb(d.rgba[i + c] / 255.0);
      texel_specular[c] = specular[c] * linear_of_srgb(s.rgba[i + c] / 255.0);
    }
    const MetallicRoughness result = converted(texel_diffuse, texel_specular);
    for (const double c : result.base) base.bytes.push_back(static_cast<std::byte>(to_byte(srgb_of_linear(c))));
    base.bytes.push_back(static_cast<std::byte>(d.rgba[i + 3]));
    const std::uint8_t roughness = to_byte(1 - glossiness * s.rgba[i + 3] / 255.0);
    for (const std::uint8_t c : {std::uint8_t{255}, roughness, to_byte(result.metallic), std::uint8_t{255}}) {
      surface.bytes.push_back(static_cast<std::byte>(c));
    }
  }
  const Slot& slot = diffuse_slot ? *diffuse_slot : *specular_slot;
  base.sampler = surface.sampler = sampler_of(slot.texture);
  material.metallic = material.roughness = 1;
  material.base_colour_texture = static_cast<std::uint32_t>(textures_.size());
  textures_.push_back(std::move(base));
  material.metallic_roughness_texture = static_cast<std::uint32_t>(textures_.size());
  textures_.push_back(std::move(surface));
  slots.emplace_back(slot, kBaseColour);
  slots.emplace_back(slot, kMetallicRoughness);
}

// A mesh has room for two UV sets. Where all textures are read alike the transform goes into the UVs.
void GltfMaterials::arrange_uvs(const std::vector<std::pair<Slot, int>>& slots, GltfMaterial& result) {
  if (slots.empty()) return;
  const UvMapping& first = slots.front().first.mapping;
  const bool alike = std::ranges::all_of(slots, [&](const auto& slot) { return slot.first.mapping == first; });
  result.sets[0] = first.set;
  if (alike) {
    result.baked = first.matrix;
    return;
  }
  const std::array<UvMapping*, 4> places = mappings(result.material);
  for (const auto& [slot, place] : slots) {
    UvMapping mapping = slot.mapping;
    if (mapping.set == result.sets[0]) {
      mapping.set = 0;
    } else if (mapping.set == result.sets[1].value_or(mapping.set)) {
      result.sets[1] = mapping.set;
      mapping.set = 1;
    } else {
      notice("approximated: a material with more than two sets of texture coordinates: " + slot.path +
             " uses the first");
      mapping.set = 0;
    }
    *places[static_cast<std::size_t>(place)] = mapping;
  }
}

GltfMaterial GltfMaterials::read(std::optional<std::size_t> index) {
  GltfMaterial result;
  Material& material = result.material;
  if (!index) {  // section 3.7.2.1: the default material
    material.name = "default";
    material.metallic = material.roughness = 1;
    return result;
  }
  const GltfElement from = document_.item("materials", *index);
  material.name = to_utf8(from.text("name", ""));
  if (material.name.empty()) material.name = fmt::format("material {}", *index);
  std::vector<std::pair<Slot, int>> slots;
  if (const std::optional<GltfElement> other = from.extension("KHR_materials_pbrSpecularGlossiness")) {
    read_specular_glossiness(*other, material, slots);
  } else {
    read_metallic_roughness(from, material, slots);
  }
  require_alpha_mode(from, material);
  material.two_sided = from.flag("doubleSided", false);
  if (const std::optional<Slot> slot = find_slot(from, "normalTexture")) {
    material.normal_texture = add(*slot, false);
    material.normal_scale = static_cast<float>(from.member("normalTexture").number("scale", 1.0));
    slots.emplace_back(*slot, kNormal);
  }
  const double strength = [&] {
    const std::optional<GltfElement> extension = from.extension("KHR_materials_emissive_strength");
    return extension ? extension->number_between("emissiveStrength", 0, 1e12, 1) : 1.0;
  }();
  material.emissive = colour<3>(from, "emissiveFactor", {0, 0, 0}, 1);
  for (float& radiance : material.emissive) radiance = static_cast<float>(radiance * strength);
  if (const std::optional<Slot> slot = find_slot(from, "emissiveTexture")) {
    material.emissive_texture = add(*slot, true);
    slots.emplace_back(*slot, kEmissive);
  }
  if (from.has("occlusionTexture")) notice("ignored: occlusion textures");
  material.unlit = from.extension("KHR_materials_unlit").has_value();
  arrange_uvs(slots, result);
  return result;
}

}  // namespace subpixel::capture
