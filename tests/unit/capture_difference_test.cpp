// What `subpixel diff` says of two captures, each change alone and all of them in a shuffled frame of many draws.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <random>

#include "capture_format/tools/difference.hpp"
#include "capture_format/writer.hpp"
#include "tests/technique/run_binary.hpp"
#include "tests/unit/capture_fixture.hpp"

namespace subpixel::capture {
namespace {

using nlohmann::json;

// Of version_2_capture() and what `change` makes of it, frame 0.
json frame_after(const std::function<void(Capture&)>& change) {
  Capture changed = version_2_capture();
  change(changed);
  const json found = difference(version_2_capture(), changed);
  EXPECT_FALSE(found["same"].get<bool>());
  EXPECT_EQ(found["frames"][1]["same"], true);
  return found["frames"][0];
}

// Of one changed draw.
json draw_after(const std::function<void(Capture&)>& change) {
  const json frame = frame_after(change);
  EXPECT_EQ(frame["changed"].size(), 1u) << frame.dump(2);
  EXPECT_TRUE(frame["added"].empty() && frame["gone"].empty() && frame["fields"].empty()) << frame.dump(2);
  return frame["changed"].empty() ? json() : frame["changed"][0];
}

TEST(CaptureDifference, ACaptureIsLikeItself) {
  const json found = difference(version_2_capture(), version_2_capture());
  EXPECT_TRUE(found["same"].get<bool>());
  EXPECT_EQ(found["frames"][0]["equal"], 2);
  EXPECT_EQ(difference_text(found), "the same: 2 frames\n");
}

TEST(CaptureDifference, HowItIsStoredDoesNotCount) {
  Capture other = version_2_capture();
  other.metadata.title = "Another";
  other.metadata.notices.clear();
  other.buffers.insert(other.buffers.begin(), Buffer{"more", std::vector<std::byte>(100)});
  std::swap(other.materials[0], other.materials[1]);
  other.materials[0].name = "another name";
  std::swap(other.textures[0], other.textures[1]);
  std::swap(other.materials[0].base_colour_texture, other.materials[0].normal_texture);
  for (Draw& draw : other.frames[0].draws) {
    draw.material = 1 - draw.material;
    for (VertexStream* stream : {&draw.position, &draw.normal, &draw.uv, &draw.uv2, &draw.colour}) {
      if (stream->buffer != kNone) ++stream->buffer;
    }
    if (draw.index_buffer != kNone) ++draw.index_buffer;
    if (draw.instance_buffer != kNone) ++draw.instance_buffer;
  }
  // Indices of 32 bits, and normals that are the same floats.
  Draw& draw = other.frames[0].draws[0];
  draw.index_type = IndexType::uint32;
  draw.index_buffer = static_cast<std::uint32_t>(other.buffers.size());
  draw.index_offset = 0;
  other.buffers.push_back({"wide", bytes_of(std::vector<std::uint32_t>{0, 1, 2, 2, 1, 3})});
  draw.normal = {static_cast<std::uint32_t>(other.buffers.size()), VertexFormat::float32x3, 0, 0};
  other.buffers.push_back({"normal", bytes_of(std::vector<float>{0, 0, 1})});
  const json found = difference(version_2_capture(), other);
  EXPECT_TRUE(found["same"].get<bool>()) << found.dump(2);
}

TEST(CaptureDifference, Placement) {
  json draw = draw_after([](Capture& c) { c.frames[0].draws[1].transform[12] = 7; });
  EXPECT_EQ(draw["moved"], (json{{"transform", true}, {"instances", {1, 1}}, {"distance", 4.0}}));
  EXPECT_EQ(draw["matched_by"], "name");
  EXPECT_TRUE(draw["mesh"].empty() && draw["material"].empty() && draw["textures"].empty());
  draw = draw_after([](Capture& c) { c.frames[0].draws[0].instance_count = 1; });
  EXPECT_EQ(draw["moved"], (json{{"transform", false}, {"instances", {2, 1}}, {"distance", nullptr}}));
}

TEST(CaptureDifference, MaterialsAndTextures) {
  json draw = draw_after([](Capture& c) { c.materials[1].roughness = 0.25f; });
  EXPECT_EQ(draw["material"], json::array({{{"field", "roughness"}, {"a", 0.8f}, {"b", 0.25f}}}));
  EXPECT_TRUE(draw["moved"].is_null() && draw["mesh"].empty() && draw["textures"].empty());
  draw = draw_after([](Capture& c) { c.textures[0].bytes[0] = std::byte{1}; });
  EXPECT_EQ(draw["textures"], json::array({{{"field", "base_colour_texture"}, {"a", "dots"}, {"b", "dots"}}}));
  draw = draw_after([](Capture& c) { c.textures[0].sampler.wrap_u = Wrap::repeat; });
  EXPECT_EQ(draw["textures"][0]["field"], "base_colour_texture");
  draw = draw_after([](Capture& c) { c.materials[1].normal_texture = kNone; });
  EXPECT_EQ(draw["textures"], json::array({{{"field", "normal_texture"}, {"a", "file"}, {"b", nullptr}}}));
  draw = draw_after([](Capture& c) { c.frames[0].draws[1].material = 1; });
  EXPECT_GT(draw["material"].size(), 4u);
  EXPECT_EQ(draw["textures"].size(), 2u);
}

TEST(CaptureDifference, Meshes) {
  json draw = draw_after([](Capture& c) { c.buffers[3].bytes[16] = std::byte{9}; });
  EXPECT_EQ(draw["mesh"], json{"uv"});
  draw = draw_after([](Capture& c) { c.frames[0].draws[0].colour.buffer = kNone; });
  EXPECT_EQ(draw["mesh"], json{"colour"});
  draw = draw_after([](Capture& c) { c.frames[0].draws[0].index_count = 3; });
  EXPECT_EQ(draw["mesh"], json{"triangles"});
  const json frame = frame_after([](Capture& c) { c.buffers[0].bytes[20] = std::byte{9}; });  // both draws read it
  EXPECT_EQ(frame["changed"].size(), 2u);
  EXPECT_EQ(frame["changed"][0]["mesh"], json{"position"});
}

TEST(CaptureDifference, FieldsOfFrames) {
  const json frame = frame_after([](Capture& c) {
    c.frames[0].width = 65;
    c.frames[0].view[12] = 1;
    c.frames[0].sun->shadows = false;
    c.frames[0].point_lights[1].range = 8;
    c.frames[0].point_lights.emplace_back();
  });
  std::vector<std::string> fields;
  for (const json& field : frame["fields"]) fields.push_back(field["field"]);
  EXPECT_EQ(fields, (std::vector<std::string>{"view", "width", "sun", "point_lights[1]", "point_lights[2]"}));
  EXPECT_EQ(frame["equal"], 2);
}

TEST(CaptureDifference, AddedGoneRenamedAndReordered) {
  json frame = frame_after([](Capture& c) { c.frames[0].draws.erase(c.frames[0].draws.begin()); });
  EXPECT_EQ(frame["gone"], json::array({{{"draw", 0}, {"name", "indexed"}}}));
  EXPECT_EQ(frame["equal"], 1);
  frame = frame_after([](Capture& c) {
    c.frames[0].draws.push_back(c.frames[0].draws[1]);
    c.frames[0].draws[2].name = "new";
    c.frames[0].draws[2].transform[12] = 7;
  });
  EXPECT_EQ(frame["added"], json::array({{{"draw", 2}, {"name", "new"}}}));
  frame = frame_after([](Capture& c) { std::swap(c.frames[0].draws[0], c.frames[0].draws[1]); });
  EXPECT_EQ(frame["reordered"], 1);
  EXPECT_EQ(frame["equal"], 2);
  const json renamed = draw_after([](Capture& c) { c.frames[0].draws[0].name = "other"; });
  EXPECT_EQ(renamed["renamed"], "other");
  EXPECT_EQ(renamed["matched_by"], "mesh and placement");
}

// Two meshes many times over, as one application draws them by two APIs: names of each API's own, another order,
// transforms that differ in last bits, and some that only one of them has, in the way of the others.
TEST(CaptureDifference, OtherNamesAreMatchedByMeshAndTheNearest) {
  Capture a = version_2_capture(), b = version_2_capture();
  const std::vector<Draw> meshes = a.frames[0].draws;
  a.frames[0].draws.clear();
  b.frames[0].draws.clear();
  const auto add = [&](Capture& to, const char* api, int i, float x) {
    Draw draw = meshes[static_cast<std::size_t>(i % 2)];
    draw.name = std::string(api).append(std::to_string(i));
    draw.transform[12] = x;
    draw.transform[13] = static_cast<float>(i % 4);
    to.frames[0].draws.push_back(draw);
  };
  for (int i = 0; i < 4; ++i) add(b, "only ", i, 10.5f + static_cast<float>(i));
  for (int i = 0; i < 40; ++i) {
    add(a, "v", i, 12.0f * static_cast<float>(i / 4));
    add(b, "g", i, 12.0f * static_cast<float>(i / 4) * (1 + 1e-6f) + 1e-5f);
  }
  std::shuffle(b.frames[0].draws.begin() + 4, b.frames[0].draws.end(), std::mt19937(1));
  for (const bool is_turned : {false, true}) {
    const json frame = (is_turned ? difference(b, a) : difference(a, b))["frames"][0];
    EXPECT_EQ(frame[is_turned ? "gone" : "added"].size(), 4u);
    EXPECT_EQ(frame[is_turned ? "added" : "gone"].size(), 0u);
    ASSERT_EQ(frame["changed"].size(), 40u);
    EXPECT_EQ(frame["matched_by"]["mesh"], 40);
    for (const json& draw : frame["changed"]) {
      EXPECT_EQ(draw["name"].get<std::string>().substr(1), draw["renamed"].get<std::string>().substr(1));
      EXPECT_EQ(draw["matched_by"], "mesh");
      EXPECT_LT(draw["moved"]["distance"], 1e-3);
    }
  }
}

// More pairs than are looked at one by one: in order.
TEST(CaptureDifference, OtherNamesOfVeryManyDrawsAreMatchedInOrder) {
  Capture a = version_2_capture();
  const Draw draw = a.frames[0].draws[1];
  a.frames[0].draws.assign(3000, draw);
  for (std::size_t i = 0; i < 3000; ++i) a.frames[0].draws[i].transform[13] = static_cast<float>(i);
  Capture b = a;
  for (Draw& other : b.frames[0].draws) {
    other.name = "other";
    other.transform[13] += 0.25f;
  }
  const json frame = difference(a, b)["frames"][0];
  EXPECT_EQ(frame["matched_by"]["mesh"], 3000);
  for (const json& changed : frame["changed"]) ASSERT_EQ(changed["a"], changed["b"]);
}

// The draw "list" as `positions` at `transform`, under another name.
json with_other_positions(const std::vector<float>& positions, const Matrix4& transform) {
  return frame_after([&](Capture& c) {
    Draw& draw = c.frames[0].draws[1];
    draw.name = "skinned";
    draw.transform = transform;
    draw.position = {static_cast<std::uint32_t>(c.buffers.size()), VertexFormat::float32x3, 0, 12};
    c.buffers.push_back({"positions", bytes_of(positions)});
  });
}

TEST(CaptureDifference, OtherMeshesAreMatchedByTheirBoundsInTheWorld) {
  // Twice as large at half the scale.
  const json frame = with_other_positions({0, 0, -4, 2, 0, -4, 0, 2, -4, 2, 2, -4},
                                          {0.5f, 0, 0, 0, 0, 0.5f, 0, 0, 0, 0, 0.5f, 0, 3, 0, 0, 1});
  ASSERT_EQ(frame["changed"].size(), 1u) << frame.dump(2);
  EXPECT_EQ(frame["changed"][0]["matched_by"], "bounds");
  EXPECT_EQ(frame["changed"][0]["mesh"], json{"position"});
  EXPECT_EQ(
      frame["matched_by"],
      (json{{"name", 1}, {"mesh and placement", 0}, {"mesh", 0}, {"positions", 0}, {"bounds", 1}, {"likeness", 0}}));
}

TEST(CaptureDifference, OtherMeshesAreMatchedByTheirPositions) {
  const json frame = frame_after([](Capture& c) {
    Draw& draw = c.frames[0].draws[0];
    draw.name = "without colours, elsewhere";
    draw.colour.buffer = kNone;
    draw.transform[13] = 50;
  });
  ASSERT_EQ(frame["changed"].size(), 1u) << frame.dump(2);
  EXPECT_EQ(frame["changed"][0]["matched_by"], "positions");
  EXPECT_EQ(frame["changed"][0]["mesh"], json{"colour"});
}

TEST(CaptureDifference, OtherMeshesAreMatchedWhenTheyAreAlike) {
  const Matrix4 place = version_2_capture().frames[0].draws[1].transform;
  const json bent = with_other_positions({0, 0, -2, 1.1f, 0, -2, 0, 1, -2.2f, 1, 1.2f, -2}, place);
  ASSERT_EQ(bent["changed"].size(), 1u) << bent.dump(2);
  EXPECT_EQ(bent["changed"][0]["matched_by"], "likeness");
  // Elsewhere, much larger, or with nothing that is finite, it is another draw.
  for (const float size : {1.0f, 9.0f, std::numeric_limits<float>::quiet_NaN()}) {
    const float x = size == 1.0f ? 5.0f : 0.0f;
    const json other = with_other_positions({x, 0, -2, x + size, 0, -2, x, size, -2, x + size, size, -2 * size}, place);
    EXPECT_EQ(other["gone"].size(), 1u) << size << other.dump(2);
    EXPECT_EQ(other["added"].size(), 1u) << size;
  }
}

// 6000 draws of one name, of which one is gone, one moved and one new: the others must be matched with themselves.
TEST(CaptureDifference, ManyDrawsOfOneName) {
  Capture a = version_2_capture();
  const Draw draw = a.frames[0].draws[1];
  a.frames[0].draws.clear();
  for (int i = 0; i < 6000; ++i) {
    a.frames[0].draws.push_back(draw);
    a.frames[0].draws.back().transform[13] = static_cast<float>(i);
  }
  Capture b = a;
  b.frames[0].draws.erase(b.frames[0].draws.begin() + 100);
  b.frames[0].draws[3000].transform[13] = -1;
  const json frame = difference(a, b)["frames"][0];
  EXPECT_EQ(frame["equal"], 5998);
  ASSERT_EQ(frame["changed"].size(), 1u);
  EXPECT_EQ(frame["changed"][0]["a"], 3001);
  EXPECT_EQ(frame["changed"][0]["b"], 3000);
  EXPECT_EQ(frame["gone"], json::array({{{"draw", 100}, {"name", "list"}}}));
  EXPECT_EQ(frame["reordered"], 0);
  std::shuffle(b.frames[0].draws.begin(), b.frames[0].draws.end(), std::mt19937(1));
  EXPECT_EQ(difference(a, b)["frames"][0]["equal"], 5998);
  EXPECT_GT(difference(a, b)["frames"][0]["reordered"], 5000);
}

class CaptureVerbs : public testing::Test {
 protected:
  CaptureVerbs()
      : folder_(std::filesystem::path(testing::TempDir()) / ("capture_verbs_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    write_capture(version_2_capture(), folder_ / "a.spcap");
  }
  ~CaptureVerbs() override { std::filesystem::remove_all(folder_); }

  tests::Finished run(const std::string& arguments, int code) const {
    SCOPED_TRACE(arguments);
    tests::Finished finished = tests::run_binary(arguments, folder_);
    EXPECT_EQ(finished.code, code) << finished.error;
    // One line for whoever reads it, and for scripts the code.
    EXPECT_EQ(std::count(finished.error.begin(), finished.error.end(), '\n'), code > 1 ? 1 : 0) << finished.error;
    return finished;
  }

  std::filesystem::path folder_;
};

TEST_F(CaptureVerbs, Diff) {
  EXPECT_EQ(run("diff a.spcap a.spcap", 0).out, "the same: 2 frames\n");
  Capture b = version_2_capture();
  b.frames[0].draws[0].name = "\x1b[31m";
  b.frames[0].draws[0].transform[12] = 9;
  b.frames[0].exposure = 2;
  write_capture(b, folder_ / "b.spcap");
  const std::string text = run("diff a.spcap b.spcap", 1).out;
  EXPECT_NE(text.find("frame 0: draws 2 -> 2: 1 equal, 1 changed, 0 added, 0 gone\n  exposure 1.0 -> 2.0\n"
                      "  matched: 1 by name, 1 by mesh\n"
                      "  draw 0 indexed: by mesh; renamed '\\x1b[31m'; moved 9\nframe 1: the same"),
            std::string::npos)
      << text;
  EXPECT_EQ(json::parse(run("diff a.spcap b.spcap --json", 1).out)["frames"][0]["changed"][0]["renamed"], "\x1b[31m");
  b.frames[0].draws[0].material = 0;
  b.frames[0].draws[0].index_count = 3;
  write_capture(b, folder_ / "c.spcap");
  const std::string other = run("diff a.spcap c.spcap", 1).out;
  EXPECT_NE(other.find("  gone: draw 0 indexed\n  added: draw 0 \\x1b[31m\nframe 1: the same"), std::string::npos)
      << other;
  run("diff a.spcap b.spcap --frames 1", 0);
  run("diff a.spcap b.spcap --frames 2", 2);
  run("diff a.spcap missing.spcap", 3);
}

TEST_F(CaptureVerbs, Trim) {
  const tests::Finished trimmed = run("trim a.spcap t.spcap --frames 0 --draws 'ind*'", 0);
  EXPECT_NE(trimmed.out.find("trimmed: frame 0 of 2; 1 of 2 draws, those of ind*"), std::string::npos) << trimmed.out;
  EXPECT_LT(std::filesystem::file_size(folder_ / "t.spcap"), std::filesystem::file_size(folder_ / "a.spcap"));
  EXPECT_NE(run("info t.spcap", 0).out.find("trimmed: frame"), std::string::npos);
  run("validate t.spcap", 0);
  run("trim a.spcap u.spcap --frames 5", 2);
  run("trim a.spcap u.spcap --draws tree", 2);
  run("trim a.spcap u.spcap --without '*'", 2);
  run("trim a.spcap u.spcap", 2);
  run("trim a.spcap u.spcap --draws 0 --without 1", 2);
  run("trim missing.spcap u.spcap --frames 0", 3);
  run("trim a.spcap missing/u.spcap --frames 0", 3);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "u.spcap"));
  // Nothing is left out but the file's own words for it.
  EXPECT_EQ(trimmed.out.find("no smaller"), std::string::npos);
  EXPECT_NE(run("trim t.spcap same.spcap --frames 0", 0).out.find("no smaller than before: "), std::string::npos);
}

// Of a file of strips, through the program: it reads them as they are.
TEST_F(CaptureVerbs, TrimOfStrips) {
  Capture strips = version_2_capture();
  std::vector<std::uint16_t> indices;
  for (std::uint32_t i = 0, random = 1; i < 5000; ++i, random = random * 1664525u + 1013904223u) {
    indices.push_back(static_cast<std::uint16_t>((random >> 16) % 4));
  }
  indices[2500] = 0xffff;
  Draw& draw = strips.frames[0].draws[0];
  draw.index_buffer = static_cast<std::uint32_t>(strips.buffers.size());
  draw.index_offset = 0;
  draw.index_count = 5000;
  draw.topology = Topology::triangle_strip;
  draw.restart = true;
  strips.buffers.push_back({"strip", bytes_of(indices)});
  write_capture(strips, folder_ / "strips.spcap");
  const tests::Finished trimmed = run("trim strips.spcap t.spcap --draws indexed", 0);
  EXPECT_LT(std::filesystem::file_size(folder_ / "t.spcap"), std::filesystem::file_size(folder_ / "strips.spcap"));
  EXPECT_NE(trimmed.out.find(" 9990 triangles"), std::string::npos) << trimmed.out;  // 2498 + 2497, of two instances
  EXPECT_TRUE(json::parse(run("diff strips.spcap t.spcap --json", 1).out)["frames"][0]["changed"].empty());
}

TEST_F(CaptureVerbs, InfoOfDraws) {
  const std::string text = run("info a.spcap --draws", 0).out;
  EXPECT_NE(text.find("     0          4         2          4   u16"), std::string::npos) << text;
  EXPECT_NE(text.find("indexed; 1 leaf; base_colour 0 dots, normal 1 file\n"), std::string::npos) << text;
  EXPECT_LT(text.find("indexed; 1"), text.find("list; 0 plain; none"));
  const json document = json::parse(run("info a.spcap --draws --json", 0).out);
  EXPECT_EQ(document["draws_of_frame"]["draws"].size(), 2u);
  EXPECT_EQ(document["draws"], 2);
  EXPECT_EQ(json::parse(run("info a.spcap --draws --frame 1 --json", 0).out)["draws_of_frame"]["frame"], 1);
  run("info a.spcap --draws --frame 2", 2);
  run("info a.spcap --frame 0", 2);
}

}  // namespace
}  // namespace subpixel::capture
