// Models over HTTP: what becomes a capture, and what is refused by name.
#include <minizip/zip.h>

#include <fstream>
#include <iterator>

#include "tests/service/fake_worker/png.hpp"
#include "tests/service/service_fixture.hpp"
#include "tests/unit/gltf_builder.hpp"

namespace subpixel::tests {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTriangle =
    "mtllib m.mtl\nusemtl wood\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";

struct Member {
  std::string name, content;
  unsigned mode = 0100644;  // of Unix
};

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class Imports : public ServiceTest {
 protected:
  Imports() {
    server::ServiceOptions real = options();
    real.worker.program = SUBPIXEL_BINARY;
    real.upload_limit_bytes = 64 << 20;
    start(real);
  }

  std::string zip_of(const std::vector<Member>& members) const {
    const fs::path path = folder() / "made.zip";
    zipFile zip = zipOpen(path.c_str(), APPEND_STATUS_CREATE);
    for (const Member& member : members) {
      zip_fileinfo info{};
      info.external_fa = static_cast<uLong>(member.mode) << 16;
      constexpr uLong kMadeOnUnix = 3 << 8;
      zipOpenNewFileInZip4(zip, member.name.c_str(), &info, nullptr, 0, nullptr, 0, nullptr, Z_DEFLATED, 6, 0,
                           -MAX_WBITS, DEF_MEM_LEVEL, Z_DEFAULT_STRATEGY, nullptr, 0, kMadeOnUnix, 0);
      zipWriteInFileInZip(zip, member.content.data(), static_cast<unsigned>(member.content.size()));
      zipCloseFileInZip(zip);
    }
    zipClose(zip, nullptr);
    return bytes_of(path);
  }

  std::string png() const {
    const fs::path path = folder() / "wood.png";
    write_png(path, 2, 2, std::vector<std::uint8_t>(12, 200));
    return bytes_of(path);
  }

  void expect_refused(const std::string& bytes, const std::string& reason) {
    const json error = error_of(client().upload(bytes, "a/b/chair.zip"), 422);
    const std::string why = error.value("why", "");
    EXPECT_NE(why.find(reason), std::string::npos) << why;
    EXPECT_EQ(why.find("/data/"), std::string::npos) << "a path of the service's: " << why;
    EXPECT_TRUE(fs::is_empty(folder() / "data" / "uploads"));
    EXPECT_EQ(client().get("/api/captures").at("total"), 0);
  }
};

TEST_F(Imports, AGlbBecomesACapture) {
  capture::GltfBuilder gltf;
  gltf.draw(json::array({gltf.triangle()}));
  gltf.document["extensionsUsed"] = {"EXT_unheard_of"};
  const httplib::Result first = client().upload(gltf.glb(), "chair.glb");
  ASSERT_TRUE(first);
  ASSERT_EQ(first->status, 201) << first->body;
  const json capture = json::parse(first->body);
  EXPECT_EQ(capture.at("name"), "chair.glb");
  EXPECT_EQ(capture.at("title"), "chair");
  EXPECT_EQ(capture.at("frame_count"), 10);
  EXPECT_EQ(capture.at("triangles"), 1);
  EXPECT_NE(capture.at("notices").dump().find("EXT_unheard_of"), std::string::npos) << capture;
  const std::string hash = capture.at("hash");
  const httplib::Result file = client().http().Get("/api/captures/" + hash + "/file");
  ASSERT_TRUE(file);
  EXPECT_TRUE(bytes_of(folder() / "data" / "captures" / (hash + ".spcap")) == file->body);
  EXPECT_EQ(file->body.size(), capture.at("size_bytes"));
  const httplib::Result again = client().upload(gltf.glb(), "chair.glb");
  ASSERT_TRUE(again);
  EXPECT_EQ(again->status, 200) << "the same bytes come out";
  EXPECT_EQ(json::parse(again->body).at("hash"), hash);
  EXPECT_TRUE(fs::is_empty(folder() / "data" / "uploads"));
}

TEST_F(Imports, AZipOfAnObjHasItsTextures) {
  const httplib::Result result = client().upload(zip_of({{"chair/", "", 040755},
                                                         {"chair/chair.OBJ", std::string("l 1 2\n") + kTriangle},
                                                         {"chair/m.mtl", "newmtl wood\nmap_Kd textures\\wood.png\n"},
                                                         {"chair/textures/wood.png", png()},
                                                         {"__MACOSX/._chair.obj", "attributes"}}),
                                                 "chair.zip");
  ASSERT_TRUE(result);
  ASSERT_EQ(result->status, 201) << result->body;
  const json capture = json::parse(result->body);
  EXPECT_NE(capture.at("features").dump().find("textures"), std::string::npos) << capture;
  EXPECT_NE(capture.at("notices").dump().find("\\\"l\\\""), std::string::npos) << capture.at("notices");
}

TEST_F(Imports, HostileArchivesAreRefusedByName) {
  const Member model{"chair.obj", kTriangle};
  expect_refused(zip_of({model, {"../../evil", "x"}}), "its name leads out of the archive");
  expect_refused(zip_of({model, {"a/../../evil", "x"}}), "member a/../../evil");
  expect_refused(zip_of({model, {"..\\evil", "x"}}), "its name leads out of the archive");
  expect_refused(zip_of({model, {"/etc/evil", "x"}}), "its name is absolute: chair.zip, member /etc/evil");
  expect_refused(zip_of({model, {"C:\\evil", "x"}}), "its name is absolute");
  expect_refused(zip_of({model, {"wood.png", "/etc/passwd", 0120777}}),
                 "it is a symbolic link: chair.zip, member wood.png");
  expect_refused(zip_of({model, {"./chair.obj", kTriangle}}), "it is there twice: chair.zip, member ./chair.obj");
  expect_refused(zip_of({model, {std::string(1500, 'n'), "x"}}), "its name is too long");
  expect_refused(zip_of({model, {"zeros", std::string(std::size_t{32} << 20, '\0')}}),
                 "it inflates to more than 200 times its size: chair.zip, member zeros");
  std::vector<Member> many{model};
  for (int i = 0; i < 10'000; ++i) many.push_back({std::to_string(i), ""});
  expect_refused(zip_of(many), "it has more than 10000 members");
  expect_refused(zip_of({{"readme.txt", "x"}}), "it has no .gltf, .glb or .obj");
  expect_refused(zip_of({}), "it is no zip archive");
  expect_refused(zip_of({model, {"table.obj", kTriangle}}), "several models");
  expect_refused("PK\x03\x04 and no more", "it is no zip archive");
  expect_refused(zip_of({model}).substr(0, 90), "it is no zip archive");
}

// An archive may say any size of a member: 4 GB here, in both of its places.
TEST_F(Imports, SizesThatAreNotTrueAreRefused) {
  std::string bytes = zip_of({{"chair.obj", kTriangle}});
  const std::size_t directory = bytes.rfind("PK\x01\x02");
  ASSERT_NE(directory, std::string::npos);
  bytes.replace(directory + 24, 4, "\xf0\xff\xff\xff");
  expect_refused(bytes, "member chair.obj");
}

TEST_F(Imports, DamagedModelsAreRefusedWithTheReadersReason) {
  expect_refused("glTF and no more", "chair.glb");
  expect_refused(zip_of({{"chair.obj", "f 1 2 3\n"}}), "chair.obj");
  expect_refused("RDOC and no more", "");
}

TEST_F(Imports, FilesOfTheMachineAreNoTextures) {
  capture::GltfBuilder gltf;
  json triangle = gltf.triangle();
  triangle["material"] = 0;
  gltf.draw(json::array({triangle}));
  const fs::path secret = folder() / "data" / "captures" / "secret.png";
  write_png(secret, 2, 2, std::vector<std::uint8_t>(12, 200));
  gltf.document["images"] = {{{"uri", "../../../captures/secret.png"}}};
  gltf.document["textures"] = {{{"source", 0}}};
  gltf.document["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
  const httplib::Result result = client().upload(gltf.glb(), "chair.glb");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, 422) << "the file was read: " << result->body;
  EXPECT_NE(result->body.find("it can't be opened: "), std::string::npos) << result->body;
}

}  // namespace
}  // namespace subpixel::tests
