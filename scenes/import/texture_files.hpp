// The image files that a model's materials name, as textures of the model: each file once for each way it is used.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "capture_format/capture.hpp"
#include "scenes/import/asset_source.hpp"
#include "scenes/import/texture_decode.hpp"

namespace subpixel::capture {

// An image file with what its texels say. No bytes: the texels are all there is.
struct TextureFile {
  std::vector<std::byte> bytes;
  DecodedImage image;
};

class TextureFiles {
 public:
  // Both outlive this; textures are appended.
  TextureFiles(const AssetSource& source, std::vector<Texture>& textures) : source_(source), textures_(textures) {}

  // An image that the model file itself holds, under a name of its own.
  void embed(const std::string& name, TextureFile file) { files_.insert_or_assign(name, std::move(file)); }

  // `name` is one of the source's or an embedded one. Throws InputError when it is missing or damaged.
  const TextureFile& open(const std::string& name);

  // Numbers of textures in the model. The file as found:
  std::uint32_t add(const std::string& name, bool srgb, const Sampler& sampler = {});

  // The colour of one file ("": white) with the alpha of another: its channel 'r', 'g', 'b' or 'm' (its alpha); by
  // default its alpha where that is not opaque throughout, else its red.
  std::uint32_t add_with_alpha(const std::string& colour, const std::string& alpha, char channel = 0,
                               const Sampler& sampler = {});

  // The red of one file as roughness and of the other as metallic; "": 1 throughout. Both the same file, and not grey:
  // it is packed as glTF's are.
  std::uint32_t add_surface(const std::string& roughness, const std::string& metallic, const Sampler& sampler = {});

 private:
  enum class Use { colour, numbers, with_alpha, surface };
  using Way = std::tuple<std::string, std::string, Use, char, Wrap, Wrap>;  // files, use, alpha's channel, u, v

  // The number for a way of use, and whether the texture is yet to be appended.
  std::pair<std::uint32_t, bool> number_of(Way way);
  void append_texels(const std::string& name, bool srgb, const DecodedImage& image, const Sampler& sampler);

  const AssetSource& source_;
  std::vector<Texture>& textures_;
  std::map<std::string, TextureFile> files_;
  std::map<Way, std::uint32_t> numbers_;
};

// That a material's texture is left out since its file is not there.
std::string absent_texture_notice(const std::string& name, const std::string& material);

// `name` without folders, in UTF-8.
std::string short_file_name(const std::string& name);

}  // namespace subpixel::capture
