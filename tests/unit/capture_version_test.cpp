// Versions 1 and 2 of the format: which one a capture is written in, and every field and rule that version 2 added.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "base/hash.hpp"
#include "capture_format/limits.hpp"
#include "capture_format/reading/validator.hpp"
#include "capture_format/record_writer.hpp"
#include "tests/unit/capture_forgery.hpp"

namespace subpixel::capture {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

std::uint32_t version_of(std::span<const std::byte> file) {
  std::uint32_t version = 0;
  std::memcpy(&version, file.data() + 8, sizeof version);
  return version;
}

Material& leaf(Capture& capture) {
  return capture.materials[1];
}
Draw& indexed(Capture& capture) {
  return capture.frames[0].draws[0];
}
SpotCone& cone(Capture& capture) {
  return capture.frames[0].point_lights[1].cone.value();
}

// Size and hash are those of the file that was written before there was a version 2.
TEST(CaptureVersion, WhatVersion1CouldSayKeepsItsBytes) {
  const std::vector<std::byte> bytes = encode_capture(small_capture(), {.zstd_level = 0});
  EXPECT_EQ(bytes.size(), 2560u);
  EXPECT_EQ(content_hash_hex(bytes), "74d8216466d97094669dc457a27b0958");
  EXPECT_EQ(version_of(bytes), 1u);
  const Capture read = decode_capture(bytes);
  EXPECT_EQ(encode_capture(read, {.zstd_level = 0}), bytes);
  EXPECT_TRUE(read.metadata.notices.empty());
  EXPECT_EQ(read.textures[0].sampler, Sampler{});
  EXPECT_EQ(read.materials[1].normal_scale, 1.0f);
  EXPECT_EQ(read.materials[1].normal_uv, UvMapping{});
  EXPECT_EQ(read.frames[0].draws[0].uv2.buffer, kNone);
  EXPECT_EQ(read.frames[0].draws[0].colour.buffer, kNone);
  EXPECT_FALSE(read.frames[0].point_lights[0].cone.has_value());
}

TEST(CaptureVersion, EveryFieldComesBack) {
  const Capture capture = version_2_capture();
  const std::vector<std::byte> bytes = encode_capture(capture);
  EXPECT_EQ(version_of(bytes), 2u);
  const Capture read = decode_capture(bytes);
  EXPECT_EQ(encode_capture(read), bytes);
  EXPECT_EQ(read.metadata.title, "Small");
  EXPECT_EQ(read.metadata.notices, capture.metadata.notices);
  EXPECT_EQ(read.textures[0].sampler, capture.textures[0].sampler);
  EXPECT_EQ(read.textures[1].sampler, Sampler{});
  EXPECT_EQ(read.textures[1].bytes, capture.textures[1].bytes);
  const Material& material = read.materials[1];
  EXPECT_TRUE(material.two_sided);
  EXPECT_EQ(material.normal_scale, -0.5f);
  EXPECT_TRUE(material.unlit);
  EXPECT_EQ(material.base_colour_uv, capture.materials[1].base_colour_uv);
  EXPECT_EQ(material.metallic_roughness_uv, capture.materials[1].metallic_roughness_uv);
  EXPECT_EQ(material.normal_uv, capture.materials[1].normal_uv);
  EXPECT_EQ(material.emissive_uv, capture.materials[1].emissive_uv);
  EXPECT_FALSE(read.materials[0].unlit);
  const Draw& draw = read.frames[0].draws[0];
  EXPECT_EQ(draw.instance_count, 2u);
  EXPECT_EQ(draw.uv2.buffer, 5u);
  EXPECT_EQ(draw.uv2.format, VertexFormat::float32x2);
  EXPECT_EQ(draw.uv2.stride, 12u);
  EXPECT_EQ(draw.colour.format, VertexFormat::unorm8x4);
  EXPECT_EQ(draw.colour.offset, 8u);
  EXPECT_EQ(read.frames[0].draws[1].name, "list");
  EXPECT_EQ(read.frames[0].draws[1].colour.buffer, kNone);
  EXPECT_FALSE(read.frames[0].point_lights[0].cone.has_value());
  const SpotCone& spot = read.frames[0].point_lights[1].cone.value();
  EXPECT_EQ(spot.direction, (Float3{0, 0, -2}));
  EXPECT_EQ(spot.inner_cosine, 0.9f);
  EXPECT_EQ(spot.outer_cosine, -0.25f);
}

TEST(CaptureVersion, EachFieldAloneNeedsVersion2) {
  const std::function<void(Capture&)> changes[] = {
      [](Capture& c) { c.metadata.notices = {"approximated: clear coat"}; },
      [](Capture& c) { c.textures[1].sampler.wrap_u = Wrap::clamp_to_edge; },
      [](Capture& c) { c.textures[1].sampler.wrap_v = Wrap::mirrored_repeat; },
      [](Capture& c) { c.textures[1].sampler.magnify = TexelFilter::nearest; },
      [](Capture& c) { c.textures[1].sampler.minify = TexelFilter::nearest; },
      [](Capture& c) { c.textures[1].sampler.mip = MipFilter::none; },
      [](Capture& c) { leaf(c).normal_scale = 2; },
      [](Capture& c) { leaf(c).unlit = true; },
      [](Capture& c) { leaf(c).base_colour_uv.set = 1; },
      [](Capture& c) { leaf(c).metallic_roughness_uv.matrix[0] = 2; },
      [](Capture& c) { leaf(c).normal_uv.matrix[5] = 0.5f; },
      [](Capture& c) { leaf(c).emissive_uv.set = 1; },
      [](Capture& c) { indexed(c).uv2 = indexed(c).uv; },
      [](Capture& c) {
        indexed(c).colour = {0, VertexFormat::float32x3, 0, 20};
      },
      [](Capture& c) { indexed(c).uv.format = VertexFormat::unorm8x4; },
      [](Capture& c) {
        indexed(c).normal = {0, VertexFormat::unorm16x4, 0, 20};
      },
      [](Capture& c) { c.frames[0].point_lights[0].cone = SpotCone{}; }};
  for (std::size_t i = 0; i < std::size(changes); ++i) {
    Capture capture = small_capture();
    changes[i](capture);
    const std::vector<std::byte> bytes = encode_capture(capture);
    EXPECT_EQ(version_of(bytes), 2u) << "change " << i;
    EXPECT_EQ(encode_capture(decode_capture(bytes)), bytes) << "change " << i;
  }
}

TEST(CaptureVersion, LevelsOfMeansNeedVersion3) {
  for (const MipFilter mip : {MipFilter::linear_of_means, MipFilter::nearest_of_means}) {
    Capture capture = small_capture();
    capture.textures[1].sampler.mip = mip;
    const std::vector<std::byte> bytes = encode_capture(capture);
    EXPECT_EQ(version_of(bytes), 3u);
    EXPECT_EQ(decode_capture(bytes).textures[1].sampler.mip, mip);
  }
}

TEST(CaptureVersion, Version2WithNothingNewIsReadAndWrittenAsVersion1) {
  Capture capture = small_capture();
  capture.metadata.notices = {"x"};
  Forgery forgery(capture);
  capture.metadata.notices.clear();
  capture.metadata.licence += "12345";  // as long as the notice was
  forgery.replace_payload(ChunkType::metadata, 0, RecordWriter(2).metadata(capture.metadata));
  ASSERT_EQ(forgery.refused(), "");
  EXPECT_EQ(version_of(forgery.bytes()), 2u);
  EXPECT_EQ(version_of(encode_capture(decode_capture(forgery.bytes()))), 1u);
}

TEST(CaptureVersion, EveryTruncationIsRefused) {
  for (const int level : {0, 3}) {
    const std::vector<std::byte> bytes = encode_capture(version_2_capture(), {.zstd_level = level});
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
      ASSERT_NE(refusal(cut), "") << size << " of " << bytes.size() << " bytes";
    }
    EXPECT_EQ(refusal(bytes), "");
  }
}

