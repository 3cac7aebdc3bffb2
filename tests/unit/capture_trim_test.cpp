// Parts of captures: what stays is drawn as before, what nobody needs is gone, and what is left is a capture.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "capture_format/limits.hpp"
#include "capture_format/reading/validator.hpp"
#include "capture_format/streams.hpp"
#include "capture_format/tools/difference.hpp"
#include "capture_format/tools/draw_selection.hpp"
#include "capture_format/tools/draw_table.hpp"
#include "capture_format/tools/trim.hpp"
#include "capture_format/writer.hpp"
#include "tests/unit/capture_fixture.hpp"

namespace subpixel::capture {
namespace {

// Draws of one large interleaved buffer, with indices of one more: draw i reads the vertices 10 i to 10 i + 9, through
// a base, through its index values or, every third, without indices.
Capture shared_buffers(std::uint32_t draws) {
  Capture capture;
  const std::uint32_t vertices = 10 * draws;
  std::vector<float> interleaved;
  for (std::uint32_t v = 0; v < vertices; ++v) {
    for (int c = 0; c < 8; ++c) interleaved.push_back(std::sin(static_cast<float>(8 * v + c)));  // position, normal, uv
  }
  std::vector<std::uint32_t> indices;
  capture.textures = {{"used", TextureEncoding::rgba8, true, 1, 1, std::vector<std::byte>(4, std::byte{1})},
                      {"of the last", TextureEncoding::rgba8, true, 1, 1, std::vector<std::byte>(4, std::byte{2})}};
  Frame frame;
  frame.view = frame.projection = Draw{}.transform;
  for (std::uint32_t d = 0; d < draws; ++d) {
    Material material;
    material.name = "material " + std::to_string(d);
    material.base_colour_texture = d + 1 == draws ? 1 : 0;
    capture.materials.push_back(material);
    Draw draw;
    draw.name = "draw " + std::to_string(d);
    draw.material = d;
    draw.position = {0, VertexFormat::float32x3, 0, 32};
    draw.normal = {0, VertexFormat::float32x3, 12, 32};
    draw.uv = {0, VertexFormat::float32x2, 24, 32};
    draw.vertex_count = vertices;
    draw.index_count = 9;
    if (d % 3 == 2) {
      draw.base_vertex = static_cast<std::int32_t>(10 * d);
    } else {
      draw.index_type = IndexType::uint32;
      draw.index_buffer = 1;
      draw.index_offset = 4 * indices.size();
      if (d % 3 == 0) draw.base_vertex = static_cast<std::int32_t>(10 * d);
      for (std::uint32_t i = 0; i < 9; ++i) indices.push_back((d % 3 == 0 ? 0 : 10 * d) + (i * 7) % 10);
    }
    frame.draws.push_back(draw);
  }
  capture.buffers = {
      {"vertices", bytes_of(interleaved)}, {"indices", bytes_of(indices)}, {"nobody's", bytes_of(indices)}};
  capture.frames = {frame};
  return capture;
}

std::vector<float> corners(const Capture& capture, const Draw& draw, VertexStream Draw::*stream) {
  const std::vector<float> values = decode_stream(capture, draw.*stream, draw.vertex_count, 3);
  std::vector<float> result;
  for (const std::uint32_t vertex : decode_indices(capture, draw)) {
    result.insert(result.end(), values.begin() + 3 * vertex, values.begin() + 3 * vertex + 3);
  }
  return result;
}

std::size_t bytes_in_buffers(const Capture& capture) {
  std::size_t bytes = 0;
  for (const Buffer& buffer : capture.buffers) bytes += buffer.bytes.size();
  return bytes;
}

std::string usage_error(const Capture& capture, const TrimOptions& options) {
  try {
    trim(capture, options);
    return "";
  } catch (const UsageError& error) {
    return error.what();
  }
}

TEST(CaptureTrim, AnyDrawsOfSharedBuffersStayAsTheyWere) {
  const Capture whole = shared_buffers(12);
  for (std::uint32_t bits = 1; bits < 1u << 12; bits += 7) {
    std::string list;
    std::vector<std::size_t> kept;
    for (std::uint32_t d = 0; d < 12; ++d) {
      if ((bits >> d & 1) == 0) continue;
      if (!list.empty()) list += ',';
      list += std::to_string(d);
      kept.push_back(d);
    }
    const Capture part = trim(whole, {.keep = list});
    SCOPED_TRACE(list);
    ASSERT_EQ(part.frames[0].draws.size(), kept.size());
    EXPECT_EQ(part.materials.size(), kept.size());
    EXPECT_LE(bytes_in_buffers(part), bytes_in_buffers(whole));
    for (std::size_t k = 0; k < kept.size(); ++k) {
      const Draw &after = part.frames[0].draws[k], &before = whole.frames[0].draws[kept[k]];
      EXPECT_EQ(after.name, before.name);
      EXPECT_EQ(part.materials[after.material].name, whole.materials[before.material].name);
      for (VertexStream Draw::*const stream : {&Draw::position, &Draw::normal, &Draw::uv}) {
        EXPECT_EQ(corners(part, after, stream), corners(whole, before, stream));
        EXPECT_EQ((after.*stream).offset % 4, 0u);
      }
    }
    for (const Problem& problem : validate_capture(part)) {
      EXPECT_NE(problem.severity, Problem::Severity::error) << problem.where << problem.why;
    }
    EXPECT_EQ(refusal(encode_capture(part)), "");
  }
}

TEST(CaptureTrim, OneDrawKeepsNoMoreThanItReads) {
  const Capture part = trim(shared_buffers(12), {.keep = "draw 4"});
  EXPECT_EQ(part.buffers.size(), 2u);
  EXPECT_EQ(part.buffers[0].bytes.size(), 10 * 32u);
  EXPECT_LT(part.buffers[1].bytes.size(), 9 * 4u + 16);  // what was aligned stays so
  EXPECT_EQ(part.frames[0].draws[0].vertex_count, 10u);
  EXPECT_EQ(part.textures.size(), 1u);
  EXPECT_EQ(part.textures[0].name, "used");
  EXPECT_EQ(trim(shared_buffers(12), {.keep = "11"}).textures[0].name, "of the last");
}

TEST(CaptureTrim, EveryKindOfRecordSurvives) {
  for (const char* const list : {"indexed", "list", "0,1", "*"}) {
    const Capture whole = version_2_capture();
    const Capture part = trim(whole, {.frames = {{0, 0}}, .keep = list});
    EXPECT_EQ(refusal(encode_capture(part)), "") << list;
    EXPECT_EQ(part.frames.size(), 1u);
    EXPECT_EQ(part.frames[0].point_lights.size(), 2u);
    if (std::string(list) == "*") {
      EXPECT_TRUE(difference(whole, part, {{0, 0}})["same"].get<bool>()) << difference(whole, part, {{0, 0}}).dump(2);
      EXPECT_TRUE(part.textures[0].sampler == whole.textures[0].sampler);
    }
  }
}

TEST(CaptureTrim, DrawsOfNothingHaveTheirPlaceInEmptyBuffers) {
  Capture capture = version_2_capture();
  Draw& draw = capture.frames[0].draws[0];
  draw.index_count = 0;
  draw.instance_count = 0;
  capture.frames[0].draws[1].index_count = 0;
  EXPECT_EQ(refusal(encode_capture(trim(capture, {.frames = {{0, 0}}}))), "");
  draw.vertex_count = 0;
  EXPECT_EQ(refusal(encode_capture(trim(capture, {.keep = "0"}))), "");
}

TEST(CaptureTrim, BasesThatWouldLeaveTheirBitsStay) {
  Capture capture = shared_buffers(1);
  std::vector<std::uint32_t> indices(9);
  for (std::uint32_t i = 0; i < 9; ++i) indices[i] = 0x80000005u + i % 5;
  capture.buffers[1].bytes = bytes_of(indices);
  capture.frames[0].draws[0].base_vertex = std::numeric_limits<std::int32_t>::min();  // vertices 5 to 9
  ASSERT_EQ(refusal(encode_capture(capture)), "");
  const Capture part = trim(capture, {.keep = "0"});
  EXPECT_EQ(refusal(encode_capture(part)), "");
  EXPECT_EQ(corners(part, part.frames[0].draws[0], &Draw::position),
            corners(capture, capture.frames[0].draws[0], &Draw::position));
}

TEST(CaptureTrim, FramesAndNotices) {
  Capture capture = shared_buffers(3);
  capture.metadata.notices = {"of before"};
  for (int f = 0; f < 4; ++f) {
    capture.frames.push_back(capture.frames[0]);
    capture.frames.back().name = "frame " + std::to_string(f + 1);
  }
  const Capture part = trim(capture, {.frames = {{1, 3}}, .drop = "draw 1"});
  ASSERT_EQ(part.frames.size(), 3u);
  EXPECT_EQ(part.frames[0].name, "frame 1");
  EXPECT_EQ(part.metadata.notices,
            (std::vector<std::string>{"of before", "trimmed: frames 1 to 3 of 5; 6 of 9 draws, without draw 1"}));
  capture.metadata.notices.assign(kMaxNotices, "x");
  EXPECT_EQ(refusal(encode_capture(trim(capture, {.frames = {{0, 0}}}))), "");
}

// Strips and fans of indices in no order, which as lists would be three times as many.
Capture of_strips() {
  Capture capture;
  std::vector<float> positions(3 * 300);
  for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = std::sin(static_cast<float>(i));
  std::vector<std::uint16_t> indices;
  Frame frame;
  frame.view = frame.projection = Draw{}.transform;
  capture.materials.emplace_back();
  std::uint32_t random = 1;
  for (int d = 0; d < 6; ++d) {
    Draw draw;
    draw.name = "draw " + std::to_string(d);
    draw.position = {0, VertexFormat::float32x3, 0, 12};
    draw.vertex_count = 300;
    draw.topology = d % 2 == 0 ? Topology::triangle_strip : Topology::triangle_fan;
    draw.index_count = 3000;
    if (d < 4) {
      draw.index_type = IndexType::uint16;
      draw.index_buffer = 1;
      draw.index_offset = 2 * indices.size();
      draw.base_vertex = d;
      draw.restart = d >= 2;
      for (std::uint32_t i = 0; i < draw.index_count; ++i) {
        random = random * 1664525u + 1013904223u;
        indices.push_back(static_cast<std::uint16_t>(50 + (random >> 16) % 200));
      }
      // Of a part that makes no triangle, but has to be there.
      if (draw.restart) {
        indices[indices.size() - 2] = 0xffff;
        indices[indices.size() - 1] = 290;
        indices[indices.size() - 1000] = 0xffff;
      }
    } else {
      draw.index_count = 100;
      draw.base_vertex = 20 * d;
    }
    frame.draws.push_back(draw);
  }
  capture.buffers = {{"positions", bytes_of(positions)}, {"indices", bytes_of(indices)}};
  capture.frames = {frame};
  return capture;
}

TEST(CaptureTrim, StripsStayStripsAndTheFileGetsSmaller) {
  const Capture whole = of_strips();
  const std::size_t bytes = encode_capture(whole).size();
  for (const std::string list : {"0-3,5", "0-4", "1-5", "2", "3", "4", "5", "2,3"}) {
    SCOPED_TRACE(list);
    const Capture part = trim(whole, {.keep = list});
    const std::vector<std::byte> encoded = encode_capture(part);
    EXPECT_LT(encoded.size(), bytes);
    EXPECT_EQ(refusal(encoded), "");
    for (const Draw& after : part.frames[0].draws) {
      const Draw& before = *std::ranges::find(whole.frames[0].draws, after.name, &Draw::name);
      EXPECT_EQ(after.topology, before.topology);
      EXPECT_EQ(after.restart, before.restart);
      EXPECT_EQ(after.index_count, before.index_count);
      EXPECT_EQ(corners(part, after, &Draw::position), corners(whole, before, &Draw::position));
    }
  }
}

// A file has equal bytes once; the parts of them that are left might be there twice.
TEST(CaptureTrim, EqualBuffersStayOne) {
  Capture whole = shared_buffers(12);
  whole.buffers.push_back({"the same", whole.buffers[0].bytes});
  for (std::size_t d = 6; d < 12; ++d) {
    for (VertexStream Draw::*const stream : {&Draw::position, &Draw::normal, &Draw::uv}) {
      (whole.frames[0].draws[d].*stream).buffer = 3;
    }
    whole.frames[0].draws[d].normal.offset = 0;  // read otherwise, so that their vertices are no draw's of before
  }
  const Capture part = trim(whole, {.drop = "11"});
  EXPECT_EQ(part.buffers.size(), 2u);
  EXPECT_LT(encode_capture(part).size(), encode_capture(whole).size());
  for (std::size_t d = 0; d < 11; ++d) {
    EXPECT_EQ(corners(part, part.frames[0].draws[d], &Draw::normal),
              corners(whole, whole.frames[0].draws[d], &Draw::normal));
  }
}

TEST(CaptureTrim, Refusals) {
  const Capture capture = shared_buffers(3);
  EXPECT_EQ(usage_error(capture, {.frames = {{0, 1}}}), "frames: 0-1 is not within 0-0: --frames");
  EXPECT_EQ(usage_error(capture, {.frames = {{1, 0}}}), "frames: 1-0 is not within 0-0: --frames");
  EXPECT_EQ(usage_error(capture, {.keep = "draw 0,tree"}), "draws: no draw of the frames is 'tree': --draws");
  EXPECT_EQ(usage_error(capture, {.keep = "3"}), "draws: no draw of the frames is '3': --draws");
  EXPECT_EQ(usage_error(capture, {.drop = "draw*"}), "draws: none is left: --without");
  EXPECT_EQ(usage_error(capture, {.drop = "1,,2"}), "draws: an element of '1,,2' is empty: --without");
  EXPECT_EQ(usage_error(capture, {.keep = "2-1"}), "draws: '2-1' runs backwards: --draws");
  EXPECT_NE(usage_error(capture, {}), "");
  EXPECT_NE(usage_error(capture, {.keep = "0", .drop = "1"}), "");
}

TEST(CaptureTrim, Patterns) {
  EXPECT_TRUE(matches("*", ""));
  EXPECT_TRUE(matches("", ""));
  EXPECT_FALSE(matches("", "a"));
  EXPECT_FALSE(matches("?", ""));
  EXPECT_TRUE(matches("tree*leaf?", "tree 12 leaf leaf3"));
  EXPECT_FALSE(matches("tree*leaf?", "tree 12 leaf"));
  EXPECT_TRUE(matches("*a*b*", "xxaxxbxx"));
  EXPECT_FALSE(matches("*a*b", "xxaxxbxx"));
  EXPECT_FALSE(matches("Tree", "tree"));
  std::string stars;
  for (int i = 0; i < 50; ++i) stars += "a*";
  EXPECT_FALSE(matches(stars + "b", std::string(5000, 'a')));
}

TEST(CaptureDrawTable, SaysWhatEachDrawIs) {
  const nlohmann::json table = draw_table(version_2_capture(), 0);
  EXPECT_EQ(table["name"], "first");
  ASSERT_EQ(table["draws"].size(), 2u);
  const nlohmann::json& draw = table["draws"][0];
  EXPECT_EQ(draw["name"], "indexed");
  EXPECT_EQ(draw["material"], (nlohmann::json{{"number", 1}, {"name", "leaf"}}));
  EXPECT_EQ(draw["triangles"], 4);
  EXPECT_EQ(draw["instances"], 2);
  EXPECT_EQ(draw["vertices"], 4);
  EXPECT_EQ(draw["index_type"], "u16");
  EXPECT_EQ(draw["bytes"], 4 * (12 + 4 + 4 + 8 + 4) + 6 * 2 + 2 * 64);
  EXPECT_EQ(draw["textures"][1], (nlohmann::json{{"slot", "normal_texture"}, {"texture", 1}, {"name", "file"}}));
  EXPECT_EQ(table["draws"][1]["index_type"], "none");
  EXPECT_EQ(draw_table(version_2_capture(), 1)["draws"].size(), 0u);
}

}  // namespace
}  // namespace subpixel::capture
