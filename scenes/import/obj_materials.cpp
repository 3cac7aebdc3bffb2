#include "scenes/import/obj_materials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include "base/error.hpp"
#include "scenes/import/material_values.hpp"
#include "scenes/import/mtl.hpp"
#include "scenes/import/statements.hpp"
#include "scenes/import/text.hpp"
#include "scenes/import/texture_files.hpp"

namespace subpixel::capture {
namespace {

std::string folder_of(const std::string& name) {
  return std::filesystem::path(normal_name(name)).parent_path().generic_string();
}

// One of a library's materials, with what is needed to find its textures.
struct FoundMaterial {
  MtlMaterial mtl;
  bool tr_is_opacity = false;
  std::string folder;
};

struct FoundLibraries {
  std::vector<FoundMaterial> materials;
  std::vector<std::pair<std::string, std::size_t>> missing;  // name, line of mtllib
  bool has_namesake = false;                                 // of the model's own name, in place of the missing
};

// The files that one mtllib names: names may hold blanks, so the longest run of words that is a file is one.
void find_libraries(const ObjLibraryUse& use, const AssetSource& source, const std::string& folder,
                    std::vector<std::string>& files, FoundLibraries& found) {
  constexpr std::size_t kMostWords = 64;
  std::vector<std::string_view> words;
  std::string_view rest = use.names;
  for (std::string_view word = take_token(rest); !word.empty() && words.size() < kMostWords; word = take_token(rest)) {
    words.push_back(word);
  }
  std::string absent;
  const auto note_absent = [&] {
    if (!absent.empty()) found.missing.emplace_back(absent, use.line);
    absent.clear();
  };
  for (std::size_t first = 0; first < words.size();) {
    std::size_t last = words.size();
    std::optional<std::string> file;
    for (; last > first && !file; --last) {
      const char* const end = words[last - 1].data() + words[last - 1].size();
      file = find_beside(source, {folder}, std::string(words[first].data(), end));
    }
    if (file) {
      note_absent();
      files.push_back(*file);
      first = last + 1;
      continue;
    }
    if (!absent.empty()) absent += ' ';
    absent += words[first++];
    if (lower_case(absent).ends_with(".mtl")) note_absent();
  }
  note_absent();
}

FoundLibraries read_libraries(const ObjText& obj, const AssetSource& source, const std::string& model_name,
                              Model& model) {
  FoundLibraries found;
  std::vector<std::string> files;
  for (const ObjLibraryUse& use : obj.libraries) find_libraries(use, source, folder_of(model_name), files, found);
  if (!found.missing.empty()) {  // files that are renamed together keep the old name inside
    const std::string namesake = std::filesystem::path(model_name).replace_extension(".mtl").generic_string();
    if (const std::optional<std::string> file = source.find(namesake)) {
      files.push_back(*file);
      found.has_namesake = true;
      model.notices.push_back(fmt::format("read: {} for the material file {} of line {}, which is missing",
                                          in_quotes(short_file_name(*file)), in_quotes(found.missing.front().first),
                                          found.missing.front().second));
    }
  }
  std::set<std::string> read, names;
  for (const std::string& file : files) {
    if (!read.insert(file).second) continue;
    MtlLibrary library = parse_mtl(*source.read(file), source.describe(file));
    model.notices.insert(model.notices.end(), library.notices.begin(), library.notices.end());
    for (MtlMaterial& material : library.materials) {
      if (!names.insert(material.name).second) {
        model.notices.push_back(
            fmt::format("ignored: another material {}, {}", in_quotes(material.name), material.place));
        continue;
      }
      found.materials.push_back({std::move(material), library.tr_is_opacity, folder_of(file)});
    }
  }
  return found;
}

// Whether nine texels of ten are directions of about length 1 that lean towards +z, as no picture of heights is.
bool is_normal_map(const DecodedImage& image) {
  const auto axis = [](std::uint8_t value) { return value / 127.5f - 1; };
  std::size_t fitting = 0;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    const float x = axis(image.rgba[i]), y = axis(image.rgba[i + 1]), z = axis(image.rgba[i + 2]);
    if (std::abs(x * x + y * y + z * z - 1) < 0.3f && z > std::abs(x) && z > std::abs(y)) ++fitting;
  }
  return fitting * 40 > image.rgba.size() * 9;  // four bytes a texel
}

class MaterialMaker {
 public:
  MaterialMaker(const AssetSource& source, const std::string& model_name, Model& model)
      : source_(source), folder_(folder_of(model_name)), model_(model), textures_(source, model.textures) {}

