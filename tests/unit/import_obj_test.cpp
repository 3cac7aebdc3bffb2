// OBJ and MTL as people's programs write them; what is wrong names file, line and value.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>

#include "capture_format/error.hpp"
#include "capture_format/import/asset_source.hpp"
#include "capture_format/import/model.hpp"
#include "capture_format/import/polygon.hpp"

namespace subpixel::capture {
namespace {

// Red, green, blue and alpha (below 0: no alpha channel) of every texel.
std::string tga(int red, int green, int blue, int alpha = -1, int side = 2) {
  std::string file(18, '\0');
  file[2] = 2;
  file[12] = file[14] = static_cast<char>(side);
  file[16] = alpha < 0 ? 24 : 32;
  file[17] = alpha < 0 ? 0x20 : 0x28;  // top row first; 8 bits of alpha
  for (int i = 0; i < side * side; ++i) {
    for (const int channel : {blue, green, red}) file += static_cast<char>(channel);
    if (alpha >= 0) file += static_cast<char>(alpha);
  }
  return file;
}

constexpr const char* kQuad = R"(v -1 -1 0
v 1 -1 0
v 1 1 0
v -1 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 0 1
)";

class ImportObj : public testing::Test {
 protected:
  ImportObj() : folder_(std::filesystem::path(testing::TempDir()) / ("import_obj_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    write("t.tga", tga(200, 100, 50));
  }
  ~ImportObj() override { std::filesystem::remove_all(folder_); }

  void write(const std::string& name, const std::string& content) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << content;
  }

  Model load(const std::string& name) const { return load_model(*open_folder(folder_), name); }

  Model load_text(const std::string& obj) const {
    write("m.obj", obj);
    return load("m.obj");
  }

  // A quad of the material that `mtl` defines as m.
  Model load_mtl(const std::string& mtl) const {
    write("m.mtl", mtl);
    return load_text(std::string("mtllib m.mtl\n") + kQuad + "usemtl m\nf 1/1/1 2/2/1 3/3/1 4/4/1\n");
  }

  Material material_of(const std::string& mtl) const { return load_mtl(mtl).materials.at(0); }

