// Model files read by assimp: geometry, materials, textures, cameras and lights; what is missing is named.
#include <gtest/gtest.h>
#include <minizip/zip.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "base/error.hpp"
#include "capture_format/streams.hpp"
#include "capture_format/writer.hpp"
#include "scenes/import/asset_source.hpp"
#include "scenes/import/import.hpp"
#include "scenes/import/model.hpp"
#include "scenes/import/text.hpp"
#include "scenes/import/texture_decode.hpp"
#include "tests/unit/capture_fixture.hpp"

namespace subpixel::capture {
namespace {

// An uncompressed TGA of one colour, with or without an alpha channel.
std::string tga(std::uint8_t width, std::uint8_t height, std::uint8_t red, int alpha = -1) {
  const char depth = alpha < 0 ? 24 : 32;
  std::string file(18, '\0');
  file[2] = 2;
  file[12] = static_cast<char>(width);
  file[14] = static_cast<char>(height);
  file[16] = depth;
  file[17] = alpha < 0 ? 0x20 : 0x28;  // top row first; 8 bits of alpha
  for (int i = 0; i < width * height; ++i) {
    file += {10, 20, static_cast<char>(red)};
    if (alpha >= 0) file += static_cast<char>(alpha);
  }
  return file;
}

constexpr const char* kObj = R"(mtllib square.mtl
v 0 0 0
v 100 0 0
v 100 200 0
v 0 200 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl leaf
f 1/1 2/2 3/3 4/4
usemtl paint
f 1/1 3/3 2/2
)";

constexpr const char* kMtl = R"(newmtl leaf
Kd 0.5 0.6 0.7
Ns 0
map_Kd leaf.tga
newmtl paint
Kd 0.1 0.2 0.3
Ke 0 2 0
Ns 510
)";

class ImportModel : public testing::Test {
 protected:
  ImportModel() : folder_(std::filesystem::path(testing::TempDir()) / ("import_model_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    write("square.obj", kObj);
    write("square.mtl", kMtl);
    write("leaf.tga", tga(2, 2, 200, 0));
  }
  ~ImportModel() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, const std::string& content) const {
    const std::filesystem::path path = folder_ / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << content;
    return path;
  }

  Model load(const std::string& name) const { return load_model(*open_folder(folder_), name); }

  std::string refusal_of(const std::string& name, const ImportOptions& options = {}) const {
    try {
      import_file(folder_ / name, options);
      return "";
    } catch (const Error& error) {
      return error.what();
    }
  }

  std::filesystem::path folder_;
};

TEST_F(ImportModel, ReadsAnObjWithItsMaterials) {
  const Model model = load("square.obj");
  ASSERT_EQ(model.parts.size(), 2u);
  EXPECT_EQ(model.parts[0].mesh.triangle_count() + model.parts[1].mesh.triangle_count(), 3u);
  EXPECT_EQ(model.high, glm::dvec3(100, 200, 0));
  const Material& leaf = model.materials[model.parts[0].material];
  EXPECT_EQ(leaf.name, "leaf");
  EXPECT_EQ(leaf.base_colour[1], 1.0f) << "the texture stands in for Kd";
  EXPECT_EQ(leaf.roughness, 1.0f);
  EXPECT_EQ(leaf.alpha_mode, AlphaMode::test);
  EXPECT_TRUE(leaf.two_sided);
  ASSERT_EQ(leaf.base_colour_texture, 0u);
  EXPECT_EQ(model.textures[0].name, "leaf.tga");
  EXPECT_TRUE(model.textures[0].srgb);
  EXPECT_EQ(model.textures[0].encoding, TextureEncoding::image_file);
  EXPECT_EQ(model.textures[0].bytes.size(), 18u + 16);
  const Material& paint = model.materials[model.parts[1].material];
  EXPECT_EQ(paint.alpha_mode, AlphaMode::opaque);
  EXPECT_FALSE(paint.two_sided);
  EXPECT_EQ(paint.emissive[1], 2.0f);
  EXPECT_NEAR(paint.base_colour[1], 0.033105, 1e-5) << "Kd is sRGB";
  EXPECT_NEAR(paint.roughness, std::pow(2.0 / 512, 0.25), 1e-6);
}

TEST_F(ImportModel, FlipsVSoThatTheImagesTopIsZero) {
  const Model model = load("square.obj");
  const Mesh& mesh = model.parts[0].mesh;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    EXPECT_EQ(mesh.uvs[i].y, mesh.positions[i].y == 0 ? 1.0 : 0.0);
}

