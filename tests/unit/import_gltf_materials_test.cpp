// glTF materials, textures, samplers and UVs, with the extensions that change them.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "base/error.hpp"
#include "scenes/builder/camera.hpp"
#include "scenes/import/model.hpp"
#include "tests/unit/gltf_builder.hpp"

namespace subpixel::capture {
namespace {

// A TGA of one texel.
std::string texel(int red, int green, int blue, int alpha) {
  std::string file(18, '\0');
  file[2] = 2;
  file[12] = file[14] = 1;
  file[16] = 32;
  file[17] = 0x28;
  for (const int value : {blue, green, red, alpha}) file += static_cast<char>(value);
  return file;
}

class ImportGltfMaterials : public testing::Test {
 protected:
  // A textured triangle with two UV sets; `change` gets the document with its first material.
  Model load(const std::function<void(json& document, json& material)>& change) {
    GltfBuilder b;
    json primitive = b.triangle();
    primitive["attributes"]["TEXCOORD_0"] = b.add<float>("VEC2", {0, 0, 1, 0, 0, 1});
    primitive["attributes"]["TEXCOORD_1"] = b.add<float>("VEC2", {0.25f, 0.5f, 0.5f, 0.5f, 0.25f, 0.75f});
    primitive["material"] = 0;
    b.draw(json::array({primitive}));
    b.document["images"] = json::array({{{"uri", "data:image/tga;base64," + base64(texel(255, 51, 0, 102))}},
                                        {{"uri", "data:image/tga;base64," + base64(texel(0, 0, 255, 255))}}});
    b.document["textures"] = json::array({{{"source", 0}}, {{"source", 1}}});
    b.document["materials"] = json::array({json::object()});
    change(b.document, b.document["materials"][0]);
    folder_.write("model.gltf", b.text());
    return load_model(*open_folder(folder_.path()), "model.gltf");
  }
  Material material_of(const std::function<void(json& document, json& material)>& change) {
    return load(change).materials.at(0);
  }
  std::string refusal_of(const std::function<void(json& document, json& material)>& change) {
    try {
      load(change);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  ScratchFolder folder_;
};

TEST_F(ImportGltfMaterials, TexturesThatAreMissingAreLeftOutWithANotice) {
  const Model model = load([](json& document, json& material) {
    document["images"][0] = {{"uri", "away%20from%20here.png"}};
    material["pbrMetallicRoughness"] = {{"baseColorTexture", {{"index", 0}}}, {"baseColorFactor", {1, 0.5, 0, 1}}};
    material["normalTexture"] = {{"index", 0}};
    material["emissiveTexture"] = {{"index", 1}};
  });
  EXPECT_EQ(model.textures.size(), 1u) << "the one that is there";
  EXPECT_EQ(model.notices,
            (std::vector<std::string>{"ignored: texture \"away from here.png\" of images[0], whose file is missing"}));
  EXPECT_EQ(model.materials.at(0).base_colour, (std::array<float, 4>{1, 0.5f, 0, 1}));
  EXPECT_EQ(model.materials.at(0).base_colour_texture, kNone);
  EXPECT_EQ(model.materials.at(0).normal_texture, kNone);
}

TEST_F(ImportGltfMaterials, DefaultsAreTheSpecifications) {
  const Material material = material_of([](json&, json&) {});
  EXPECT_EQ(material.base_colour, (std::array<float, 4>{1, 1, 1, 1}));
  EXPECT_EQ(material.metallic, 1.0f);
  EXPECT_EQ(material.roughness, 1.0f);
  EXPECT_EQ(material.alpha_mode, AlphaMode::opaque);
  EXPECT_FALSE(material.two_sided);
}

TEST_F(ImportGltfMaterials, AlphaModesAreTheFilesOwn) {
  const auto mask = [](double cutoff) {
    return [cutoff](json&, json& m) {
      m["alphaMode"] = "MASK";
      m["alphaCutoff"] = cutoff;
    };
  };
  EXPECT_EQ(material_of(mask(0.25)).alpha_cutoff, 0.25f);
  EXPECT_FALSE(material_of(mask(0.25)).two_sided) << "only doubleSided makes it so";
  EXPECT_EQ(material_of(mask(1.5)).base_colour[3], 0.0f) << "nothing reaches a cutoff above 1";
  EXPECT_NE(refusal_of(mask(-1)).find("materials[0].alphaCutoff"), std::string::npos);
  EXPECT_EQ(material_of([](json&, json& m) { m["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0; }).alpha_mode,
            AlphaMode::opaque)
      << "transparent texels of an opaque material are opaque";
  EXPECT_EQ(material_of([](json&, json& m) { m["alphaMode"] = "BLEND"; }).alpha_mode, AlphaMode::blend);
  EXPECT_NE(refusal_of([](json&, json& m) { m["alphaMode"] = "GLASS"; }).find("alphaMode"), std::string::npos);
}

TEST_F(ImportGltfMaterials, SamplersSayHowATextureRepeats) {
  const Model model = load([](json& document, json& m) {
    document["samplers"] = json::array(
        {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}, {"minFilter", 9984}}, {{"minFilter", 9729}}});
    document["textures"][0]["sampler"] = 0;
    document["textures"].push_back({{"source", 0}, {"sampler", 1}});
    document["textures"].push_back({{"source", 0}, {"sampler", 0}});
    m["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
    m["emissiveTexture"]["index"] = 2;
    m["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"] = 3;
  });
  const Material& m = model.materials[0];
  const Sampler& base = model.textures[m.base_colour_texture].sampler;
  EXPECT_EQ(base, (Sampler{Wrap::clamp_to_edge, Wrap::mirrored_repeat, TexelFilter::nearest, TexelFilter::nearest,
                           MipFilter::nearest}));
  EXPECT_EQ(model.textures[m.emissive_texture].sampler,
            (Sampler{Wrap::repeat, Wrap::repeat, TexelFilter::linear, TexelFilter::linear, MipFilter::none}));
  EXPECT_EQ(model.textures[m.metallic_roughness_texture].sampler, base);
  EXPECT_EQ(model.textures.size(), 3u) << "colours and numbers of one image differ, and so do samplers";
  EXPECT_NE(refusal_of([](json& document, json& m2) {
              document["samplers"] = json::array({{{"wrapS", 1}}});
              document["textures"][0]["sampler"] = 0;
              m2["emissiveTexture"]["index"] = 0;
            }).find("samplers[0]"),
            std::string::npos);
}

TEST_F(ImportGltfMaterials, WhatAllTexturesShareIsBakedIntoTheUvs) {
  const Model model = load([](json&, json& m) {
    const json info = {{"index", 0},
                       {"texCoord", 1},
                       {"extensions", {{"KHR_texture_transform", {{"scale", {2, 4}}, {"offset", {1, 0}}}}}}};
    m["pbrMetallicRoughness"]["baseColorTexture"] = info;
    m["emissiveTexture"] = info;
  });
  EXPECT_EQ(model.materials[0].base_colour_uv, UvMapping{});
  EXPECT_EQ(model.parts[0].mesh.uvs[1], glm::dvec2(2, 2));
  EXPECT_TRUE(model.parts[0].mesh.uvs2.empty());
}

// The rotation turns the image clockwise as the extension's sample pictures show: what was on the right is below.
TEST_F(ImportGltfMaterials, RotationsTurnTheCoordinates) {
  const Model model = load([](json&, json& m) {
    m["emissiveTexture"] = {{"index", 0},
                            {"extensions", {{"KHR_texture_transform", {{"rotation", kPi / 2}, {"texCoord", 0}}}}}};
  });
  EXPECT_NEAR(model.parts[0].mesh.uvs[1].x, 0, 1e-6);
  EXPECT_NEAR(model.parts[0].mesh.uvs[1].y, -1, 1e-6);
  EXPECT_NEAR(model.parts[0].mesh.uvs[2].x, 1, 1e-6);
}

TEST_F(ImportGltfMaterials, TexturesReadDifferentlyKeepTheirMappings) {
  const Model model = load([](json&, json& m) {
    m["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}, {"texCoord", 1}};
    m["normalTexture"] = {{"index", 1}, {"scale", 0.5}};
    m["emissiveTexture"] = {{"index", 0}, {"extensions", {{"KHR_texture_transform", {{"scale", {3, 1}}}}}}};
  });
  const Material& m = model.materials[0];
  EXPECT_EQ(m.base_colour_uv.set, 0u) << "the first set a mesh has is the first that is read";
  EXPECT_EQ(model.parts[0].mesh.uvs[0], glm::dvec2(0.25, 0.5));
  EXPECT_EQ(m.normal_uv.set, 1u);
  EXPECT_EQ(m.normal_scale, 0.5f);
  EXPECT_EQ(m.emissive_uv.set, 1u);
  EXPECT_EQ(m.emissive_uv.matrix[0], 3.0f);
  EXPECT_EQ(model.parts[0].mesh.uvs2[1], glm::dvec2(1, 0));
  EXPECT_EQ(model.parts[0].mesh.tangents.size(), 3u);
}

TEST_F(ImportGltfMaterials, EmissionHasItsStrengthAndUnlitIsKept) {
  const Material m = material_of([](json&, json& material) {
    material["emissiveFactor"] = {1, 0.5, 0};
    material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = 5;
    material["extensions"]["KHR_materials_unlit"] = json::object();
  });
  EXPECT_EQ(m.emissive, (Float3{5, 2.5f, 0}));
  EXPECT_TRUE(m.unlit);
}

TEST_F(ImportGltfMaterials, SpecularGlossinessIsConverted) {
  const Material dielectric = material_of([](json&, json& m) {
    m["extensions"]["KHR_materials_pbrSpecularGlossiness"] = {
        {"diffuseFactor", {1, 0.5, 0, 1}}, {"specularFactor", {0.04, 0.04, 0.04}}, {"glossinessFactor", 0.2}};
  });
  EXPECT_NEAR(dielectric.base_colour[0], 1, 1e-3);
  EXPECT_NEAR(dielectric.base_colour[1], 0.5, 1e-3);
  EXPECT_NEAR(dielectric.metallic, 0, 1e-3);
  EXPECT_NEAR(dielectric.roughness, 0.8, 1e-6);
  const Material metal = material_of([](json&, json& m) {
    m["extensions"]["KHR_materials_pbrSpecularGlossiness"] = {{"diffuseFactor", {0, 0, 0, 1}},
                                                              {"specularFactor", {0.9, 0.6, 0.3}}};
  });
  EXPECT_NEAR(metal.metallic, 1, 1e-3);
  EXPECT_NEAR(metal.base_colour[0], 0.9, 1e-3);
  EXPECT_NEAR(metal.base_colour[2], 0.3, 1e-3);
  const Model textured = load([](json&, json& m) {
    m["extensions"]["KHR_materials_pbrSpecularGlossiness"] = {{"diffuseTexture", {{"index", 0}}},
                                                              {"specularFactor", {0.04, 0.04, 0.04}},
                                                              {"specularGlossinessTexture", {{"index", 0}}}};
  });
  const Texture& base = textured.textures[textured.materials[0].base_colour_texture];
  EXPECT_EQ(base.bytes.at(0), std::byte{255});
  EXPECT_NEAR(std::to_integer<int>(base.bytes.at(1)), 51, 3) << "the specular texels are below 4%";
  EXPECT_EQ(base.bytes.at(3), std::byte{102});
  const Texture& surface = textured.textures[textured.materials[0].metallic_roughness_texture];
  EXPECT_EQ(surface.bytes.at(1), std::byte{255 - 102});
}

TEST_F(ImportGltfMaterials, ImagesOfExtensionsAreReadOrNamed) {
  const auto source_in = [](const char* extension, bool fallback) {
    return [extension, fallback](json& document, json& m) {
      document["textures"][0] = {{"extensions", {{extension, {{"source", 1}}}}}};
      if (fallback) document["textures"][0]["source"] = 0;
      m["emissiveTexture"]["index"] = 0;
    };
  };
  EXPECT_EQ(load(source_in("EXT_texture_webp", false)).textures.size(), 1u);
  EXPECT_NE(refusal_of(source_in("KHR_texture_basisu", false)).find("KHR_texture_basisu"), std::string::npos);
  EXPECT_NE(refusal_of(source_in("ACME_texture", false)).find("ACME_texture"), std::string::npos);
  const Model fallback = load(source_in("KHR_texture_basisu", true));
  EXPECT_EQ(fallback.textures.size(), 1u);
  ASSERT_EQ(fallback.notices.size(), 1u);
  EXPECT_NE(fallback.notices[0].find("KHR_texture_basisu"), std::string::npos);
}

TEST_F(ImportGltfMaterials, WhatIsLeftOutIsSaid) {
  const Model model = load([](json& document, json& m) {
    document["extensionsUsed"] = {"KHR_materials_clearcoat", "KHR_materials_unlit"};
    m["occlusionTexture"]["index"] = 0;
    m["extensions"]["KHR_materials_clearcoat"]["clearcoatFactor"] = 1;
  });
  EXPECT_EQ(model.notices,
            (std::vector<std::string>{"ignored: occlusion textures", "ignored: extension KHR_materials_clearcoat"}));
}

TEST_F(ImportGltfMaterials, WhatIsWrongIsNamed) {
  EXPECT_NE(
      refusal_of([](json&, json& m) { m["emissiveTexture"]["index"] = 9; }).find("materials[0].emissiveTexture.index"),
      std::string::npos);
  EXPECT_NE(refusal_of([](json&, json& m) { m["pbrMetallicRoughness"]["metallicFactor"] = 2; }).find("metallicFactor"),
            std::string::npos);
  EXPECT_NE(refusal_of([](json&, json& m) {
              m["pbrMetallicRoughness"]["baseColorFactor"] = {1, -1, 0, 1};
            }).find("baseColorFactor[1]"),
            std::string::npos);
  EXPECT_NE(refusal_of([](json& document, json& m) {
              document["images"][0]["uri"] = "data:;base64," + base64("no image at all, yet long enough to be one");
              m["emissiveTexture"]["index"] = 0;
            }).find("images[0]"),
            std::string::npos);
}

}  // namespace
}  // namespace subpixel::capture
