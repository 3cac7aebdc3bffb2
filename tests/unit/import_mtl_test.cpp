// MTL as people's programs write it, and the files that it names.
#include <gtest/gtest.h>

#include "tests/unit/obj_fixture.hpp"

namespace subpixel::capture {
namespace {

class ImportMtl : public ObjFixture {};

TEST_F(ImportMtl, TextureNamesInEverySpelling) {
  write("sub/s.tga", tga(1, 2, 3));
  write("my tex.tga", tga(1, 2, 3));
  write("T\xc3\xbcx.tga", tga(1, 2, 3));
  const std::pair<const char*, const char*> cases[] = {
      {"t.tga", "t.tga"},
      {"t.tga  \t", "t.tga"},
      {"\tt.tga", "t.tga"},
      {"T.TGA", "t.tga"},
      {".\\t.tga", "t.tga"},
      {"./t.tga", "t.tga"},
      {"sub\\s.tga", "s.tga"},
      {"SUB/S.tga", "s.tga"},
      {"C:\\Users\\me\\t.tga", "t.tga"},
      {"/home/nobody/t.tga", "t.tga"},
      {"..\\textures\\t.tga", "t.tga"},
      {"my tex.tga", "my tex.tga"},
      {"\"my tex.tga\"", "my tex.tga"},
      {"T\xc3\xbcx.tga", "Tüx.tga"},
      {"T\xfcx.tga", "Tüx.tga"},  // Latin-1
      {"-s 1 1 1 -o 0 0 0 -mm 0 1 t.tga", "t.tga"},
      {"-s 1 t.tga", "t.tga"},
      {"-blendu on -blendv off t.tga", "t.tga"},
      {"-colorspace sRGB t.tga", "t.tga"},
      {"-imfchan r my tex.tga", "my tex.tga"},
      {"-texres 512 t.tga", "t.tga"},
      {"-type sphere t.tga", "t.tga"},
      {"t.tga -bm 0.2", "t.tga"},
      {"t.tga # which is red", "t.tga"},
  };
  for (const auto& [written, found] : cases) {
    const Model model = load_mtl(std::string("newmtl m\nKd 1 0 0\nmap_Kd ") + written + "\r\n");
    ASSERT_EQ(model.textures.size(), 1u) << written;
    EXPECT_EQ(model.textures[0].name, found) << written;
    EXPECT_EQ(model.materials.at(0).base_colour[1], 1.0f) << "a map stands in for Kd";
  }
  EXPECT_EQ(load_mtl("newmtl m\nmap_Kd\n").textures.size(), 0u);
}

TEST_F(ImportMtl, OptionsOfMapsSetMappingAndSampler) {
  const Model model = load_mtl("newmtl m\nmap_Kd -s 2 3 1 -o 0.25 0.5 -clamp on t.tga\n");
  const Material& material = model.materials.at(0);
  // (u, v upwards) = (1, 1) is read at (2 + 0.25, 3 + 0.5) upwards.
  EXPECT_EQ(material.base_colour_uv.matrix, (std::array<float, 6>{2, 0, 0.25f, 0, 3, 1 - 3 - 0.5f}));
  EXPECT_EQ(model.textures.at(0).sampler.wrap_u, Wrap::clamp_to_edge);
  EXPECT_EQ(model.textures.at(0).sampler.wrap_v, Wrap::clamp_to_edge);
  EXPECT_EQ(load_mtl("newmtl m\nmap_Kd t.tga\n").textures.at(0).sampler, Sampler{});
}

// What is there of the material is used, and each texture of it that is not is said.
TEST_F(ImportMtl, MissingTexturesAreLeftOutOfUsedMaterials) {
  const Model model = load_mtl("newmtl m\nmap_Kd t.tga\nnewmtl old\nmap_Kd absent.tga\n");
  EXPECT_EQ(model.materials.size(), 2u);
  EXPECT_EQ(model.textures.size(), 1u);
  EXPECT_EQ(model.notices.size(), 0u);
  const Model left = load_mtl(
      "newmtl m\nKd 1 0 0\nmap_Kd C:\\away\\absent.tga\nmap_d gone.tga\nPr 0.25\nmap_Pr no.tga\nmap_Ke no.tga\n"
      "norm no.tga\n");
  EXPECT_EQ(left.textures.size(), 0u);
  ASSERT_EQ(left.notices.size(), 5u);
  EXPECT_TRUE(has_notice(left, "ignored: texture \"C:\\away\\absent.tga\" of material \"m\", whose file is missing"))
      << left.notices[0];
  EXPECT_TRUE(has_notice(left, "m.mtl, line 3"));
  const Material& material = left.materials.at(0);
  EXPECT_EQ(material.base_colour, (std::array<float, 4>{1, 0, 0, 1}));
  EXPECT_EQ(material.alpha_mode, AlphaMode::opaque);
  EXPECT_EQ(material.roughness, 0.25f);
  EXPECT_EQ(material.emissive, (Float3{0, 0, 0}));
  // Of the two parts of one texture one may be there.
  const Model half = load_mtl("newmtl m\nmap_Kd t.tga\nmap_d gone.tga\n");
  EXPECT_EQ(half.textures.size(), 1u);
  EXPECT_EQ(half.notices.size(), 1u);
}

TEST_F(ImportMtl, OpacityByDAndByTr) {
  const auto alpha = [&](const std::string& lines) { return material_of("newmtl m\n" + lines).base_colour[3]; };
  EXPECT_EQ(alpha("d 0.25\n"), 0.25f);
  EXPECT_EQ(alpha("Tr 0.75\n"), 0.25f);
  EXPECT_EQ(alpha("Tr 0.0\n"), 1.0f);
  EXPECT_EQ(alpha("d 1.0\nTr 1.0\n"), 1.0f) << "d wins";
  EXPECT_EQ(alpha("Tr 0.5\nd 0.75\n"), 0.75f);
  EXPECT_EQ(alpha("d -halo 0.5\n"), 0.5f);
  EXPECT_EQ(alpha("Tr 1.000000\n"), 1.0f) << "MeshLab's opaque";
  EXPECT_EQ(alpha("Tr 1\nnewmtl glass\nTr 0.25\n"), 1.0f);
  EXPECT_EQ(alpha("Tr 1\nnewmtl wall\nTr 0\n"), 0.0f) << "another one is opaque by Tr 0";
  EXPECT_EQ(
      material_of("#\n# Wavefront material file\n# Converted by Meshlab Group\n#\nnewmtl m\nTr 0.25\n").base_colour[3],
      0.25f);
  const Model model = load_mtl("newmtl m\nTr 1\n");
  EXPECT_EQ(model.materials.at(0).alpha_mode, AlphaMode::opaque);
  EXPECT_TRUE(has_notice(model, "Tr 1 of material \"m\" as opacity"));
  EXPECT_EQ(material_of("newmtl m\nd 0.5\n").alpha_mode, AlphaMode::blend);
}

TEST_F(ImportMtl, AlphaOfAMapAlone) {
  write("mask.tga", tga(64, 64, 64));
  write("masked.tga", tga(1, 2, 3, 128));
  const Model model = load_mtl("newmtl m\nKd 0 1 0\nmap_d mask.tga\n");
  const Material& leaf = model.materials.at(0);
  EXPECT_EQ(leaf.alpha_mode, AlphaMode::test);
  EXPECT_TRUE(leaf.two_sided);
  EXPECT_EQ(leaf.base_colour[0], 0.0f) << "Kd colours the cut-out";
  const Texture& texture = model.textures.at(leaf.base_colour_texture);
  EXPECT_EQ(texture.bytes.at(0), std::byte{255});
  EXPECT_EQ(texture.bytes.at(3), std::byte{64});
  const Model both = load_mtl("newmtl m\nmap_Kd masked.tga\nmap_d masked.tga\n");
  EXPECT_EQ(both.textures.at(0).encoding, TextureEncoding::image_file) << "one file needs no other";
  EXPECT_EQ(both.materials.at(0).alpha_mode, AlphaMode::test);
  const Model matte = load_mtl("newmtl m\nmap_Kd t.tga\nmap_d -imfchan b masked.tga\n");
  EXPECT_EQ(matte.textures.at(0).bytes.at(3), std::byte{3});
}

TEST_F(ImportMtl, MetallicRoughnessStatements) {
  const Model model = load_mtl(
      "newmtl m\nKa 1 1 1\nKd 1 0.5 0.1\nKs 0.5 0.5 0.5\nNi 1.45\nillum 3\nNs 200\nPr 0.2\nPm 1.0\nPs 0\nPc 0.5\nPcr "
      "0.03\n"
      "aniso 0\nanisor 0\nfoo 1\nfoo 2\n");
  EXPECT_EQ(model.materials.at(0).roughness, 0.2f);
  EXPECT_EQ(model.materials.at(0).metallic, 1.0f);
  EXPECT_EQ(model.notices.size(), 2u);
  EXPECT_TRUE(has_notice(model, "\"pc\""));
  EXPECT_TRUE(has_notice(model, "\"foo\" of m.mtl, first in line 15"));

  write("rough.tga", tga(64, 64, 64));
  write("metal.tga", tga(192, 192, 192));
  write("packed.tga", tga(10, 20, 30));
  const Model maps =
      load_mtl("newmtl m\nPr 0.5\nmap_Pr rough.tga\nmap_Pm metal.tga\nmap_Ke t.tga\nnorm -bm 0.5 t.tga\n");
  const Material& material = maps.materials.at(0);
  EXPECT_EQ(material.roughness, 1.0f) << "a map stands in for its number";
  EXPECT_EQ(material.metallic, 1.0f);
  const Texture& surface = maps.textures.at(material.metallic_roughness_texture);
  EXPECT_EQ(surface.bytes.at(1), std::byte{64});
  EXPECT_EQ(surface.bytes.at(2), std::byte{192});
  EXPECT_FALSE(surface.srgb);
  EXPECT_EQ(material.emissive, (Float3{1, 1, 1}));
  EXPECT_TRUE(maps.textures.at(material.emissive_texture).srgb);
  EXPECT_FALSE(maps.textures.at(material.normal_texture).srgb);
  EXPECT_EQ(material.normal_scale, 0.5f);
  EXPECT_FALSE(maps.parts.at(0).mesh.tangents.empty());
  const Model rough = load_mtl("newmtl m\nmap_Pr rough.tga\n");
  EXPECT_EQ(rough.materials.at(0).metallic, 0.0f);
  const Model packed = load_mtl("newmtl m\nmap_Pr packed.tga\nmap_Pm packed.tga\n");
  EXPECT_EQ(packed.textures.at(0).encoding, TextureEncoding::image_file);
}

TEST_F(ImportMtl, BumpMapsAreNormalMapsWhereTheirTexelsAre) {
  write("blue.tga", tga(128, 120, 254));
  const Model normals = load_mtl("newmtl m\nmap_Bump -bm 0.75 blue.tga\n");
  ASSERT_NE(normals.materials.at(0).normal_texture, kNone);
  EXPECT_EQ(normals.materials.at(0).normal_scale, 0.75f);
  EXPECT_TRUE(has_notice(normals, "map_Bump of material \"m\" as the normal map"));
  for (const int grey : {0, 128, 201, 255}) {
    write("grey.tga", tga(grey, grey, grey));
    const Model heights = load_mtl("newmtl m\nmap_Bump grey.tga\n");
    EXPECT_EQ(heights.materials.at(0).normal_texture, kNone) << grey;
    EXPECT_TRUE(has_notice(heights, "height map of material \"m\""));
  }
  EXPECT_EQ(load_mtl("newmtl m\nbump absent.tga\n").textures.size(), 0u) << "not needed";
}

TEST_F(ImportMtl, LibrariesInEveryWriting) {
  const std::string faces = std::string(kQuad) + "usemtl m\nf 1 2 3 4\n";
  const std::string m = "\xef\xbb\xbfnewmtl m\r\nKd 1 0 0\r\n", x = "newmtl x\nKd 0 1 0\n";
  write("Case.MTL", m);
  write("other.mtl", x);
  write("my mat.mtl", m);
  write("sub/deep.mtl", "newmtl m\nKd 1 0 0\nmap_Kd near.tga\n");
  write("sub/near.tga", tga(1, 1, 1));
  for (const char* line :
       {"mtllib Case.MTL", "mtllib case.mtl", "mtllib my mat.mtl", "mtllib \"my mat.mtl\"", "mtllib other.mtl Case.MTL",
        "mtllib other.mtl my mat.mtl", "mtllib other.mtl\nmtllib case.mtl", "mtllib .\\case.mtl",
        "mtllib absent.mtl case.mtl", "mtllib C:\\x\\case.mtl", "mtllib sub/deep.mtl"}) {
    for (const bool after : {false, true}) {
      const Model model = load_text(after ? faces + line : line + ("\n" + faces));
      const Material& material = model.materials[model.parts.at(0).material];
      EXPECT_EQ(material.name, "m") << line;
      EXPECT_EQ(material.base_colour[0], 1.0f) << line;
    }
  }
  EXPECT_TRUE(has_notice(load_text("mtllib absent.mtl case.mtl\n" + faces), "absent.mtl"));
  const std::string refusal = refusal_of("mtllib gone.mtl other.mtl\n" + faces);
  EXPECT_NE(refusal.find("material file gone.mtl is missing, which material m must be in"), std::string::npos)
      << refusal;
  EXPECT_NE(refusal.find("m.obj, line 1"), std::string::npos) << refusal;
  EXPECT_EQ(refusal_of("mtllib gone.mtl\n" + std::string(kQuad) + "f 1 2 3 4\n"), "") << "no face needs it";
  write("M.mtl", m);
  const Model renamed = load_text("mtllib before.mtl\n" + faces);
  EXPECT_EQ(renamed.materials[renamed.parts.at(0).material].base_colour[0], 1.0f);
  EXPECT_TRUE(has_notice(renamed, "\"M.mtl\" for the material file \"before.mtl\" of line 1"));
}

TEST_F(ImportMtl, UnknownMaterialsAreNoticed) {
  write("m.mtl", "newmtl Material #25\nKd 1 0 0\nnewmtl Material #25\nKd 0 1 0\n");
  const std::string quad = std::string("mtllib m.mtl\n") + kQuad;
  const Model unknown = load_text(quad + "usemtl nobody\nf 1 2 3 4\n");
  EXPECT_EQ(unknown.materials[unknown.parts.at(0).material].name, "nobody");
  EXPECT_TRUE(has_notice(unknown, "usemtl \"nobody\" in line 11"));
  for (const char* name : {"Material #25", "material #25"}) {
    const Model model = load_text(quad + "usemtl " + name + "\nf 1 2 3 4\n");
    EXPECT_EQ(model.materials[model.parts.at(0).material].base_colour[0], 1.0f) << "the first of two of a name";
  }
}

TEST_F(ImportMtl, WrongNumbersOfMaterialsNameLineAndValue) {
  const auto expect = [&](const std::string& mtl, std::initializer_list<const char*> parts) {
    const std::string refusal = refusal_of_mtl(mtl);
    for (const char* part : parts) EXPECT_NE(refusal.find(part), std::string::npos) << part << " in: " << refusal;
  };
  expect("newmtl m\nKd 1 x 0\n", {"\"x\"", "m.mtl, line 2"});
  expect("newmtl m\nNs\n", {"missing", "m.mtl, line 2"});
  expect("newmtl m\nd nan\n", {"\"nan\"", "m.mtl, line 2"});
  EXPECT_EQ(refusal_of_mtl("Kd 1 1 1\nnewmtl m\nKd 0.5\nKd spectral file.rfl\nKs x\n"), "");
}

}  // namespace
}  // namespace subpixel::capture