TEST_F(ImportModel, MakesNormalsWhereThereAreNone) {
  const Model model = load("square.obj");
  for (const glm::dvec3& normal : model.parts[0].mesh.normals) EXPECT_NEAR(normal.z, 1, 1e-6);
}

TEST_F(ImportModel, AlphaComesFromItsOwnFile) {
  write("mask.tga", tga(4, 4, 64));
  write("square.mtl", std::string("newmtl leaf\nmap_Kd leaf.tga\nmap_d mask.tga\nnewmtl paint\nKd 1 1 1\nd 0.5\n"));
  const Model model = load("square.obj");
  const Material& leaf = model.materials[model.parts[0].material];
  EXPECT_EQ(leaf.alpha_mode, AlphaMode::test);
  const Texture& texture = model.textures.at(leaf.base_colour_texture);
  EXPECT_EQ(texture.encoding, TextureEncoding::rgba8);
  ASSERT_EQ(texture.bytes.size(), 16u);
  EXPECT_EQ(texture.bytes[0], std::byte{200});
  EXPECT_EQ(texture.bytes[3], std::byte{64});
  const Material& glass = model.materials[model.parts[1].material];
  EXPECT_EQ(glass.alpha_mode, AlphaMode::blend);
  EXPECT_EQ(glass.base_colour[3], 0.5f);
}

TEST_F(ImportModel, NamesWhatIsMissing) {
  EXPECT_NE(refusal_of("none.obj").find("there is no such file: " + (folder_ / "none.obj").string()),
            std::string::npos);
  std::filesystem::remove(folder_ / "leaf.tga");
  const Model model = load_model(*open_folder(folder_), "square.obj");
  EXPECT_TRUE(std::any_of(model.notices.begin(), model.notices.end(), [](const std::string& notice) {
    return notice.starts_with("ignored: texture \"leaf.tga\" of material \"leaf\", whose file is missing");
  }));
  std::filesystem::remove(folder_ / "square.mtl");
  const std::string material = refusal_of("square.obj");
  EXPECT_NE(material.find("material file square.mtl is missing"), std::string::npos) << material;
}

TEST_F(ImportModel, NamesWhatIsDamaged) {
  write("leaf.tga", "not an image at all, yet long enough to be one");
  EXPECT_NE(refusal_of("square.obj").find("can't decode the texture"), std::string::npos) << refusal_of("square.obj");
  write("broken.glb", "glTF but no more");
  EXPECT_NE(refusal_of("broken.glb").find("can't import the model"), std::string::npos);
  write("empty.obj", "# nothing\n");
  EXPECT_NE(refusal_of("empty.obj"), "");
  write("strange.xyz", "1 2 3");
  EXPECT_NE(refusal_of("strange.xyz").find("strange.xyz"), std::string::npos);
  write("frame.rdc", "RDOC");
  EXPECT_NE(refusal_of("frame.rdc").find("RenderDoc captures can't be read"), std::string::npos);
}

TEST_F(ImportModel, OptionsOutOfRangeAreUsageErrors) {
  EXPECT_THROW(import_file(folder_ / "square.obj", {.frames = 0}), UsageError);
  EXPECT_THROW(import_file(folder_ / "square.obj", {.width = 16385}), UsageError);
  EXPECT_THROW(import_file(folder_ / "square.obj", {.height = 0}), UsageError);
}

TEST_F(ImportModel, OrbitSeesTheWholeModel) {
  const Capture capture =
      import_file(folder_ / "square.obj", {.camera = "orbit", .frames = 5, .width = 90, .height = 160});
  ASSERT_EQ(capture.frames.size(), 5u);
  EXPECT_EQ(capture.frames[0].height, 160u);
  EXPECT_TRUE(capture.frames[0].sun.has_value());
  EXPECT_EQ(refusal(encode_capture(capture)), "");
  for (const Frame& frame : capture.frames) {
    const Matrix4 to_clip = multiply(frame.projection, frame.view);
    for (const auto& [x, y] : {std::pair{0.0f, 0.0f}, {100.0f, 0.0f}, {100.0f, 200.0f}, {0.0f, 200.0f}}) {
      const float w = to_clip[3] * x + to_clip[7] * y + to_clip[15];
      EXPECT_LT(std::abs(to_clip[0] * x + to_clip[4] * y + to_clip[12]), w);
      EXPECT_LT(std::abs(to_clip[1] * x + to_clip[5] * y + to_clip[13]), w);
    }
  }
}