  std::string refusal_of(const std::string& obj) const {
    try {
      load_text(obj);
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  }

  std::string refusal_of_mtl(const std::string& mtl) const {
    try {
      load_mtl(mtl);
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  }

  std::filesystem::path folder_;
};

void expect_quad(const Model& model) {
  ASSERT_EQ(model.parts.size(), 1u);
  const Mesh& mesh = model.parts[0].mesh;
  EXPECT_EQ(mesh.triangle_count(), 2u);
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(model.low, glm::dvec3(-1, -1, 0));
  EXPECT_EQ(model.high, glm::dvec3(1, 1, 0));
  for (const glm::dvec3& normal : mesh.normals) EXPECT_NEAR(normal.z, 1, 1e-12);
}

bool has_notice(const Model& model, const std::string& part) {
  return std::any_of(model.notices.begin(), model.notices.end(),
                     [&](const std::string& notice) { return notice.find(part) != std::string::npos; });
}

TEST_F(ImportObj, FacesInEveryWriting) {
  expect_quad(load_text(std::string(kQuad) + "f 1/1/1 2/2/1 3/3/1 4/4/1"));  // no final newline
  expect_quad(load_text(std::string(kQuad) + "f -4/-4/-1 -3/-3/-1 -2/-2/-1 -1/-1/-1\n"));
  expect_quad(load_text(std::string(kQuad) + "f 1//1 2//1 3//1 4//1\n"));
  expect_quad(load_text(std::string(kQuad) + "f 1/1 2/2 3/3 4/4 # a quad\n"));
  expect_quad(load_text(std::string(kQuad) + "f\t1 2\t3 4  \n"));
  expect_quad(load_text(std::string(kQuad) + "f 1/1/ 2/2/ 3// 4//\n"));
  expect_quad(load_text(std::string(kQuad) + "f 1/1/1 2/2/1 \\\n3/3/1 \\\r\n 4/4/1\n"));
  expect_quad(load_text("f 1 2 3 4\n" + std::string(kQuad)));  // before its positions
  expect_quad(load_text("v -2 -2 0 2\nv 2 -2 0 2\nv 1e0 +1.0 0 1\nv -1 1. -.0E2\nf 1 2 3 4"));
  expect_quad(load_text(std::string(kQuad) + "g a\ng b\nf 1 2 3 4\ng c\n"));
  expect_quad(load_text(std::string(kQuad) + "v 1000 1000 1000\nf 1 2 3 4\n"));
}

TEST_F(ImportObj, LineEndsAndMarksOfEverySystem) {
  std::string text = "\xef\xbb\xbf" + std::string(kQuad) + "# a path C:\\\nf 1 2 3 4\n";
  expect_quad(load_text(text));
  std::string carriage = text, both;
  std::replace(carriage.begin(), carriage.end(), '\n', '\r');
  for (const char c : text) both += c == '\n' ? "\r\n" : std::string(1, c);
  expect_quad(load_text(carriage));
  expect_quad(load_text(both));
  write("UPPER.OBJ", text);
  expect_quad(load("UPPER.OBJ"));
}

TEST_F(ImportObj, NormalsThatAreNoneAreMade) {
  const std::string positions = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
  for (const char* normal : {"0 0 0", "nan nan nan", "-1.#IND -1.#IND -1.#IND", "-nan(ind) 0 0", "0 0 inf"}) {
    const Model model = load_text(positions + "vn " + normal + "\nf 1//1 2//1 3//1\n");
    for (const glm::dvec3& n : model.parts.at(0).mesh.normals) EXPECT_EQ(n, glm::dvec3(0, 0, 1)) << normal;
  }
}

TEST_F(ImportObj, ConcaveFacesAreFilledOnce) {
  const Model model = load_text("v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv 0 -0.5 0\nv -1 1 0\nf 1 2 3 4 5\n");
  const Mesh& mesh = model.parts.at(0).mesh;
  ASSERT_EQ(mesh.triangle_count(), 3u);
  double area = 0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const glm::dvec3 a = mesh.positions[mesh.indices[i]];
    const glm::dvec3 turned =
        glm::cross(mesh.positions[mesh.indices[i + 1]] - a, mesh.positions[mesh.indices[i + 2]] - a);
    EXPECT_GT(turned.z, 0);
    area += turned.z / 2;
  }
  EXPECT_NEAR(area, 2.5, 1e-12);
}

TEST_F(ImportObj, PolygonsOfEveryKindHaveAllTheirTriangles) {
  // A comb, whose teeth need ears in the right order; turned, and far from the origin.
  std::vector<glm::dvec3> comb{{0, 0, 0}, {20, 0, 0}};
  for (int tooth = 9; tooth >= 0; --tooth) {
    comb.emplace_back(2 * tooth + 1.5, 5, 0);
    comb.emplace_back(2 * tooth + 0.5, 1, 0);
  }
  double expected = 0;
  for (std::size_t i = 0; i < comb.size(); ++i) expected += glm::cross(comb[i], comb[(i + 1) % comb.size()]).z / 2;
  for (const bool turned : {false, true}) {
    std::vector<glm::dvec3> polygon;
    for (const glm::dvec3& p : comb) polygon.push_back(turned ? glm::dvec3(1e6, p.y, p.x) : p);
    std::vector<std::uint32_t> triangles;
    ASSERT_TRUE(triangulate(polygon, triangles));
    ASSERT_EQ(triangles.size(), 3 * (comb.size() - 2));
    double area = 0;
    for (std::size_t i = 0; i < triangles.size(); i += 3) {
      const glm::dvec3 &a = polygon[triangles[i]], &b = polygon[triangles[i + 1]], &c = polygon[triangles[i + 2]];
      const glm::dvec3 cross = glm::cross(b - a, c - a);
      EXPECT_GE(turned ? -cross.x : cross.z, 0);
      area += glm::length(cross) / 2;
    }
    EXPECT_NEAR(area, expected, 1e-6);
  }
  for (const std::vector<glm::dvec3>& odd :
       {std::vector<glm::dvec3>(7, glm::dvec3(1)),
        std::vector<glm::dvec3>{{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}, {2, 2, 0}},
        std::vector<glm::dvec3>{{1e38, 0, 0}, {-1e38, 0, 0}, {0, 1e38, 0}, {0, 0, 0}}}) {
    std::vector<std::uint32_t> triangles;
    EXPECT_TRUE(triangulate(odd, triangles));
    EXPECT_EQ(triangles.size(), 3 * (odd.size() - 2));
  }
  std::vector<glm::dvec3> large{{0, -1, 0}, {kMaxConcaveCorners, -1, 0}};
  for (std::size_t i = kMaxConcaveCorners; i > 0; --i) large.emplace_back(i, i % 2 == 0 ? 0 : 1, 0);
  std::vector<std::uint32_t> triangles;
  EXPECT_FALSE(triangulate(large, triangles));
  EXPECT_TRUE(triangles.empty());
}

TEST_F(ImportObj, ColoursOfPositionsAreSrgb) {
  const std::string faces = "f 1 2 3\n";
  const Model model = load_text("v 0 0 0 1 0 0\nv 1 0 0 0.5 0.5 0.5 1\nv 0 1 0\n" + faces);
  const std::vector<glm::vec4>& colours = model.parts.at(0).mesh.colours;
  ASSERT_EQ(colours.size(), 3u);
  EXPECT_EQ(colours[0], glm::vec4(1, 0, 0, 1));
  EXPECT_NEAR(colours[1].g, 0.2140, 1e-3);
  EXPECT_EQ(colours[2], glm::vec4(1, 1, 1, 1)) << "one without a colour among others";
  EXPECT_EQ(model.materials.at(0).base_colour[0], 1.0f) << "colours are all that there is";
  const Model bytes = load_text("v 0 0 0 255 0 0\nv 1 0 0 255 0 0\nv 0 1 0 0 0 255\n" + faces);
  EXPECT_EQ(bytes.parts.at(0).mesh.colours.at(2), glm::vec4(0, 0, 1, 1));
  EXPECT_TRUE(load_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + faces).parts.at(0).mesh.colours.empty());
}

TEST_F(ImportObj, PartsAreObjectsByMaterial) {
  write("m.mtl", "newmtl a\nKd 1 0 0\nnewmtl unused\nnewmtl b\n");
  const std::string quad = kQuad;
  const Model model =
      load_text("mtllib m.mtl\n" + quad +
                "f 1 2 3\no door\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl a\nf 3 4 1\ng knob\nf 1 2 4\n");
  ASSERT_EQ(model.parts.size(), 4u);
  EXPECT_EQ(model.parts[0].name, "m");
  EXPECT_EQ(model.materials[model.parts[0].material].name, "DefaultMaterial");
  EXPECT_EQ(model.parts[1].name, "door");
  EXPECT_EQ(model.parts[1].mesh.triangle_count(), 2u);
  EXPECT_EQ(model.materials[model.parts[2].material].name, "b");
  EXPECT_EQ(model.parts[3].name, "knob");
  ASSERT_EQ(model.materials.size(), 4u);
  EXPECT_EQ(model.materials[1].name, "unused") << "descriptions may name it";
}

TEST_F(ImportObj, ABodyOfTwoMaterialsHasNoSeam) {
  write("m.mtl", "newmtl a\nnewmtl b\n");
  // Two quads that meet at an angle of 20 degrees along y.
  const Model model = load_text(
      "mtllib m.mtl\nv -1 0 0\nv 0 0 0.1763\nv 1 0 0\nv -1 1 0\nv 0 1 0.1763\nv 1 1 0\n"
      "usemtl a\nf 1 2 5 4\nusemtl b\nf 2 3 6 5\n");
  ASSERT_EQ(model.parts.size(), 2u);
  for (const ModelPart& part : model.parts) {
    for (std::size_t i = 0; i < part.mesh.positions.size(); ++i) {
      if (part.mesh.positions[i].x == 0) {
        EXPECT_NEAR(part.mesh.normals[i].z, 1, 1e-9);
      }
    }
  }
}

TEST_F(ImportObj, SmoothingGroupsAreFollowed) {
  const std::string roof = "v -1 0 0\nv 0 0 0.1763\nv 1 0 0\nv -1 1 0\nv 0 1 0.1763\nv 1 1 0\n";
  const auto vertices = [&](const std::string& smoothing) {
    return load_text(roof + smoothing + "f 1 2 5 4\nf 2 3 6 5\n").parts.at(0).mesh.positions.size();
  };
  EXPECT_EQ(vertices(""), 6u);
  EXPECT_EQ(vertices("s 1\n"), 6u);
  EXPECT_EQ(vertices("s off\n"), 8u);
  EXPECT_EQ(vertices("s 0\n"), 8u);
}

TEST_F(ImportObj, WhatIsWrongNamesLineAndValue) {
  const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const auto expect = [&](const std::string& obj, std::initializer_list<const char*> parts) {
    const std::string refusal = refusal_of(obj);
    for (const char* part : parts) EXPECT_NE(refusal.find(part), std::string::npos) << part << " in: " << refusal;
  };
  expect(three + "f 1 2 9\n", {"\"9\"", "position", "3", "m.obj, line 4"});
  expect(three + "f 1 2 -4\n", {"\"-4\"", "m.obj, line 4"});
  expect(three + "f 1 2 0\n", {"\"0\"", "m.obj, line 4"});
  expect(three + "f 1/1 2/1 3/1\n", {"texture coordinate", "m.obj, line 4"});
  expect(three + "f 1//2 2//2 3//2\nvn 0 0 1\n", {"normal", "line 4"});
  expect(three + "f 1 2 99999999999999999999\n", {"99999999999999999999", "line 4"});
  expect(three + "f 1 2 x\n", {"\"x\"", "line 4"});
  expect(three + "f 1/1/1/1 2 3\n", {"\"1/1/1/1\"", "line 4"});
  expect("v 0 nan 0\n" + three, {"\"nan\"", "not finite", "line 1"});
  expect("v 0 0\n", {"2 coordinates", "line 1"});
  expect("v 0 0,5 0\n", {"\"0,5\"", "line 1"});
  expect("v 0 1e39 0\n", {"\"1e39\"", "line 1"});
  expect("v 0 1e999 0\n", {"\"1e999\"", "line 1"});
  expect("v 0 0 0 0\n", {"weight", "line 1"});
  expect("vt x\n", {"\"x\"", "line 1"});
  expect(three, {"no faces", "m.obj"});
  expect("", {"no faces"});
  expect("\xff\xfev", {"UTF-16"});
  expect(three + std::string("\0binary", 7), {"no text", "line 4"});
  expect(three + "f 1 2\n", {"no faces"});
  EXPECT_EQ(refusal_of(three + "f 1 2\nf 1 2 3\n"), "");
  EXPECT_EQ(refusal_of("v 1e-400 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3"), "") << "too small is 0";
}

TEST_F(ImportObj, OtherStatementsAreNoticedOnce) {
  const Model model = load_text(std::string(kQuad) + "l 1 2\nl 2 3\ncurv 0 1 1 2\nf 1 2 3 4\n");
  EXPECT_EQ(model.notices.size(), 2u);
  EXPECT_TRUE(has_notice(model, "\"l\" of OBJ, first in line 10"));
}

TEST_F(ImportObj, TextureNamesInEverySpelling) {
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

TEST_F(ImportObj, OptionsOfMapsSetMappingAndSampler) {
  const Model model = load_mtl("newmtl m\nmap_Kd -s 2 3 1 -o 0.25 0.5 -clamp on t.tga\n");
  const Material& material = model.materials.at(0);
  // (u, v upwards) = (1, 1) is read at (2 + 0.25, 3 + 0.5) upwards.
  EXPECT_EQ(material.base_colour_uv.matrix, (std::array<float, 6>{2, 0, 0.25f, 0, 3, 1 - 3 - 0.5f}));
  EXPECT_EQ(model.textures.at(0).sampler.wrap_u, Wrap::clamp_to_edge);
  EXPECT_EQ(model.textures.at(0).sampler.wrap_v, Wrap::clamp_to_edge);
  EXPECT_EQ(load_mtl("newmtl m\nmap_Kd t.tga\n").textures.at(0).sampler, Sampler{});
}

TEST_F(ImportObj, MissingTexturesMatterOfUsedMaterials) {
  const Model model = load_mtl("newmtl m\nmap_Kd t.tga\nnewmtl old\nmap_Kd absent.tga\n");
  EXPECT_EQ(model.materials.size(), 2u);
  EXPECT_EQ(model.textures.size(), 1u);
  const std::string refusal = refusal_of_mtl("newmtl m\nKd 1 1 1\nmap_Kd C:\\away\\absent.tga\n");
  EXPECT_NE(refusal.find("texture C:\\away\\absent.tga of material m is missing"), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("m.mtl, line 3"), std::string::npos) << refusal;
}

TEST_F(ImportObj, OpacityByDAndByTr) {
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

TEST_F(ImportObj, AlphaOfAMapAlone) {
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

TEST_F(ImportObj, MetallicRoughnessStatements) {
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

TEST_F(ImportObj, BumpMapsAreNormalMapsWhereTheirTexelsAre) {
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

TEST_F(ImportObj, LibrariesInEveryWriting) {
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
}

TEST_F(ImportObj, UnknownMaterialsAreNoticed) {
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

TEST_F(ImportObj, WrongNumbersOfMaterialsNameLineAndValue) {
  const auto expect = [&](const std::string& mtl, std::initializer_list<const char*> parts) {
    const std::string refusal = refusal_of_mtl(mtl);
    for (const char* part : parts) EXPECT_NE(refusal.find(part), std::string::npos) << part << " in: " << refusal;
  };
  expect("newmtl m\nKd 1 x 0\n", {"\"x\"", "m.mtl, line 2"});
  expect("newmtl m\nNs\n", {"missing", "m.mtl, line 2"});
  expect("newmtl m\nd nan\n", {"\"nan\"", "m.mtl, line 2"});
  EXPECT_EQ(refusal_of_mtl("Kd 1 1 1\nnewmtl m\nKd 0.5\nKd spectral file.rfl\nKs x\n"), "");
}

TEST_F(ImportObj, MergingKeepsColoursAndTurnsMirrorImages) {
  Model model = load_text("v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nf 1 2 3\n");
  ModelPart& part = model.parts.at(0);
  part.mesh.uvs2 = {{0, 0}, {0.25, 0}, {0, 0.5}};
  glm::dmat4 mirrored(1.0);
  mirrored[0][0] = -2;
  part.placements = {glm::dmat4(1.0), mirrored};
  ModelPart plain = part;
  plain.mesh.colours.clear();
  plain.mesh.uvs2.clear();
  plain.placements = {glm::dmat4(0.0)};  // flattened to a point
  model.parts.push_back(plain);
  merge_parts(model);
  ASSERT_EQ(model.parts.size(), 1u);
  const Mesh& mesh = model.parts[0].mesh;
  ASSERT_EQ(mesh.positions.size(), 9u);
  ASSERT_EQ(mesh.colours.size(), 9u);
  ASSERT_EQ(mesh.uvs2.size(), 9u);
  EXPECT_EQ(mesh.colours[4], glm::vec4(1, 0, 0, 1));
  EXPECT_EQ(mesh.colours[8], glm::vec4(1, 1, 1, 1));
  EXPECT_EQ(mesh.uvs2[5], glm::dvec2(0, 0.5));
  for (std::size_t t = 0; t < 2; ++t) {
    const glm::dvec3 a = mesh.positions[mesh.indices[3 * t]];
    const glm::dvec3 turned =
        glm::cross(mesh.positions[mesh.indices[3 * t + 1]] - a, mesh.positions[mesh.indices[3 * t + 2]] - a);
    EXPECT_GT(turned.z, 0) << "the front stays in front";
    EXPECT_EQ(mesh.normals[mesh.indices[3 * t]], glm::dvec3(0, 0, 1));
  }
  for (const glm::dvec3& normal : mesh.normals) EXPECT_NEAR(glm::length(normal), 1, 1e-12);
}

}  // namespace
}  // namespace subpixel::capture