  // Textures only of those that some face uses.
  Material make(FoundMaterial from, bool is_used) {
    if (is_used) leave_out_absent_textures(from);
    const MtlMaterial& mtl = from.mtl;
    Material material;
    material.name = to_utf8(mtl.name);
    set_base_colour(from, material);
    const auto finite = [](double value) { return static_cast<float>(value); };
    material.roughness = mtl.pr ? unit(finite(*mtl.pr)) : roughness_of_exponent(finite(mtl.ns.value_or(0)));
    material.metallic = unit(finite(mtl.pm.value_or(0)));
    if (mtl.ke) {
      for (int i = 0; i < 3; ++i) material.emissive[static_cast<std::size_t>(i)] = std::max(finite((*mtl.ke)[i]), 0.0f);
    }
    if (is_used) set_textures(from, material);
    material.two_sided = material.alpha_mode == AlphaMode::test;  // leaf cards are seen from behind, too
    return material;
  }

 private:
  // The bump map is looked for where it is told from a picture of heights.
  void leave_out_absent_textures(FoundMaterial& from) {
    MtlMaterial& mtl = from.mtl;
    for (std::optional<MtlMap>* map : {&mtl.map_kd, &mtl.map_d, &mtl.map_ke, &mtl.map_pr, &mtl.map_pm, &mtl.norm}) {
      if (!map->has_value() || find_file(map->value(), from)) continue;
      model_.notices.push_back(absent_texture_notice(map->value().file, mtl.name) + ", " + map->value().place);
      map->reset();
    }
  }

  void set_base_colour(const FoundMaterial& from, Material& material) {
    const MtlMaterial& mtl = from.mtl;
    const glm::dvec3 colour = mtl.map_kd ? glm::dvec3(1) : mtl.kd.value_or(glm::dvec3(kDefaultDiffuse));
    for (int i = 0; i < 3; ++i) {
      material.base_colour[static_cast<std::size_t>(i)] = linear_of_srgb(static_cast<float>(colour[i]));
    }
    const double tr = mtl.tr.value_or(0);
    const double opacity = mtl.d ? *mtl.d : !mtl.tr ? 1.0 : from.tr_is_opacity ? tr : 1 - tr;
    if (!mtl.d && mtl.tr && from.tr_is_opacity) {
      model_.notices.push_back(fmt::format("read: Tr {} of material {} as opacity", tr, in_quotes(mtl.name)));
    }
    material.base_colour[3] = unit(static_cast<float>(opacity));
    if (material.base_colour[3] < 1) material.alpha_mode = AlphaMode::blend;
  }

  void set_textures(const FoundMaterial& from, Material& material) {
    const MtlMaterial& mtl = from.mtl;
    set_base_texture(from, material);
    if (mtl.map_pr || mtl.map_pm) {
      const MtlMap& map = mtl.map_pr ? *mtl.map_pr : *mtl.map_pm;
      material.metallic_roughness_texture = textures_.add_surface(
          mtl.map_pr ? file_of(*mtl.map_pr, from) : "", mtl.map_pm ? file_of(*mtl.map_pm, from) : "", sampler_of(map));
      material.metallic_roughness_uv = uv_of(map);
      if (mtl.map_pr) material.roughness = 1;  // a map stands in for its number
      if (mtl.map_pm) material.metallic = 1;
    }
    if (mtl.map_ke) {
      material.emissive_texture = textures_.add(file_of(*mtl.map_ke, from), true, sampler_of(*mtl.map_ke));
      material.emissive_uv = uv_of(*mtl.map_ke);
      if (material.emissive == Float3{0, 0, 0}) material.emissive = {1, 1, 1};
    }
    if (mtl.norm) {
      material.normal_texture = textures_.add(file_of(*mtl.norm, from), false, sampler_of(*mtl.norm));
      material.normal_uv = uv_of(*mtl.norm);
      material.normal_scale = static_cast<float>(mtl.norm->bump);
    } else if (mtl.bump) {
      set_bump(from, material);
    }
  }

  // The format has heights here, but Blender and others write normal maps.
  void set_bump(const FoundMaterial& from, Material& material) {
    const MtlMap& map = *from.mtl.bump;
    const std::optional<std::string> file = find_beside(source_, {from.folder, folder_}, map.file);
    if (!file || !is_normal_map(textures_.open(*file).image)) {
      model_.notices.push_back(
          fmt::format("ignored: the height map of material {}, {}", in_quotes(from.mtl.name), map.place));
      return;
    }
    model_.notices.push_back(fmt::format("read: map_Bump of material {} as the normal map that it is, {}",
                                         in_quotes(from.mtl.name), map.place));
    material.normal_texture = textures_.add(*file, false, sampler_of(map));
    material.normal_uv = uv_of(map);
    material.normal_scale = static_cast<float>(map.bump);
  }

