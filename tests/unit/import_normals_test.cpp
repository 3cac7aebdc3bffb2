// Normals that a model file lacks: flat ones, and smooth ones broken at creases.
#include "scenes/import/normals.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <set>

#include "scenes/builder/camera.hpp"

namespace subpixel::capture {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// A cube of eight shared vertices, two triangles a side, without normals.
Mesh cube() {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.emplace_back(i & 4 ? 1 : -1, i & 2 ? 1 : -1, i & 1 ? 1 : -1);
    mesh.uvs.emplace_back(i, 0);
  }
  const int sides[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
  for (const auto& [a, b, c, d] : sides) {
    mesh.indices.insert(mesh.indices.end(), {std::uint32_t(a), std::uint32_t(b), std::uint32_t(c)});
    mesh.indices.insert(mesh.indices.end(), {std::uint32_t(a), std::uint32_t(c), std::uint32_t(d)});
  }
  return mesh;
}

// The unit prism's mantle of `sides` around y, every corner a vertex of its own, as STL has them.
Mesh mantle(std::uint32_t sides) {
  Mesh mesh;
  const auto at = [&](std::uint32_t side, double y) {
    const double angle = 2 * kPi * (side % sides) / sides;
    return glm::dvec3(sine(angle), y, cosine(angle));
  };
  for (std::uint32_t s = 0; s < sides; ++s) {
    for (const glm::dvec3& p : {at(s, 0), at(s + 1, 0), at(s + 1, 1), at(s, 0), at(s + 1, 1), at(s, 1)}) {
      mesh.indices.push_back(static_cast<std::uint32_t>(mesh.positions.size()));
      mesh.positions.push_back(p);
      mesh.uvs.emplace_back(0, 0);
    }
  }
  return mesh;
}

glm::dvec3 face_normal(const Mesh& mesh, std::size_t triangle) {
  const auto at = [&](std::size_t corner) { return mesh.positions[mesh.indices[3 * triangle + corner]]; };
  return glm::normalize(glm::cross(at(1) - at(0), at(2) - at(0)));
}

void expect_flat(const Mesh& mesh) {
  for (std::size_t corner = 0; corner < mesh.indices.size(); ++corner) {
    EXPECT_NEAR(glm::dot(mesh.normals[mesh.indices[corner]], face_normal(mesh, corner / 3)), 1, 1e-12) << corner;
  }
}

TEST(ImportNormals, ACubeOfEightVerticesHasHardEdges) {
  Mesh mesh = cube();
  make_missing_normals(mesh);
  expect_flat(mesh);
  EXPECT_EQ(mesh.positions.size(), 24u) << "two triangles of a side share what they can";
}

TEST(ImportNormals, ATubeOfTenSidesIsRoundAndOneOfEightIsNot) {
  Mesh round = mantle(10);
  make_missing_normals(round);
  EXPECT_EQ(round.positions.size(), 60u);
  for (std::size_t i = 0; i < round.positions.size(); ++i) {
    const glm::dvec3 radial(round.positions[i].x, 0, round.positions[i].z);
    EXPECT_NEAR(glm::dot(round.normals[i], radial), 1, 1e-12) << "the angle, not the triangle count, is the weight";
  }
  Mesh edged = mantle(8);
  make_missing_normals(edged);
  expect_flat(edged);
}

TEST(ImportNormals, ASphereStaysSmooth) {
  Mesh mesh;
  add_sphere(mesh, {5, 6, 7}, 2, 12);
  const std::size_t vertices = mesh.positions.size();
  mesh.normals.clear();
  make_missing_normals(mesh);
  EXPECT_EQ(mesh.positions.size(), vertices);
  std::set<std::uint32_t> used(mesh.indices.begin(), mesh.indices.end());
  for (const std::uint32_t i : used) {
    EXPECT_GT(glm::dot(mesh.normals[i], (mesh.positions[i] - glm::dvec3(5, 6, 7)) / 2.0), 0.999) << i;
  }
}

TEST(ImportNormals, ThoseGivenStayAndOnlyTheLackingAreMade) {
  Mesh mesh = cube();
  mesh.normals.assign(8, glm::dvec3(0, 0, 3));
  mesh.normals[0] = {0, 0, 0};
  mesh.normals[7] = {kNan, 0, 1};
  const std::vector<std::uint32_t> sources = make_missing_normals(mesh);
  EXPECT_EQ(mesh.positions.size(), 12u) << "two of the cube's corners are split in three";
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    if (sources[i] != 0 && sources[i] != 7) {
      EXPECT_EQ(mesh.normals[i], glm::dvec3(0, 0, 1)) << i;
    }
    EXPECT_NEAR(glm::length(mesh.normals[i]), 1, 1e-12);
  }
}

