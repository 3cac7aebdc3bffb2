// Materials, textures and samplers of a glTF document in our form (section 3.9 and the extensions named below). Private
// to gltf.cpp.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "capture_format/capture.hpp"
#include "scenes/import/gltf_document.hpp"
#include "scenes/import/texture_decode.hpp"

namespace subpixel::capture {

// A material with what a primitive's meshes need to know of it. A mesh has two UV sets: `sets` names the TEXCOORD
// numbers that go there. Where all textures are read alike their transform is `baked`, to be applied to the first set's
// UVs.
struct GltfMaterial {
  Material material;
  std::array<std::optional<std::size_t>, 2> sets{};
  std::array<float, 6> baked{1, 0, 0, 0, 1, 0};
};

class GltfMaterials {
 public:
  // `textures` and `notices` are added to.
  GltfMaterials(const GltfDocument& document, std::vector<Texture>& textures, std::vector<std::string>& notices)
      : document_(document), textures_(textures), notices_(notices) {}

  // Material `index` of the file, or the specification's default one. Throws InputError naming the texture that is
  // missing, damaged, or in a format that is not read.
  GltfMaterial read(std::optional<std::size_t> index);

 private:
  struct Slot {  // one textureInfo
    std::size_t texture = 0;
    UvMapping mapping;  // set: the TEXCOORD number
    std::string path;
  };
  struct SourceImage {
    std::string name;
    std::vector<std::byte> file;
    DecodedImage decoded;
  };

  Slot read_slot(const GltfElement& info) const;
  // Nothing, with a notice, where the image's file is missing.
  std::optional<Slot> find_slot(const GltfElement& parent, const char* key);
  std::size_t image_of(std::size_t texture);
  const SourceImage& open(std::size_t image);
  Sampler sampler_of(std::size_t texture) const;
  std::uint32_t add(const Slot& slot, bool srgb);
  void read_metallic_roughness(const GltfElement& from, Material& material, std::vector<std::pair<Slot, int>>& slots);
  void read_specular_glossiness(const GltfElement& extension, Material& material,
                                std::vector<std::pair<Slot, int>>& slots);
  void arrange_uvs(const std::vector<std::pair<Slot, int>>& slots, GltfMaterial& result);
  void notice(const std::string& text);

  const GltfDocument& document_;
  std::vector<Texture>& textures_;
  std::vector<std::string>& notices_;
  std::map<std::size_t, SourceImage> images_;
  std::map<std::tuple<std::size_t, std::array<std::uint32_t, 5>, bool>, std::uint32_t> numbers_;
};

}  // namespace subpixel::capture