TEST_F(ImportModel, ACameraFileIsFollowed) {
  const auto camera = write("camera.json", R"({"near_m": 0.5, "keys": [
    {"time_s": 0, "eye": [1, 2, 3], "target": [0, 0, 0]}, {"time_s": 1, "eye": [2, 2, 3], "target": [0, 0, 0]}]})");
  const Capture capture = import_file(folder_ / "square.obj", {.camera = camera.string(), .frames = 3});
  EXPECT_EQ(capture.frames[0].projection[14], 0.5f);
  EXPECT_NE(capture.frames[0].view, capture.frames[2].view);
  write("camera.json", R"({"near_m": 0.5, "keys": []})");
  EXPECT_NE(refusal_of("square.obj", {.camera = camera.string()}).find("field keys"), std::string::npos);
}

constexpr const char* kGltf = R"({"asset": {"version": "2.0"}, "scene": 0,
 "extensionsUsed": ["KHR_lights_punctual"],
 "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "color": [1, 0.5, 0], "intensity": 8}]}},
 "scenes": [{"nodes": [0, 1, 2, 3]}],
 "nodes": [{"mesh": 0, "translation": [1, 0, 0]}, {"mesh": 0, "translation": [0, 0, -2]},
  {"camera": 0, "translation": [0, 1, 5]}, {"translation": [3, 4, 5], "extensions": {"KHR_lights_punctual": {"light": 0}}}],
 "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "aspectRatio": 1.5, "znear": 0.1}}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "material": 0}]}],
 "materials": [{"name": "metal", "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
  "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 1], "metallicFactor": 0.75, "roughnessFactor": 0.25,
   "baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 0}},
  "normalTexture": {"index": 0}, "emissiveFactor": [0, 0, 1]}],
 "textures": [{"source": 0}], "images": [{"uri": "leaf.tga"}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
  {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"},
  {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"}],
 "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 36},
  {"buffer": 0, "byteOffset": 72, "byteLength": 24}],
 "buffers": [{"byteLength": 96, "uri": "triangle.bin"}]})";