TEST(CaptureVersion, RecordsOfTheOtherVersionAreRefused) {
  Forgery newer(small_capture());
  newer.set_version(2);
  EXPECT_REFUSED(newer, "chunk META 0, decoded byte 66, field notices");
  Forgery older(version_2_capture());
  older.set_version(1);
  EXPECT_REFUSED(older, "bytes follow the last field");
}

TEST(CaptureVersion, Version1KnowsNoNewVertexFormat) {
  for (const std::uint32_t format : {8u, 9u}) {
    Forgery forgery;
    const std::size_t draw = forgery.find_in_frame(std::array<char, 7>{'i', 'n', 'd', 'e', 'x', 'e', 'd'}) - 4;
    forgery.set_payload(ChunkType::frame, 0, draw + 4 + 7 + 4 + 2 * 20 + 4, format);
    EXPECT_REFUSED(forgery, "field uv.format");
    EXPECT_REFUSED(forgery, std::to_string(format) + " is no vertex format of version 1");
  }
}

struct Lie {
  const char* field;
  std::function<void(Capture&)> tell;
};

const std::vector<Lie>& lies() {
  static const std::vector<Lie> all{
      {"metadata, field notices[0]", [](Capture& c) { c.metadata.notices[0][3] = '\xff'; }},
      {"texture 0, field sampler.wrap_u", [](Capture& c) { c.textures[0].sampler.wrap_u = Wrap{3}; }},
      {"texture 0, field sampler.wrap_v", [](Capture& c) { c.textures[0].sampler.wrap_v = Wrap{0xffffffff}; }},
      {"texture 0, field sampler.magnify", [](Capture& c) { c.textures[0].sampler.magnify = TexelFilter{2}; }},
      {"texture 0, field sampler.minify", [](Capture& c) { c.textures[0].sampler.minify = TexelFilter{2}; }},
      {"texture 0, field sampler.mip", [](Capture& c) { c.textures[0].sampler.mip = MipFilter{5}; }},
      {"material 1, field normal_scale", [](Capture& c) { leaf(c).normal_scale = kInfinity; }},
      {"material 1, field base_colour_uv.set", [](Capture& c) { leaf(c).base_colour_uv.set = 2; }},
      {"material 1, field base_colour_uv.matrix", [](Capture& c) { leaf(c).base_colour_uv.matrix[0] = kNan; }},
      {"material 1, field metallic_roughness_uv.set", [](Capture& c) { leaf(c).metallic_roughness_uv.set = kNone; }},
      {"material 1, field normal_uv.matrix", [](Capture& c) { leaf(c).normal_uv.matrix[2] = kInfinity; }},
      {"material 1, field emissive_uv.matrix", [](Capture& c) { leaf(c).emissive_uv.matrix[5] = -kInfinity; }},
      {"frame 0, field point_lights[1].cone.direction",
       [](Capture& c) {
         cone(c).direction = {0, 0, 0};
       }},
      {"frame 0, field point_lights[1].cone.direction", [](Capture& c) { cone(c).direction[1] = kNan; }},
      {"frame 0, field point_lights[1].cone.inner_cosine", [](Capture& c) { cone(c).inner_cosine = 1.001f; }},
      {"frame 0, field point_lights[1].cone.inner_cosine", [](Capture& c) { cone(c).inner_cosine = kNan; }},
      {"frame 0, field point_lights[1].cone.outer_cosine", [](Capture& c) { cone(c).outer_cosine = -1.001f; }},
      {"frame 0, field point_lights[1].cone.outer_cosine", [](Capture& c) { cone(c).outer_cosine = kNan; }},
      {"frame 0, field point_lights[1].cone.inner_cosine", [](Capture& c) { cone(c).inner_cosine = -0.25f; }},
      {"frame 0, draw 0, field uv2.buffer", [](Capture& c) { indexed(c).uv2.buffer = 6; }},
      {"frame 0, draw 0, field uv2.format", [](Capture& c) { indexed(c).uv2.format = VertexFormat{17}; }},
      {"frame 0, draw 0, field uv2.offset", [](Capture& c) { indexed(c).uv2.offset = 5; }},
      {"frame 0, draw 0, field uv2.offset", [](Capture& c) { indexed(c).uv2.offset = ~0ull; }},
      {"frame 0, draw 0, field uv2.stride", [](Capture& c) { indexed(c).uv2.stride = 7; }},
      {"frame 0, draw 0, field colour.buffer", [](Capture& c) { indexed(c).colour.buffer = 0xfffffffe; }},
      {"frame 0, draw 0, field colour.format", [](Capture& c) { indexed(c).colour.format = VertexFormat{17}; }},
      {"frame 0, draw 0, field colour.offset", [](Capture& c) { indexed(c).colour.offset = 9; }},
      {"frame 0, draw 0, field colour.stride", [](Capture& c) { indexed(c).colour.stride = 3; }}};
  return all;
}