TEST(ImportNormals, CopiesKeepEveryAttribute) {
  Mesh mesh = cube();
  for (int i = 0; i < 8; ++i) {
    mesh.uvs2.emplace_back(0, i);
    mesh.colours.emplace_back(i, 0, 0, 1);
    mesh.tangents.emplace_back(1, 0, 0, i);
  }
  const std::vector<std::uint32_t> sources = make_flat_normals(mesh);
  expect_flat(mesh);
  ASSERT_EQ(sources.size(), mesh.positions.size());
  const Mesh before = cube();
  for (std::size_t i = 0; i < sources.size(); ++i) {
    EXPECT_EQ(mesh.positions[i], before.positions[sources[i]]);
    EXPECT_EQ(mesh.uvs.at(i).x, sources[i]);
    EXPECT_EQ(mesh.uvs2.at(i).y, sources[i]);
    EXPECT_EQ(mesh.colours.at(i).x, static_cast<float>(sources[i]));
    EXPECT_EQ(mesh.tangents.at(i).w, sources[i]);
    if (i < 8) {
      EXPECT_EQ(sources[i], i);
    }
  }
}

TEST(ImportNormals, FlatOnesReplaceWhatIsThere) {
  Mesh mesh = cube();
  mesh.normals.assign(8, glm::dvec3(0, 0, 1));
  make_flat_normals(mesh);
  expect_flat(mesh);
}

TEST(ImportNormals, SmoothingGroupsWinOverTheAngle) {
  Mesh round = mantle(6);
  make_missing_normals(round, std::vector<SmoothingGroup>(12, 1));
  for (std::size_t i = 0; i < round.positions.size(); ++i) {
    EXPECT_NEAR(glm::dot(round.normals[i], glm::dvec3(round.positions[i].x, 0, round.positions[i].z)), 1, 1e-12);
  }
  Mesh edged = cube();
  make_missing_normals(edged, std::vector<SmoothingGroup>(12, 1));
  expect_flat(edged);  // exporters put everything into one group
  Mesh off = mantle(16);
  make_missing_normals(off, std::vector<SmoothingGroup>(32, 0));
  expect_flat(off);
  Mesh two = mantle(16);
  std::vector<SmoothingGroup> groups(32, 1);
  for (std::size_t t = 16; t < 32; ++t) groups[t] = 2;
  make_missing_normals(two, groups);
  EXPECT_NEAR(glm::dot(two.normals[two.indices[0]], face_normal(two, 0)), 1, 1e-12) << "another group is beyond";
  EXPECT_LT(glm::dot(two.normals[two.indices[1]], face_normal(two, 0)), 0.99);
}

TEST(ImportNormals, TrianglesWithoutAnAreaDoNoHarm) {
  Mesh mesh = cube();
  for (const std::uint32_t index : {0, 0, 1, 2, 2, 2, 8, 0, 7}) mesh.indices.push_back(index);
  mesh.positions.emplace_back(kNan, 0, 0);
  mesh.positions.emplace_back(9, 9, 9);  // no triangle's
  mesh.uvs.resize(10);
  make_missing_normals(mesh);
  EXPECT_EQ(mesh.positions.size(), 26u);
  for (const glm::dvec3& normal : mesh.normals) EXPECT_NEAR(glm::length(normal), 1, 1e-12);
  Mesh nothing;
  EXPECT_TRUE(make_missing_normals(nothing).empty());
  EXPECT_TRUE(make_flat_normals(nothing).empty());
}

TEST(ImportNormals, SizesOfAnyScaleHaveThem) {
  for (const double scale : {1e-200, 1e-30, 1e30, 1e200}) {
    Mesh mesh = mantle(4);
    for (glm::dvec3& position : mesh.positions) position *= scale;
    Mesh flat = mesh;
    make_missing_normals(mesh);
    make_flat_normals(flat);
    for (const glm::dvec3& normal : mesh.normals) EXPECT_NEAR(std::abs(normal.x), std::sqrt(0.5), 1e-9) << scale;
    for (const glm::dvec3& normal : flat.normals) EXPECT_NEAR(std::abs(normal.x), std::sqrt(0.5), 1e-9) << scale;
  }
}

TEST(ImportNormals, ThousandsOfTrianglesAtOneEdgeTakeNoSquareOfThem) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {0, 1, 0}};
  for (std::uint32_t i = 0; i < 200000; ++i) {
    const double angle = i * 1e-5;
    mesh.positions.emplace_back(cosine(angle), 0, sine(angle));
    mesh.indices.insert(mesh.indices.end(), {0, 1, i + 2});
  }
  make_missing_normals(mesh);
  EXPECT_EQ(mesh.normals.size(), mesh.positions.size());
}

}  // namespace
}  // namespace subpixel::capture