TEST_F(ImportModel, ReadsGltfWithNodesCameraAndLight) {
  const std::vector<float> vertices{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 1, 1, 1, 0, 0};
  const std::vector<std::byte> bytes = bytes_of(vertices);
  write("triangle.bin", std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  write("scene.gltf", kGltf);
  const Model model = load("scene.gltf");
  ASSERT_EQ(model.parts.size(), 1u);
  EXPECT_EQ(model.parts[0].placements.size(), 2u);
  EXPECT_FALSE(model.parts[0].mesh.tangents.empty());
  EXPECT_EQ(model.low, glm::dvec3(0, 0, -2));
  const Material& metal = model.materials[model.parts[0].material];
  EXPECT_EQ(metal.alpha_mode, AlphaMode::test);
  EXPECT_EQ(metal.alpha_cutoff, 0.25f);
  EXPECT_TRUE(metal.two_sided);
  EXPECT_EQ(metal.metallic, 0.75f);
  EXPECT_EQ(metal.roughness, 0.25f);
  EXPECT_EQ(metal.emissive[2], 1.0f);
  ASSERT_NE(metal.normal_texture, kNone);
  EXPECT_FALSE(model.textures[metal.normal_texture].srgb);
  EXPECT_EQ(model.textures.size(), 2u) << "once as colour, once as numbers";
  ASSERT_TRUE(model.camera.has_value());
  EXPECT_EQ(glm::dvec3(model.camera->world[3]), glm::dvec3(0, 1, 5));
  EXPECT_NEAR(model.camera->world[2].z, 1, 1e-6);
  EXPECT_NEAR(model.camera->vertical_fov_degrees, 0.7 * 180 / kPi, 1e-3);
  ASSERT_EQ(model.point_lights.size(), 1u);
  EXPECT_EQ(model.point_lights[0].position, (Float3{3, 4, 5}));
  EXPECT_EQ(model.point_lights[0].intensity, (Float3{8, 4, 0}));

  const Capture capture = import_file(folder_ / "scene.gltf", {.frames = 1});
  EXPECT_EQ(capture.frames[0].draws.size(), 2u);
  EXPECT_EQ(refusal(encode_capture(capture)), "");
  std::filesystem::remove(folder_ / "triangle.bin");
  EXPECT_NE(refusal_of("scene.gltf"), "");
}

TEST_F(ImportModel, ReadsGlbWithAnEmbeddedTexture) {
  std::string json = kGltf;
  const auto replace = [&](const std::string& from, const std::string& to) {
    ASSERT_NE(json.find(from), std::string::npos);
    json.replace(json.find(from), from.size(), to);
  };
  const std::string image = tga(2, 2, 99);
  replace(R"({"uri": "leaf.tga"})", R"({"bufferView": 3, "mimeType": "image/tga"})");
  replace(R"("byteOffset": 72, "byteLength": 24})",
          R"("byteOffset": 72, "byteLength": 24}, {"buffer": 0, "byteOffset": 96, "byteLength": )" +
              std::to_string(image.size()) + "}");
  replace(R"({"byteLength": 96, "uri": "triangle.bin"})",
          R"({"byteLength": )" + std::to_string(96 + image.size()) + "}");
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::vector<std::byte> floats = bytes_of(std::vector<float>(24, 0.5f));
  std::string binary(reinterpret_cast<const char*>(floats.data()), floats.size());
  binary += image;
  binary.resize((binary.size() + 3) / 4 * 4);
  std::string glb;
  const auto put = [&](std::size_t value) {
    for (int i = 0; i < 4; ++i) glb += static_cast<char>(value >> (8 * i) & 0xff);
  };
  glb += "glTF";
  put(2);
  put(12 + 8 + json.size() + 8 + binary.size());
  put(json.size());
  glb += "JSON" + json;
  put(binary.size());
  glb += std::string("BIN\0", 4) + binary;
  write("model.glb", glb);
  const Model model = load("model.glb");
  ASSERT_FALSE(model.textures.empty());
  EXPECT_EQ(model.textures[0].bytes.size(), image.size());
}

TEST_F(ImportModel, MergingKeepsTrianglesAndPlaces) {
  const std::vector<std::byte> bytes = bytes_of(std::vector<float>(24, 0.5f));
  write("triangle.bin", std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  write("scene.gltf", kGltf);
  Model model = load("scene.gltf");
  merge_parts(model);
  ASSERT_EQ(model.parts.size(), 1u);
  EXPECT_EQ(model.parts[0].placements.size(), 1u);
  EXPECT_EQ(model.parts[0].mesh.triangle_count(), 2u);
  EXPECT_EQ(model.parts[0].name, "metal");
}

TEST_F(ImportModel, ArchivesGiveTheirMembers) {
  const std::filesystem::path path = folder_ / "models.zip";
  zipFile zip = zipOpen(path.c_str(), APPEND_STATUS_CREATE);
  ASSERT_NE(zip, nullptr);
  const std::pair<const char*, std::string> members[] = {
      {"folder/square.obj", kObj}, {"folder/square.mtl", kMtl}, {"folder/leaf.tga", tga(2, 2, 200, 255)}};
  for (const auto& [name, content] : members) {
    zipOpenNewFileInZip(zip, name, nullptr, nullptr, 0, nullptr, 0, nullptr, Z_DEFLATED, 6);
    zipWriteInFileInZip(zip, content.data(), static_cast<unsigned>(content.size()));
    zipCloseFileInZip(zip);
  }
  zipClose(zip, nullptr);

  const auto source = open_archive(path);
  EXPECT_TRUE(source->contains("folder/./square.obj"));
  EXPECT_FALSE(source->contains("square.obj"));
  EXPECT_FALSE(source->read("nothing").has_value());
  const Model model = load_model(*source, "folder/square.obj");
  EXPECT_EQ(model.parts.size(), 2u);
  EXPECT_EQ(model.materials[model.parts[0].material].alpha_mode, AlphaMode::opaque) << "alpha is 255 throughout";

  // Damage inside a member's data is seen by its checksum.
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(70);
  file.put('\x55');
  file.close();
  EXPECT_THROW(load_model(*open_archive(path), "folder/square.obj"), InputError);
  EXPECT_THROW(open_archive(folder_ / "square.obj"), InputError);
  EXPECT_THROW(open_archive(folder_ / "nothing.zip"), InputError);
}

TEST(ImportText, BecomesUtf8) {
  EXPECT_EQ(to_utf8("stra\xdf"
                    "e"),
            "straße");
  EXPECT_EQ(to_utf8("straße"), "straße");
  EXPECT_EQ(normal_name("a\\b/../c.jpg"), "a/c.jpg");
}

}  // namespace
}  // namespace subpixel::capture