TEST(CaptureVersion, EveryLieIsRefusedByTheReader) {
  for (const Lie& lie : lies()) {
    Capture lying = version_2_capture();
    lie.tell(lying);
    Forgery forgery(version_2_capture());
    const RecordWriter records(2);
    forgery.replace_payload(ChunkType::metadata, 0, records.metadata(lying.metadata));
    forgery.replace_payload(ChunkType::texture, 0, records.texture(lying.textures[0], forgery.texture_data(0)));
    forgery.replace_payload(ChunkType::material, 0, records.materials(lying.materials));
    forgery.replace_payload(ChunkType::frame, 0, records.frame(lying.frames[0]));
    // The reader's message has chunk and record of its own; the field is what all of them name.
    EXPECT_REFUSED(forgery, std::string(lie.field).substr(std::string_view(lie.field).find("field ")));
  }
}

TEST(CaptureVersion, EveryLieIsRefusedByTheWriterAndListedByTheValidator) {
  for (const Lie& lie : lies()) {
    Capture lying = version_2_capture();
    lie.tell(lying);
    try {
      encode_capture(lying);
      ADD_FAILURE() << lie.field;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(lie.field), std::string::npos) << error.what();
    }
    const std::vector<Problem> problems = validate_capture(lying);
    EXPECT_TRUE(std::any_of(problems.begin(), problems.end(), [&](const Problem& problem) {
      const std::string field = std::string(lie.field).substr(std::string_view(lie.field).find(", field"));
      return problem.severity == Problem::Severity::error && problem.where.find(field) != std::string::npos;
    })) << lie.field;
  }
}

