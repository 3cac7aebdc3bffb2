// OBJ as people's programs write it; what is wrong names file, line and value.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "scenes/import/polygon.hpp"
#include "tests/unit/obj_fixture.hpp"

namespace subpixel::capture {
namespace {

class ImportObj : public ObjFixture {};

void expect_quad(const Model& model) {
  ASSERT_EQ(model.parts.size(), 1u);
  const Mesh& mesh = model.parts[0].mesh;
  EXPECT_EQ(mesh.triangle_count(), 2u);
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(model.low, glm::dvec3(-1, -1, 0));
  EXPECT_EQ(model.high, glm::dvec3(1, 1, 0));
  for (const glm::dvec3& normal : mesh.normals) EXPECT_NEAR(normal.z, 1, 1e-12);
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
  expect(std::string("v\0 \0001\0\n\0", 8), {"its text is UTF-16; only UTF-8 and the like can be read"});
  expect(std::string("\0#\0\n", 4), {"UTF-16"});
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