  void set_base_texture(const FoundMaterial& from, Material& material) {
    const MtlMaterial& mtl = from.mtl;
    if (!mtl.map_kd && !mtl.map_d) return;
    const MtlMap& map = mtl.map_kd ? *mtl.map_kd : *mtl.map_d;
    const std::string colour = mtl.map_kd ? file_of(*mtl.map_kd, from) : "";
    const std::string alpha = mtl.map_d ? file_of(*mtl.map_d, from) : "";
    material.base_colour_uv = uv_of(map);
    if (alpha.empty() || alpha == colour) {
      material.base_colour_texture = textures_.add(colour, true, sampler_of(map));
      if (textures_.open(colour).image.is_transparent) material.alpha_mode = AlphaMode::test;
      return;
    }
    material.base_colour_texture = textures_.add_with_alpha(colour, alpha, mtl.map_d->channel, sampler_of(map));
    material.alpha_mode = AlphaMode::test;
  }

  std::optional<std::string> find_file(const MtlMap& map, const FoundMaterial& from) const {
    std::optional<std::string> file = find_beside(source_, {from.folder, folder_}, map.file);
    // "name.png # which is blue"
    if (!file) file = find_beside(source_, {from.folder, folder_}, std::string(without_comment(map.file)));
    return file;
  }

  // Of a map that leave_out_absent_textures() left.
  std::string file_of(const MtlMap& map, const FoundMaterial& from) const {
    return find_file(map, from).value_or(map.file);
  }

  static Sampler sampler_of(const MtlMap& map) {
    Sampler sampler;
    if (map.clamp) sampler.wrap_u = sampler.wrap_v = Wrap::clamp_to_edge;
    return sampler;
  }

  // v' = s v + o upwards is, with both turned over, v' = s v + 1 - s - o.
  static UvMapping uv_of(const MtlMap& map) {
    UvMapping mapping;
    const auto value = [](double number) { return static_cast<float>(number); };
    mapping.matrix = {
        value(map.scale.x), 0, value(map.offset.x), 0, value(map.scale.y), value(1 - map.scale.y - map.offset.y)};
    return mapping;
  }

  const AssetSource& source_;
  std::string folder_;
  Model& model_;
  TextureFiles textures_;
};

// Libraries that are missing matter only to a material that no other library has.
void require_library(const FoundLibraries& found, const ObjMaterialUse& use, const AssetSource& source,
                     const std::string& model_name) {
  if (found.missing.empty()) return;
  const auto& [file, line] = found.missing.front();
  throw InputError(
      "can't import the model",
      fmt::format("the material file {} is missing, which material {} must be in", to_utf8(file), to_utf8(use.name)),
      fmt::format("{}, line {}", source.describe(model_name), line));
}

// Where a library has each of the names that faces use; files are often written on systems that know no case.
class MaterialNames {
 public:
  explicit MaterialNames(const std::vector<FoundMaterial>& materials) {
    for (std::uint32_t i = 0; i < materials.size(); ++i) {
      exact_.try_emplace(materials[i].mtl.name, i);
      any_case_.try_emplace(lower_case(materials[i].mtl.name), i);
    }
  }

  std::optional<std::uint32_t> find(const std::string& name) const {
    if (const auto found = exact_.find(name); found != exact_.end()) return found->second;
    const auto found = any_case_.find(lower_case(name));
    return found == any_case_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  std::map<std::string, std::uint32_t> exact_, any_case_;
};

}  // namespace

std::vector<std::uint32_t> add_obj_materials(const ObjText& obj, const AssetSource& source,
                                             const std::string& model_name, Model& model) {
  const FoundLibraries found = read_libraries(obj, source, model_name, model);
  const MaterialNames names(found.materials);
  std::vector<std::uint32_t> numbers;
  std::set<std::uint32_t> used;
  std::vector<std::string> absent;
  for (const ObjMaterialUse& use : obj.materials) {
    const std::optional<std::uint32_t> known = use.name.empty() ? std::nullopt : names.find(use.name);
    if (known) used.insert(*known);
    numbers.push_back(known.value_or(static_cast<std::uint32_t>(found.materials.size() + absent.size())));
    if (known) continue;
    if (!use.name.empty()) {
      require_library(found, use, source, model_name);
      model.notices.push_back(
          fmt::format("ignored: usemtl {} in line {}, which no library has", in_quotes(use.name), use.line));
    }
    absent.push_back(use.name.empty() ? kDefaultMaterialName : to_utf8(use.name));
  }
  for (const auto& [file, line] : found.missing) {
    if (found.has_namesake) break;
    model.notices.push_back(
        fmt::format("ignored: the material file {} of line {} is missing; no face needs it", in_quotes(file), line));
  }
  MaterialMaker maker(source, model_name, model);
  for (std::uint32_t i = 0; i < found.materials.size(); ++i) {
    model.materials.push_back(maker.make(found.materials[i], used.contains(i)));
  }
  for (const std::string& name : absent) model.materials.push_back(default_material(name, !obj.colours.empty()));
  return numbers;
}

}  // namespace subpixel::capture
