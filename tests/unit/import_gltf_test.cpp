// glTF geometry, nodes, cameras, lights and animations; what is wrong in a file is named.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <cmath>
#include <functional>
#include <random>

#include "base/error.hpp"
#include "capture_format/writer.hpp"
#include "scenes/builder/camera.hpp"
#include "scenes/import/import.hpp"
#include "scenes/import/model.hpp"
#include "tests/unit/gltf_builder.hpp"

namespace subpixel::capture {
namespace {

class ImportGltf : public testing::Test {
 protected:
  Model load(const GltfBuilder& from) { return load_text(from.text()); }
  Model load_text(const std::string& text, const std::string& name = "model.gltf") {
    folder_.write(name, text);
    return load_model(*open_folder(folder_.path()), name);
  }
  std::string refusal_of(const std::string& text, const std::string& name = "model.gltf") {
    try {
      load_text(text, name);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  // A triangle is drawn by the builder's first mesh; `change` breaks or extends the document.
  GltfBuilder with(const std::function<void(GltfBuilder&)>& change) {
    GltfBuilder builder;
    builder.draw(json::array({builder.triangle()}));
    change(builder);
    return builder;
  }

  ScratchFolder folder_;
};

TEST_F(ImportGltf, AccessorsOfEveryTypeGiveTheirValues) {
  const auto position_of = [&](std::size_t accessor, GltfBuilder& builder) {
    builder.draw(json::array({{{"attributes", {{"POSITION", accessor}}}}}));
    return load(builder).parts.at(0).mesh.positions.at(1);
  };
  {
    GltfBuilder b;
    EXPECT_EQ(position_of(b.add<std::int8_t>("VEC3", {0, 0, 0, 127, -128, 0, 0, 127, 0}, true), b),
              glm::dvec3(1, -1, 0));
  }
  {
    GltfBuilder b;
    EXPECT_EQ(position_of(b.add<std::uint8_t>("VEC3", {0, 0, 0, 255, 51, 0, 0, 9, 0}, true), b), glm::dvec3(1, 0.2, 0));
  }
  {
    GltfBuilder b;
    EXPECT_EQ(position_of(b.add<std::int16_t>("VEC3", {0, 0, 0, 300, -7, 2, 0, 9, 0}), b), glm::dvec3(300, -7, 2));
  }
  {
    GltfBuilder b;
    EXPECT_EQ(position_of(b.add<std::uint16_t>("VEC3", {0, 0, 0, 65535, 0, 0, 0, 9, 0}, true), b), glm::dvec3(1, 0, 0));
  }
  {  // stride and offset: elements of 12 bytes at every 16, after 4 bytes
    GltfBuilder b;
    const std::size_t accessor = b.add<float>("VEC3", {9, 0, 0, 0, 9, 1, 2, 3, 9, 0, 1, 0});
    b.document["bufferViews"][0]["byteStride"] = 16;
    b.document["accessors"][0]["byteOffset"] = 4;
    b.document["accessors"][0]["count"] = 3;
    EXPECT_EQ(position_of(accessor, b), glm::dvec3(1, 2, 3));
  }
}

TEST_F(ImportGltf, SparseAccessorsReplaceElements) {
  for (const bool has_base : {true, false}) {
    GltfBuilder b;
    const std::size_t accessor = b.add<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
    const std::size_t places = b.add_view<std::uint16_t>({1, 2}), values = b.add_view<float>({5, 0, 0, 0, 6, 0});
    b.document["accessors"][accessor]["sparse"] = {{"count", 2},
                                                   {"indices", {{"bufferView", places}, {"componentType", 5123}}},
                                                   {"values", {{"bufferView", values}}}};
    if (!has_base) b.document["accessors"][accessor].erase("bufferView");
    b.draw(json::array({{{"attributes", {{"POSITION", accessor}}}}}));
    const Mesh mesh = load(b).parts.at(0).mesh;
    EXPECT_EQ(mesh.positions[0], glm::dvec3(0, 0, 0));
    EXPECT_EQ(mesh.positions[1], glm::dvec3(5, 0, 0));
    EXPECT_EQ(mesh.positions[2], glm::dvec3(0, 6, 0));
    b.document["accessors"][accessor]["count"] = 2;
    EXPECT_NE(refusal_of(b.text()).find("sparse.indices"), std::string::npos);
  }
}

TEST_F(ImportGltf, StripsFansAndIndicesOfEverySizeAreTriangles) {
  const std::vector<float> square{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
  const auto triangles = [&](int mode, const std::function<json(GltfBuilder&)>& indices) {
    GltfBuilder b;
    json primitive = {{"attributes", {{"POSITION", b.add<float>("VEC3", square)}}}, {"mode", mode}};
    if (const json accessor = indices(b); !accessor.is_null()) primitive["indices"] = accessor;
    b.draw(json::array({primitive}));
    return load(b).parts.at(0).mesh.indices;
  };
  using Corners = std::vector<std::uint32_t>;
  EXPECT_EQ(triangles(5, [](GltfBuilder&) { return json(); }), (Corners{0, 1, 2, 1, 3, 2}));
  EXPECT_EQ(triangles(6,
                      [](GltfBuilder& b) {
                        return json(b.add<std::uint8_t>("SCALAR", {0, 1, 3, 2}));
                      }),
            (Corners{1, 3, 0, 3, 2, 0}));
  EXPECT_EQ(triangles(4,
                      [](GltfBuilder& b) {
                        return json(b.add<std::uint16_t>("SCALAR", {0, 1, 3}));
                      }),
            (Corners{0, 1, 3}));
  EXPECT_EQ(triangles(4,
                      [](GltfBuilder& b) {
                        return json(b.add<std::uint32_t>("SCALAR", {2, 1, 3}));
                      }),
            (Corners{2, 1, 3}));
}

TEST_F(ImportGltf, PointsAndLinesAreLeftOutAloud) {
  const Model model = load(with([](GltfBuilder& b) {
    json lines = b.triangle();
    lines["mode"] = 1;
    b.document["meshes"][0]["primitives"].push_back(lines);
  }));
  EXPECT_EQ(model.parts.size(), 1u);
  ASSERT_EQ(model.notices.size(), 1u);
  EXPECT_EQ(model.notices[0], "ignored: 1 primitives of points or lines");
}

TEST_F(ImportGltf, NormalsThatLackAreFlat) {
  GltfBuilder b;  // two faces of a box share an edge's vertices
  const std::size_t positions = b.add<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, -1});
  const std::size_t indices = b.add<std::uint16_t>("SCALAR", {0, 1, 2, 0, 2, 3});
  b.draw(json::array({{{"attributes", {{"POSITION", positions}}}, {"indices", indices}}}));
  const Mesh mesh = load(b).parts.at(0).mesh;
  ASSERT_EQ(mesh.triangle_count(), 2u);
  for (int corner = 0; corner < 3; ++corner) {
    EXPECT_EQ(mesh.normals[mesh.indices[static_cast<std::size_t>(corner)]], glm::dvec3(0, 0, 1));
    EXPECT_EQ(mesh.normals[mesh.indices[static_cast<std::size_t>(3 + corner)]], glm::dvec3(-1, 0, 0));
  }
}

TEST_F(ImportGltf, VertexColoursOfEveryTypeAreKept) {
  const auto colour = [&](const std::function<std::size_t(GltfBuilder&)>& add) {
    return load(with([&](GltfBuilder& b) {
             b.document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = add(b);
           }))
        .parts.at(0)
        .mesh.colours.at(1);
  };
  EXPECT_EQ(colour([](GltfBuilder& b) {
              return b.add<float>("VEC3", {0, 0, 0, 0.25f, 0.5f, 1, 0, 0, 0});
            }),
            glm::vec4(0.25f, 0.5f, 1, 1));
  EXPECT_EQ(colour([](GltfBuilder& b) {
              return b.add<std::uint8_t>("VEC4", {0, 0, 0, 0, 255, 51, 0, 102, 0, 0, 0, 0}, true);
            }),
            glm::vec4(1, 0.2f, 0, 0.4f));
}

TEST_F(ImportGltf, MatricesAndPartsOfTransformsPlaceAlike) {
  GltfBuilder parts = with([](GltfBuilder& b) {
    b.document["nodes"][0]["translation"] = {1, 2, 3};
    b.document["nodes"][0]["rotation"] = {0, 0, std::sqrt(0.5), std::sqrt(0.5)};  // a quarter turn about z
    b.document["nodes"][0]["scale"] = {2, 3, -4};
  });
  GltfBuilder matrix = with(
      [](GltfBuilder& b) { b.document["nodes"][0]["matrix"] = {0, 2, 0, 0, -3, 0, 0, 0, 0, 0, -4, 0, 1, 2, 3, 1}; });
  const glm::dmat4 a = load(parts).parts.at(0).placements.at(0), b = load(matrix).parts.at(0).placements.at(0);
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 4; ++r) EXPECT_NEAR(a[c][r], b[c][r], 1e-12);
  }
}

TEST_F(ImportGltf, ScenesAreChosenAndTreesAreFollowed) {
  GltfBuilder b = with([](GltfBuilder& builder) {
    builder.push("nodes", {{"children", {0}}, {"translation", {0, 0, 7}}});
    builder.push("nodes", {{"children", {0}}, {"translation", {0, 0, 9}}});
    builder.document["scenes"].push_back({{"nodes", {1, 2}}});
    builder.document["scene"] = 1;
  });
  const Model model = load(b);
  ASSERT_EQ(model.parts.at(0).placements.size(), 2u) << "a node may be the child of two";
  EXPECT_EQ(model.parts[0].placements[1][3].z, 9);
  EXPECT_EQ(model.notices.at(0), "ignored: 1 other scenes; scene 1 is shown");
  b.document.erase("scene");
  EXPECT_EQ(load(b).parts.at(0).placements.size(), 1u);
  b.document.erase("scenes");
  EXPECT_EQ(load(b).parts.at(0).placements.size(), 2u) << "without scenes, from all nodes that are no child";
  b.document["nodes"][0]["children"] = {1};
  b.document["scenes"] = json::array({{{"nodes", {1}}}});
  EXPECT_NE(refusal_of(b.text()).find("nodes[1]"), std::string::npos) << "a loop is named";
}

TEST_F(ImportGltf, SkinsIgnoreTheirNode) {
  GltfBuilder b = with([](GltfBuilder& builder) {
    json& attributes = builder.document["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = builder.add<std::uint8_t>("VEC4", {0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0});
    attributes["WEIGHTS_0"] = builder.add<float>("VEC4", {1, 0, 0, 0, 1, 1, 0, 0, 0, 2, 0, 0});  // sums of 1, 2 and 2
    std::vector<float> inverse_bind(32, 0.0f);
    for (const std::size_t i : {0u, 5u, 10u, 15u}) inverse_bind[i] = inverse_bind[16 + i] = 1;
    inverse_bind[16 + 13] = -1;  // the second joint was bound at y = 1
    const std::size_t matrices = builder.add<float>("MAT4", inverse_bind);
    builder.push("nodes", {{"translation", {0, 0, 0}}, {"children", {2}}});
    builder.push("nodes", {{"translation", {0, 3, 0}}});
    builder.push("skins", {{"joints", {1, 2}}, {"inverseBindMatrices", matrices}});
    builder.document["nodes"][0]["skin"] = 0;
    builder.document["nodes"][0]["translation"] = {5, 5, 5};
    builder.document["scenes"][0]["nodes"] = {0, 1};
  });
  const Model model = load(b);
  EXPECT_EQ(model.parts.at(0).placements.at(0), glm::dmat4(1.0));
  EXPECT_EQ(model.parts[0].mesh.positions[0], glm::dvec3(0, 0, 0));
  EXPECT_EQ(model.parts[0].mesh.positions[1], glm::dvec3(1, 1, 0)) << "half of the joint that has moved by 2";
  EXPECT_EQ(model.parts[0].mesh.positions[2], glm::dvec3(0, 3, 0));
  b.document["skins"][0]["joints"] = {1};
  EXPECT_NE(refusal_of(b.text()).find("joint 1 of a skin of 1"), std::string::npos) << refusal_of(b.text());
}

TEST_F(ImportGltf, MorphTargetsAreWeightedByNodeOrMesh) {
  GltfBuilder b = with([](GltfBuilder& builder) {
    const std::size_t up = builder.add<float>("VEC3", {0, 2, 0, 0, 2, 0, 0, 2, 0});
    builder.document["meshes"][0]["primitives"][0]["targets"] = json::array({{{"POSITION", up}}, {{"POSITION", up}}});
    builder.document["meshes"][0]["weights"] = {1, 0};
  });
  EXPECT_EQ(load(b).parts.at(0).mesh.positions[0].y, 2);
  b.document["nodes"][0]["weights"] = {0.5, 0.75};
  EXPECT_EQ(load(b).parts.at(0).mesh.positions[0].y, 2.5);
}

TEST_F(ImportGltf, InstancesOfTheExtensionAreOneDraw) {
  GltfBuilder b = with([](GltfBuilder& builder) {
    const std::size_t move = builder.add<float>("VEC3", {0, 0, 0, 3, 0, 0, 6, 0, 0});
    builder.document["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
    builder.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = move;
    builder.document["nodes"][0]["translation"] = {0, 1, 0};
  });
  const Model model = load(b);
  ASSERT_EQ(model.parts.at(0).placements.size(), 3u);
  EXPECT_EQ(glm::dvec3(model.parts[0].placements[2][3]), glm::dvec3(6, 1, 0));
  const Capture capture = import_file(folder_.path() / "model.gltf", {.frames = 1});
  ASSERT_EQ(capture.frames[0].draws.size(), 1u);
  EXPECT_EQ(capture.frames[0].draws[0].instance_count, 3u);
}

TEST_F(ImportGltf, TheFirstPlacedCameraIsUsedAsItLies) {
  GltfBuilder b = with([](GltfBuilder& builder) {
    const json perspective = {{"yfov", 1.0}, {"znear", 0.001}};
    builder.push("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 2.0}, {"znear", 1}}}});
    builder.push("cameras", {{"type", "perspective"}, {"perspective", perspective}});
    // Rolled by a quarter about its axis, and scaled, which a camera is not.
    builder.push("nodes", {{"camera", 1},
                           {"translation", {0, 0, 5}},
                           {"scale", {3, 3, 3}},
                           {"rotation", {0, 0, std::sqrt(0.5), std::sqrt(0.5)}}});
    builder.document["scenes"][0]["nodes"] = {0, 1};
  });
  const Model model = load(b);
  ASSERT_TRUE(model.camera.has_value());
  EXPECT_EQ(model.camera->near, 0.001);
  EXPECT_NEAR(model.camera->vertical_fov_degrees, 180 / kPi, 1e-9);
  EXPECT_NEAR(model.camera->world[1].x, -1, 1e-9) << "its +y is the world's -x";
  const Capture capture = import_file(folder_.path() / "model.gltf", {.frames = 2, .width = 100, .height = 50});
  const Frame& frame = capture.frames[1];
  EXPECT_EQ(frame.projection[14], 0.001f);
  // World +y lies across the image: view x of a point above the axis.
  EXPECT_NEAR(frame.view[4], 1, 1e-6);
  EXPECT_NEAR(frame.view[14], -5, 1e-6);
}

TEST_F(ImportGltf, ACameraThatSeesNothingIsLeftOutAloud) {
  for (const double z : {-5.0, 5.0}) {  // it looks along -z: away from the triangle, and at it
    GltfBuilder b = with([&](GltfBuilder& builder) {
      builder.push("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}});
      builder.push("nodes", {{"camera", 0}, {"translation", {0, 0, z}}});
      builder.document["scenes"][0]["nodes"] = {0, 1};
    });
    load(b);
    const Capture capture = import_file(folder_.path() / "model.gltf", {.frames = 1});
    EXPECT_EQ(capture.metadata.notices.size(), z < 0 ? 1u : 0u);
    EXPECT_EQ(capture.frames[0].view[14] == -5.0f, z > 0);
  }
}

TEST_F(ImportGltf, ParallelCamerasShowHeightsOfTwiceYmag) {
  GltfBuilder b = with([](GltfBuilder& builder) {
    builder.push("cameras", {{"type", "orthographic"},
                             {"orthographic", {{"xmag", 2}, {"ymag", 2}, {"znear", 0.1}, {"zfar", 50}}}});
    builder.push("nodes", {{"camera", 0}, {"translation", {0, 0, 10}}});
    builder.document["scenes"][0]["nodes"] = {0, 1};
  });
  load(b);
  const Frame frame = import_file(folder_.path() / "model.gltf", {.frames = 1, .width = 200, .height = 100}).frames[0];
  const glm::dvec4 point(1, 1, 0, 1);
  glm::dvec4 view(0), clip(0);
  for (std::size_t r = 0; r < 4; ++r) {
    for (std::size_t c = 0; c < 4; ++c) view[static_cast<int>(r)] += frame.view[4 * c + r] * point[static_cast<int>(c)];
  }
  for (std::size_t r = 0; r < 4; ++r) {
    for (std::size_t c = 0; c < 4; ++c)
      clip[static_cast<int>(r)] += frame.projection[4 * c + r] * view[static_cast<int>(c)];
  }
  EXPECT_NEAR(clip.w, 1, 1e-6);
  EXPECT_NEAR(clip.y, -0.5, 1e-4) << "1 of 2 units above the middle, Vulkan's y down";
  EXPECT_NEAR(clip.x, 0.25, 1e-4);
  EXPECT_NEAR(clip.z, (50.0 - 10) / (50 - 0.1), 1e-3) << "reversed depth";
}

TEST_F(ImportGltf, LightsAreThoseThatNodesPlace) {
  const Model model = load(with([](GltfBuilder& b) {
    b.document["extensions"]["KHR_lights_punctual"]["lights"] =
        json::array({{{"type", "spot"},
                      {"intensity", 10},
                      {"range", 4},
                      {"spot", {{"innerConeAngle", 0.3}, {"outerConeAngle", 0.6}}}},
                     {{"type", "point"}, {"name", "same"}, {"color", {1, 0.5, 0}}, {"intensity", 2}},
                     {{"type", "point"}, {"name", "same"}},
                     {{"type", "directional"}, {"intensity", 3}},
                     {{"type", "directional"}, {"intensity", 5}},
                     {{"type", "point"}, {"intensity", 1000}}});
    const auto place = [&](int light, const json& translation) {
      b.push("nodes", {{"translation", translation}, {"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}});
      b.document["scenes"][0]["nodes"].push_back(b.document["nodes"].size() - 1);
    };
    place(0, {0, 0, 1});
    place(1, {1, 0, 0});
    place(1, {2, 0, 0});
    place(2, {3, 0, 0});
    place(3, {0, 0, 0});
    place(4, {0, 0, 0});
  }));
  ASSERT_EQ(model.point_lights.size(), 4u);
  ASSERT_TRUE(model.point_lights[0].cone.has_value());
  EXPECT_EQ(model.point_lights[0].cone->direction, (Float3{-0.0f, -0.0f, -1}));
  EXPECT_NEAR(model.point_lights[0].cone->inner_cosine, std::cos(0.3), 1e-6);
  EXPECT_NEAR(model.point_lights[0].cone->outer_cosine, std::cos(0.6), 1e-6);
  EXPECT_EQ(model.point_lights[0].range, 4.0f);
  EXPECT_EQ(model.point_lights[1].intensity, (Float3{2, 1, 0}));
  EXPECT_EQ(model.point_lights[2].position, (Float3{2, 0, 0}));
  EXPECT_EQ(model.point_lights[3].intensity, (Float3{1, 1, 1}));
  EXPECT_EQ(model.sun->irradiance, (Float3{5, 5, 5}));
  EXPECT_EQ(model.notices, (std::vector<std::string>{"ignored: 1 directional lights; the brightest is the sun"}));
}

// Frames of an imported animation are posed at their times.
TEST_F(ImportGltf, AnimationsArePlayedByTheFrames) {
  const auto heights = [&](const std::string& interpolation, const std::vector<float>& values) {
    GltfBuilder b = with([&](GltfBuilder& builder) {
      const std::size_t times = builder.add<float>("SCALAR", {0, 0.1f}), keys = builder.add<float>("VEC3", values);
      builder.push("animations",
                   {{"samplers", json::array({{{"input", times}, {"output", keys}, {"interpolation", interpolation}}})},
                    {"channels", json::array({{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}})}});
    });
    load(b);
    std::vector<float> result;
    for (const Frame& frame : import_file(folder_.path() / "model.gltf", {.frames = 5}).frames) {
      result.push_back(frame.draws.at(0).transform[13]);
    }
    return result;
  };
  const std::vector<float> linear = heights("LINEAR", {0, 0, 0, 0, 3, 0});
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(linear[i], std::min(static_cast<double>(i), 3.0), 1e-5) << i;
  // The second key, 0.1 s as a float, is just after the fourth frame.
  EXPECT_EQ(heights("STEP", {0, 0, 0, 0, 3, 0}), (std::vector<float>{0, 0, 0, 0, 3}));
  // In- and out-tangents of 0: 3 (3 t^2 - 2 t^3).
  const std::vector<float> cubic = heights("CUBICSPLINE", {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0, 0});
  for (std::size_t i = 0; i < 4; ++i) {
    const double t = static_cast<double>(i) / 3;
    EXPECT_NEAR(cubic[i], 3 * t * t * (3 - 2 * t), 1e-5) << i;
  }
}

TEST_F(ImportGltf, RotationsTakeTheShorterArc) {
  GltfBuilder b = with([](GltfBuilder& builder) {
    // From no turn to a quarter about z, whose quaternion is given negated.
    const auto s = static_cast<float>(std::sqrt(0.5));
    const std::size_t times = builder.add<float>("SCALAR", {0, 2.0f / 30}),
                      keys = builder.add<float>("VEC4", {0, 0, 0, 1, 0, 0, -s, -s});
    builder.push("animations",
                 {{"samplers", json::array({{{"input", times}, {"output", keys}}})},
                  {"channels", json::array({{{"sampler", 0}, {"target", {{"node", 0}, {"path", "rotation"}}}}})}});
  });
  load(b);
  const Capture capture = import_file(folder_.path() / "model.gltf", {.frames = 3});
  EXPECT_NEAR(capture.frames[1].draws.at(0).transform[0], std::cos(kPi / 4), 1e-6);
  EXPECT_NEAR(capture.frames[1].draws.at(0).transform[1], std::sin(kPi / 4), 1e-6);
  EXPECT_NEAR(capture.frames[2].draws.at(0).transform[1], 1, 1e-6);
}

TEST_F(ImportGltf, DracoMeshesAreDecoded) {
  draco::TriangleSoupMeshBuilder soup;
  soup.Start(2);
  const int position = soup.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  soup.SetAttributeValuesForFace(position, draco::FaceIndex(0), corners[0], corners[1], corners[2]);
  soup.SetAttributeValuesForFace(position, draco::FaceIndex(1), corners[1], corners[3], corners[2]);
  const auto mesh = soup.Finalize();
  draco::Encoder encoder;
  draco::EncoderBuffer encoded;
  ASSERT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &encoded).ok());
  GltfBuilder b;
  const std::size_t view = b.add_view(std::vector<char>(encoded.data(), encoded.data() + encoded.size()));
  const std::size_t declared = b.push("accessors", {{"componentType", 5126}, {"count", 4}, {"type", "VEC3"}});
  const json extension = {{"bufferView", view}, {"attributes", {{"POSITION", mesh->attribute(position)->unique_id()}}}};
  b.draw(json::array(
      {{{"attributes", {{"POSITION", declared}}}, {"extensions", {{"KHR_draco_mesh_compression", extension}}}}}));
  b.document["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  const Model model = load(b);
  EXPECT_EQ(model.parts.at(0).mesh.triangle_count(), 2u);
  EXPECT_EQ(model.low, glm::dvec3(0, 0, 0));
  EXPECT_EQ(model.high, glm::dvec3(1, 1, 0));
  b.document["bufferViews"][view]["byteLength"] = encoded.size() / 2;
  EXPECT_NE(refusal_of(b.text()).find("draco"), std::string::npos) << refusal_of(b.text());
}

TEST_F(ImportGltf, MeshoptViewsAreDecodedWithoutTheirFallback) {
  const std::vector<float> vertices{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
  const std::vector<std::uint32_t> corners{0, 1, 2, 1, 3, 2};
  std::vector<unsigned char> packed(meshopt_encodeVertexBufferBound(4, 12));
  packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), vertices.data(), 4, 12));
  std::vector<unsigned char> packed_corners(meshopt_encodeIndexBufferBound(6, 4));
  packed_corners.resize(meshopt_encodeIndexBuffer(packed_corners.data(), packed_corners.size(), corners.data(), 6));
  GltfBuilder b;
  const auto compressed_view = [&](const std::vector<unsigned char>& bytes, int stride, int count, const char* mode) {
    const std::size_t view = b.add_view(bytes);
    json& entry = b.document["bufferViews"][view];
    entry["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                      {"byteOffset", entry["byteOffset"]},
                                                      {"byteLength", bytes.size()},
                                                      {"byteStride", stride},
                                                      {"count", count},
                                                      {"mode", mode}};
    entry["buffer"] = 1;  // the fallback, which stands for nothing
    entry["byteOffset"] = 0;
    entry["byteLength"] = stride * count;
    return view;
  };
  const std::size_t positions = b.push("accessors", {{"bufferView", compressed_view(packed, 12, 4, "ATTRIBUTES")},
                                                     {"componentType", 5126},
                                                     {"count", 4},
                                                     {"type", "VEC3"}});
  const std::size_t indices = b.push("accessors", {{"bufferView", compressed_view(packed_corners, 4, 6, "TRIANGLES")},
                                                   {"componentType", 5125},
                                                   {"count", 6},
                                                   {"type", "SCALAR"}});
  b.draw(json::array({{{"attributes", {{"POSITION", positions}}}, {"indices", indices}}}));
  json whole = json::parse(b.text());
  whole["extensionsRequired"] = {"EXT_meshopt_compression"};
  whole["buffers"].push_back(
      {{"byteLength", 100000}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
  const Model model = load_text(whole.dump());
  EXPECT_EQ(model.parts.at(0).mesh.triangle_count(), 2u);
  EXPECT_EQ(model.high, glm::dvec3(1, 1, 0));
  whole["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["byteLength"] = packed.size() / 2;
  EXPECT_NE(refusal_of(whole.dump()).find("bufferViews[0].extensions.EXT_meshopt_compression"), std::string::npos);
}

TEST_F(ImportGltf, ByteOrderMarksBinariesAndUrisAreRead) {
  GltfBuilder b = with([](GltfBuilder&) {});
  EXPECT_EQ(load_text("\xef\xbb\xbf" + b.text()).parts.size(), 1u);
  EXPECT_EQ(load_text(b.glb(), "MODEL.GLB").parts.size(), 1u);
  EXPECT_EQ(load_text(b.glb(), "binary.gltf").parts.size(), 1u) << "the first bytes say what it is";
  json whole = b.document;
  for (const auto& [uri, file] : {std::pair{"a%20b+c%C3%BC.bin", "a b+c\xc3\xbc.bin"},
                                  {"a b.bin", "a b.bin"},
                                  {"100%.bin", "100%.bin"},
                                  {"sub/../sub/x.bin", "sub/x.bin"},
                                  {"sub\\y.bin", "sub/y.bin"}}) {
    folder_.write(file, b.bytes() + "more than byteLength says");
    whole["buffers"] = json::array({{{"byteLength", b.bytes().size()}, {"uri", uri}}});
    EXPECT_EQ(refusal_of(whole.dump()), "") << uri;
  }
  whole["buffers"][0]["uri"] = "data:application/gltf-buffer;charset=utf-8;base64," + base64(b.bytes());
  EXPECT_EQ(refusal_of(whole.dump()), "");
  whole["buffers"][0]["uri"] = "absent%20file.bin";
  EXPECT_NE(refusal_of(whole.dump()).find("the file absent file.bin is missing"), std::string::npos);
  whole["buffers"][0]["uri"] = "https://example.org/x.bin";
  EXPECT_NE(refusal_of(whole.dump()).find("elsewhere"), std::string::npos);
}

// Each breaks one thing; the message names its place.
TEST_F(ImportGltf, WhatIsWrongIsNamed) {
  struct Case {
    const char* place;
    std::function<void(json&)> change;
  };
  const Case cases[] = {
      {"asset", [](json& d) { d["asset"]["version"] = "1.0"; }},
      {"asset is missing", [](json& d) { d.erase("asset"); }},
      {"extensionsRequired[0]", [](json& d) { d["extensionsRequired"] = {"ACME_secret"}; }},
      {"ACME_secret", [](json& d) { d["extensionsRequired"] = {"ACME_secret"}; }},
      {"nodes[0].mesh", [](json& d) { d["nodes"][0]["mesh"] = 7; }},
      {"nodes[0].mesh", [](json& d) { d["nodes"][0]["mesh"] = -1; }},
      {"nodes[0].mesh", [](json& d) { d["nodes"][0]["mesh"] = "first"; }},
      {"nodes[0].mesh", [](json& d) { d["nodes"][0]["mesh"] = 0.5; }},
      {"nodes[0].translation",
       [](json& d) {
         d["nodes"][0]["translation"] = {1, 2};
       }},
      {"nodes[0].translation[2]",
       [](json& d) {
         d["nodes"][0]["translation"] = {1, 2, "x"};
       }},
      {"nodes[0].children[0]", [](json& d) { d["nodes"][0]["children"] = {99}; }},
      {"scenes[0].nodes[0]", [](json& d) { d["scenes"][0]["nodes"] = {5}; }},
      {"attributes.POSITION", [](json& d) { d["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 9; }},
      {"accessors[0]", [](json& d) { d["accessors"][0]["count"] = 4; }},
      {"accessors[0]", [](json& d) { d["accessors"][0]["count"] = 1e18; }},
      {"accessors[0]", [](json& d) { d["accessors"][0]["byteOffset"] = 4; }},
      {"accessors[0].byteOffset", [](json& d) { d["accessors"][0]["byteOffset"] = -4; }},
      {"accessors[0]", [](json& d) { d["accessors"][0]["componentType"] = 5124; }},
      {"accessors[0].type", [](json& d) { d["accessors"][0]["type"] = "VEC5"; }},
      {"attributes.POSITION", [](json& d) { d["accessors"][0]["type"] = "VEC2"; }},
      {"bufferViews[0]", [](json& d) { d["bufferViews"][0]["byteLength"] = 1000000; }},
      {"bufferViews[0]", [](json& d) { d["bufferViews"][0]["byteOffset"] = 1e15; }},
      {"bufferViews[0].buffer", [](json& d) { d["bufferViews"][0]["buffer"] = 1; }},
      {"accessors[0].bufferView", [](json& d) { d["accessors"][0]["bufferView"] = 12; }},
      {"buffers[0]", [](json& d) { d["buffers"][0]["byteLength"] = 1000000; }},
      {"buffers[0]", [](json& d) { d["buffers"][0]["uri"] = "data:;base64,$$$$"; }},
      {"NORMAL has 2 elements", [](json& d) { d["accessors"][1]["count"] = 2; }},
      {"unknown mode 9", [](json& d) { d["meshes"][0]["primitives"][0]["mode"] = 9; }},
      {"meshes[0].primitives[0].material", [](json& d) { d["meshes"][0]["primitives"][0]["material"] = 0; }},
      {"cameras[0].perspective.yfov",
       [](json& d) {
         d["cameras"] = json::array({{{"type", "perspective"}, {"perspective", {{"yfov", 4}, {"znear", 1}}}}});
         d["nodes"][0]["camera"] = 0;
       }},
  };
  const std::string whole = with([](GltfBuilder&) {}).text();
  ASSERT_EQ(refusal_of(whole), "");
  for (const Case& broken : cases) {
    json document = json::parse(whole);
    broken.change(document);
    const std::string refusal = refusal_of(document.dump());
    EXPECT_NE(refusal.find(broken.place), std::string::npos) << broken.place << ": '" << refusal << "'";
    EXPECT_NE(refusal.find("model.gltf"), std::string::npos) << refusal;
    EXPECT_EQ(refusal.find('\n'), std::string::npos) << refusal;
  }
  EXPECT_NE(refusal_of(whole.substr(0, whole.size() / 2)).find("broken JSON"), std::string::npos);
}

// Whatever bytes come, there is a model or an InputError.
TEST_F(ImportGltf, CutAndDamagedFilesAreRefusedOrRead) {
  const std::string whole =
      with([](GltfBuilder& b) {
        b.document["meshes"][0]["primitives"][0]["indices"] = b.add<std::uint16_t>("SCALAR", {0, 1, 2});
      }).glb();
  for (std::size_t length = 0; length < whole.size(); length += 7) {
    EXPECT_NE(refusal_of(whole.substr(0, length), "cut.glb"), "") << length;
  }
  std::mt19937 random(1);
  for (int i = 0; i < 600; ++i) {
    std::string damaged = whole;
    for (int k = 0; k < 3; ++k) damaged[random() % damaged.size()] = static_cast<char>(random());
    refusal_of(damaged, "damaged.glb");
  }
}

}  // namespace
}  // namespace subpixel::capture