TEST(CaptureVersion, FlagsAndCountsOfTheFile) {
  // Where they stand in version_2_capture()'s payloads.
  constexpr std::size_t kNoticeCount = 4 + 5 + 4 + 6 + 4 + 12 + 4 + 23 + 4;
  for (const std::uint32_t count : {1u, 3u, 4096u, kMaxNotices + 1, 0xfffffff0u}) {
    Forgery forgery(version_2_capture());
    ASSERT_EQ(forgery.get<std::uint32_t>(forgery.chunk(ChunkType::metadata) + kChunkHeaderBytes + kNoticeCount), 2u);
    forgery.set_payload(ChunkType::metadata, 0, kNoticeCount, count);
    EXPECT_REFUSED(forgery, "chunk META 0");
  }
  Forgery text(version_2_capture());
  text.set_payload(ChunkType::metadata, 0, kNoticeCount + 4, 0xfffffff0u);
  EXPECT_REFUSED(text, "field notices");
  Forgery unlit(version_2_capture());
  unlit.set_payload(ChunkType::material, 0, 4 + 4 + 5 + 64 + 4, 2u);  // of the material "plain"
  EXPECT_REFUSED(unlit, "material 0, field unlit");
  const std::size_t direction = Forgery(version_2_capture()).find_in_frame(Float3{0, 0, -2});
  for (const std::uint32_t flag : {2u, 0xffffffffu}) {
    Forgery forgery(version_2_capture());
    forgery.set_payload(ChunkType::frame, 0, direction - 4, flag);
    EXPECT_REFUSED(forgery, "field point_lights.has_cone");
  }
  Forgery none(version_2_capture());
  none.set_payload(ChunkType::frame, 0, direction - 4, 0u);
  EXPECT_REFUSED(none, "chunk FRAM 0");
}

TEST(CaptureVersion, NoticesAreLimited) {
  Capture capture = small_capture();
  capture.metadata.notices.resize(kMaxNotices);
  EXPECT_EQ(decode_capture(encode_capture(capture)).metadata.notices.size(), kMaxNotices);
  capture.metadata.notices.emplace_back();
  EXPECT_THROW(encode_capture(capture), InputError);
  capture.metadata.notices = {std::string(kMaxTextBytes + 1, 'x')};
  EXPECT_THROW(encode_capture(capture), InputError);
}

TEST(CaptureVersion, ColoursHaveThreeOrFourComponentsThatAreNotSigned) {
  const bool allowed[] = {false, true, true, false, true, false, false, false, true, true};
  for (std::uint32_t format = 0; format < std::size(allowed); ++format) {
    Capture capture = small_capture();
    indexed(capture).colour = {0, VertexFormat{format}, 0, 20};
    if (allowed[format]) {
      EXPECT_EQ(refusal(encode_capture(capture)), "") << format;
    } else {
      EXPECT_THROW(encode_capture(capture), InputError) << format;
    }
    indexed(capture).colour.buffer = kNone;
    EXPECT_EQ(refusal(encode_capture(capture)), "") << "an absent stream's format is nobody's business";
    indexed(capture).uv2 = {0, VertexFormat{format}, 0, 20};
    EXPECT_EQ(refusal(encode_capture(capture)), "") << format;
  }
}

TEST(CaptureVersion, StrideZeroGivesAllVerticesOneColour) {
  Capture capture = version_2_capture();
  indexed(capture).colour.stride = 0;
  indexed(capture).uv2.stride = 0;
  EXPECT_EQ(refusal(encode_capture(capture)), "");
}

}  // namespace
}  // namespace subpixel::capture
