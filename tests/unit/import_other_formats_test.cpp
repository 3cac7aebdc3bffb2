// Formats that assimp reads: what is made of normals, colours, lights and cameras that it hands on.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <string>

#include "base/error.hpp"
#include "scenes/import/asset_source.hpp"
#include "scenes/import/model.hpp"

namespace subpixel::capture {
namespace {

class ImportOtherFormats : public testing::Test {
 protected:
  ImportOtherFormats()
      : folder_(std::filesystem::path(testing::TempDir()) / ("import_other_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~ImportOtherFormats() override { std::filesystem::remove_all(folder_); }

  Model load(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return load_model(*open_folder(folder_), name);
  }

  std::filesystem::path folder_;
};

void expect_flat(const Mesh& mesh) {
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const glm::dvec3 a = mesh.positions[mesh.indices[i]];
    const glm::dvec3 face =
        glm::normalize(glm::cross(mesh.positions[mesh.indices[i + 1]] - a, mesh.positions[mesh.indices[i + 2]] - a));
    for (std::size_t c = i; c < i + 3; ++c) EXPECT_NEAR(glm::dot(mesh.normals[mesh.indices[c]], face), 1, 1e-6) << c;
  }
}

// Corners of a cube, and its sides as four corners each.
const std::string kCorners = "-1 -1 -1\n-1 -1 1\n-1 1 -1\n-1 1 1\n1 -1 -1\n1 -1 1\n1 1 -1\n1 1 1\n";
const std::string kSides = "4 0 1 3 2\n4 4 6 7 5\n4 0 4 5 1\n4 2 3 7 6\n4 0 2 6 4\n4 1 5 7 3\n";

TEST_F(ImportOtherFormats, ACubeWithoutNormalsHasHardEdgesInAllOfThem) {
  const Model off = load("c.off", "OFF\n8 6 12\n" + kCorners + kSides);
  const Model ply =
      load("c.ply",
           "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
           "element face 6\nproperty list uchar int vertex_indices\nend_header\n" +
               kCorners + kSides);
  for (const Model* model : {&off, &ply}) {
    ASSERT_EQ(model->parts.size(), 1u);
    EXPECT_EQ(model->parts[0].mesh.positions.size(), 24u);
    expect_flat(model->parts[0].mesh);
    EXPECT_EQ(model->materials[model->parts[0].material].name, "DefaultMaterial");
  }
  EXPECT_EQ(off.materials[0].base_colour, ply.materials[0].base_colour);
  EXPECT_EQ(off.materials[0].roughness, ply.materials[0].roughness);
}

TEST_F(ImportOtherFormats, ZeroNormalsOfStlAreLacking) {
  const std::string facet = "facet normal 0 -0 0\nouter loop\nvertex ";
  const Model model = load("z.stl", "solid z\n" + facet + "0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n" +
                                        facet + "0 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet\nendsolid z\n");
  ASSERT_EQ(model.parts.at(0).mesh.triangle_count(), 2u);
  expect_flat(model.parts[0].mesh);
}

TEST_F(ImportOtherFormats, AnEmptySolidBesideATriangleIsNoMistake) {
  const Model model = load("e.stl",
                           "solid empty\nendsolid empty\nsolid full\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"
                           "vertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid full\n");
  EXPECT_EQ(model.parts.at(0).mesh.triangle_count(), 1u);
}

TEST_F(ImportOtherFormats, ColoursOfPlyAreSrgbOnWhite) {
  const Model model =
      load("q.ply",
           "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
           "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n"
           "property list uchar int vertex_indices\nend_header\n"
           "0 0 0 255 0 0\n1 0 0 0 128 255\n0 1 0 0 0 0\n900 900 900 1 1 1\n3 0 1 2\n");
  const Mesh& mesh = model.parts.at(0).mesh;
  ASSERT_EQ(mesh.colours.size(), 3u) << "a vertex that no triangle uses is gone";
  EXPECT_EQ(model.high, glm::dvec3(1, 1, 0));
  EXPECT_EQ(mesh.colours[0], glm::vec4(1, 0, 0, 1));
  EXPECT_NEAR(mesh.colours[1].g, 0.21586, 1e-4);
  EXPECT_EQ(model.materials[model.parts[0].material].base_colour, (std::array<float, 4>{1, 1, 1, 1}));
}

constexpr const char* kCollada = R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="meter" meter="1"/><up_axis>Y_UP</up_axis></asset>
<library_cameras><camera id="eye" name="eye"><optics><technique_common><perspective><xfov>60</xfov>
<aspect_ratio>1.5</aspect_ratio><znear>0.1</znear><zfar>100</zfar></perspective></technique_common></optics></camera>
</library_cameras>
<library_lights>
<light id="spot" name="spot"><technique_common><spot><color>1 0.5 0</color><constant_attenuation>0</constant_attenuation>
<linear_attenuation>0</linear_attenuation><quadratic_attenuation>0.25</quadratic_attenuation>
<falloff_angle>60</falloff_angle><falloff_exponent>0.15</falloff_exponent></spot></technique_common></light>
<light id="sun" name="sun"><technique_common><directional><color>1 1 1</color></directional></technique_common></light>
<light id="lamp" name="lamp"><technique_common><point><color>1 1 1</color><constant_attenuation>1</constant_attenuation>
<linear_attenuation>0</linear_attenuation><quadratic_attenuation>0</quadratic_attenuation></point></technique_common></light>
<light id="glow" name="glow"><technique_common><ambient><color>1 1 1</color></ambient></technique_common></light>
</library_lights>
<library_geometries><geometry id="g" name="g"><mesh><source id="p"><float_array id="pa" count="9">0 0 0 2 0 0 0 2 0
</float_array><technique_common><accessor source="#pa" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry>
</library_geometries>
<library_visual_scenes><visual_scene id="s" name="s">
<node id="n" name="n"><instance_geometry url="#g"/></node>
<node id="eye" name="eye"><matrix>0 -1 0 0  1 0 0 0  0 0 1 5  0 0 0 1</matrix><instance_camera url="#eye"/></node>
<node id="spot" name="spot"><matrix>1 0 0 1  0 1 0 2  0 0 1 4  0 0 0 1</matrix><instance_light url="#spot"/></node>
<node id="sun" name="sun"><instance_light url="#sun"/></node>
<node id="lamp" name="lamp"><matrix>1 0 0 1  0 1 0 1  0 0 1 3  0 0 0 1</matrix><instance_light url="#lamp"/></node>
<node id="glow" name="glow"><instance_light url="#glow"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>
)";

TEST_F(ImportOtherFormats, LightsAndCameraOfCollada) {
  const Model model = load("s.dae", kCollada);
  ASSERT_EQ(model.point_lights.size(), 2u);
  const PointLight& spot = model.point_lights[0];
  EXPECT_EQ(spot.position, (Float3{1, 2, 4}));
  EXPECT_EQ(spot.intensity, (Float3{4, 2, 0})) << "a square fall-off is physical";
  ASSERT_TRUE(spot.cone.has_value());
  EXPECT_EQ(spot.cone->direction, (Float3{0, 0, -1}));
  EXPECT_GT(spot.cone->inner_cosine, spot.cone->outer_cosine);
  EXPECT_GE(spot.cone->outer_cosine, 0.0f);
  const PointLight& lamp = model.point_lights[1];
  EXPECT_FALSE(lamp.cone.has_value());
  EXPECT_NEAR(lamp.intensity[0], kPi * 9, 1e-4) << "white at the model's middle, 3 away";
  ASSERT_TRUE(model.sun.has_value());
  EXPECT_EQ(model.sun->direction, (Float3{0, 0, -1}));
  EXPECT_NEAR(model.sun->irradiance[0], kPi, 1e-6);
  ASSERT_EQ(model.notices.size(), 1u);
  EXPECT_NE(model.notices[0].find("ignored: light glow"), std::string::npos);
  ASSERT_TRUE(model.camera.has_value());
  EXPECT_NEAR(glm::dot(glm::dvec3(model.camera->world[1]), glm::dvec3(-1, 0, 0)), 1, 1e-6) << "rolled by a quarter";
  EXPECT_EQ(glm::dvec3(model.camera->world[3]), glm::dvec3(0, 0, 5));
}

// kCollada with a material: `effect` is what its effect's phong has, `image` its only file.
std::string collada_with(const std::string& phong, const std::string& image) {
  std::string text = kCollada;
  const auto insert = [&](const std::string& before, const std::string& added) {
    text.insert(text.find(before), added);
  };
  insert("<library_geometries>",
         "<library_images><image id=\"i\" name=\"i\"><init_from>" + image +
             "</init_from></image></library_images><library_effects><effect id=\"e\"><profile_COMMON>"
             "<newparam sid=\"s\"><surface type=\"2D\"><init_from>i</init_from></surface></newparam>"
             "<newparam sid=\"t\"><sampler2D><source>s</source></sampler2D></newparam>"
             "<technique sid=\"c\"><phong>" +
             phong +
             "</phong></technique></profile_COMMON></effect></library_effects><library_materials>"
             "<material id=\"m\" name=\"m\"><instance_effect url=\"#e\"/></material></library_materials>");
  text.replace(text.find("<triangles count"), 10, "<triangles material=\"m\"");
  const std::string instance = "<instance_geometry url=\"#g\"/>";
  text.replace(text.find(instance), instance.size(),
               "<instance_geometry url=\"#g\"><bind_material><technique_common><instance_material symbol=\"m\" "
               "target=\"#m\"/></technique_common></bind_material></instance_geometry>");
  return text;
}

bool has_notice(const Model& model, const std::string& text) {
  for (const std::string& notice : model.notices) {
    if (notice.find(text) != std::string::npos) return true;
  }
  return false;
}

TEST_F(ImportOtherFormats, AnOpacityOfZeroIsReadAsOpaque) {
  const auto with = [&](const std::string& transparency) {
    return load("o.dae",
                collada_with("<diffuse><color>1 0 0 1</color></diffuse><transparent opaque=\"A_ONE\"><color>1 1 1 1"
                             "</color></transparent><transparency><float>" +
                                 transparency + "</float></transparency>",
                             "absent.png"));
  };
  const Model invisible = with("0");
  const Material& shown = invisible.materials.at(invisible.parts.at(0).material);
  EXPECT_EQ(shown.base_colour, (std::array<float, 4>{1, 0, 0, 1}));
  EXPECT_EQ(shown.alpha_mode, AlphaMode::opaque);
  EXPECT_TRUE(has_notice(invisible, "read: opacity 0 of material \"m\" as 1"));
  const Model glass = with("0.25");
  EXPECT_EQ(glass.materials.at(glass.parts.at(0).material).base_colour[3], 0.25f);
  EXPECT_EQ(glass.materials.at(glass.parts.at(0).material).alpha_mode, AlphaMode::blend);
  EXPECT_FALSE(has_notice(glass, "opacity"));
}

TEST_F(ImportOtherFormats, ATextureThatIsMissingLeavesTheFactor) {
  const std::string phong =
      "<emission><texture texture=\"t\" texcoord=\"u\"/></emission><diffuse><texture texture=\"t\" "
      "texcoord=\"u\"/></diffuse>";
  const Model model = load("t.dae", collada_with(phong, "far/away.png"));
  EXPECT_EQ(model.textures.size(), 0u);
  const Material& material = model.materials.at(model.parts.at(0).material);
  EXPECT_EQ(material.base_colour_texture, kNone);
  EXPECT_EQ(material.emissive_texture, kNone);
  EXPECT_EQ(material.base_colour[3], 1.0f);
  EXPECT_TRUE(has_notice(model, "ignored: texture \"far/away.png\" of material \"m\", whose file is missing"));
  std::ofstream(folder_ / "away.png", std::ios::binary) << "no picture";
  EXPECT_THROW(load("t.dae", collada_with(phong, "far/away.png")), InputError) << "damaged is another matter";
}

TEST_F(ImportOtherFormats, WhatIsNotFiniteIsNamed) {
  try {
    load("n.ply",
         "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 nan 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("position 0"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("n.ply"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace subpixel::capture
