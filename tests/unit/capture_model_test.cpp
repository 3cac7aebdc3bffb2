// The validator's notes, the recorder's contract, the summary, cameras and meshes.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <map>

#include "capture_format/checks.hpp"
#include "capture_format/reading/summary.hpp"
#include "capture_format/reading/validator.hpp"
#include "capture_format/recorder.hpp"
#include "capture_format/writer.hpp"
#include "scenes/builder/camera.hpp"
#include "scenes/builder/mesh.hpp"
#include "tests/unit/capture_fixture.hpp"

namespace subpixel::capture {
namespace {

std::size_t count(const std::vector<Problem>& problems, Problem::Severity severity, std::string_view text) {
  std::size_t found = 0;
  for (const Problem& problem : problems) {
    found +=
        problem.severity == severity && (problem.where + ": " + problem.why).find(text) != std::string::npos ? 1 : 0;
  }
  return found;
}

TEST(CaptureValidator, FindsNothingWrongWithAGoodCapture) {
  const std::vector<Problem> problems = validate_capture(small_capture());
  EXPECT_EQ(count(problems, Problem::Severity::error, ""), 0u);
  EXPECT_EQ(count(problems, Problem::Severity::note, "frame 1: no draw calls"), 1u);
}

TEST(CaptureValidator, NotesOddVerticesButTakesThem) {
  Capture capture = small_capture();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(capture.buffers[0].bytes.data() + 20, &nan, sizeof nan);
  capture.buffers[0].bytes[14] = std::byte{0};
  const std::vector<Problem> problems = validate_capture(capture);
  EXPECT_EQ(count(problems, Problem::Severity::error, ""), 0u);
  EXPECT_EQ(count(problems, Problem::Severity::note, "field position: 1 of its vertices are not finite"), 2u);
  EXPECT_EQ(count(problems, Problem::Severity::note, "field normal: 1 of its normals have no direction"), 1u);
  EXPECT_EQ(refusal(encode_capture(capture)), "");
}

TEST(CaptureValidator, NotesOddUvsAndColours) {
  Capture capture = version_2_capture();
  EXPECT_EQ(count(validate_capture(capture), Problem::Severity::note, "field"), 0u);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  capture.buffers[5].bytes = bytes_of(std::vector<float>{nan, 0, 0, 1, 1, 1, nan, 1, 1, 1, -1, 1});
  Draw& draw = capture.frames[0].draws[0];
  draw.uv2 = {5, VertexFormat::float32x2, 0, 8};
  draw.colour = {5, VertexFormat::float32x4, 0, 0};
  std::vector<Problem> problems = validate_capture(capture);
  EXPECT_EQ(count(problems, Problem::Severity::note, "field uv2: 2 of its uvs are not finite"), 1u);
  EXPECT_EQ(count(problems, Problem::Severity::note, "field colour: 4 of its colours are negative or not finite"), 1u);
  draw.colour = {5, VertexFormat::float32x4, 16, 16};
  draw.vertex_count = 2;
  draw.index_count = 0;
  EXPECT_EQ(count(validate_capture(capture), Problem::Severity::note, "field colour: 2 of its colours"), 1u)
      << "alpha NaN, blue negative";
  EXPECT_EQ(count(validate_capture(capture), Problem::Severity::error, ""), 0u);
  capture.materials[1].normal_uv.matrix = {1, 2, 0, 2, 4, 0};
  EXPECT_EQ(count(validate_capture(capture), Problem::Severity::note, "material 1, field normal_uv.matrix: singular"),
            1u);
}

TEST(CaptureValidator, NotesUvSetsThatAreAbsentOrUnused) {
  Capture capture = version_2_capture();
  capture.frames.push_back(capture.frames[0]);
  for (Frame& frame : capture.frames) {
    for (Draw& draw : frame.draws) draw.uv2 = {};
  }
  std::vector<Problem> problems = validate_capture(capture);
  EXPECT_EQ(count(problems, Problem::Severity::error, ""), 0u);
  EXPECT_EQ(count(problems, Problem::Severity::note,
                  "frame 0, draw 0 (indexed), field uv2: absent: the textures of material 1 are read at (0, 0)"),
            1u);
  EXPECT_EQ(count(problems, Problem::Severity::note, "absent"), 1u) << "the third frame has the same draws";
  EXPECT_EQ(refusal(encode_capture(capture)), "");

  for (Material& material : capture.materials) material.normal_uv.set = material.base_colour_uv.set = 0;
  for (Frame& frame : capture.frames) {
    for (Draw& draw : frame.draws) draw.uv2 = draw.position, draw.uv = {};
  }
  problems = validate_capture(capture);
  EXPECT_EQ(count(problems, Problem::Severity::note, "field uv: absent: the textures of material 1 are read at (0, 0)"),
            1u);
  EXPECT_EQ(count(problems, Problem::Severity::note, "field uv2: unused: no texture of material 1"), 1u);
  EXPECT_EQ(count(problems, Problem::Severity::note, "field uv2: unused: no texture of material 0"), 1u);
}

// Perspective and parallel, of every convention: a view that mirrors is noted, and so is a projection, but not both.
TEST(CaptureValidator, NotesViewsThatMirror) {
  const Capture whole = small_capture();
  for (const ClipDepth depth : {ClipDepth::zero_to_one, ClipDepth::one_to_zero, ClipDepth::minus_one_to_one}) {
    for (const bool is_y_up : {false, true}) {
      for (const bool is_parallel : {false, true}) {
        Capture capture = whole;
        Frame& frame = capture.frames[0];
        frame.clip_depth = depth;
        frame.clip_y_up = is_y_up;
        // Near at z = -1 and far at z = -3 along the view; depth is (a z + b) / w.
        const float at_near = depth == ClipDepth::one_to_zero ? 1.0f : depth == ClipDepth::zero_to_one ? 0.0f : -1.0f;
        const float at_far = depth == ClipDepth::one_to_zero ? 0.0f : 1.0f;
        const float w_far = is_parallel ? 1.0f : 3.0f;
        const float a = (at_near - at_far * w_far) / 2, b = at_near + a;
        frame.projection = {2, 0,
                            0, 0,
                            0, is_y_up ? 2.0f : -2.0f,
                            0, 0,
                            0, 0,
                            a, is_parallel ? 0.0f : -1.0f,
                            0, 0,
                            b, is_parallel ? 1.0f : 0.0f};
        const auto notes = [&] { return count(validate_capture(capture), Problem::Severity::note, "mirrors"); };
        EXPECT_EQ(notes(), 0u) << static_cast<int>(depth) << is_y_up << is_parallel;
        frame.view[0] = -1;
        EXPECT_EQ(count(validate_capture(capture), Problem::Severity::note, "frame 0, field view: mirrors"), 1u);
        frame.projection[5] *= -1;
        EXPECT_EQ(notes(), 0u);
        frame.view[0] = 1;
        EXPECT_EQ(notes(), 1u);
        EXPECT_EQ(count(validate_capture(capture), Problem::Severity::error, ""), 0u);
      }
    }
  }
}

TEST(CaptureValidator, CollectsEveryBrokenRule) {
  Capture capture = small_capture();
  capture.metadata.metres_per_unit = 0;
  capture.materials[0].roughness = 2;
  capture.frames[0].view = {};
  capture.frames[0].draws[0].position.buffer = 99;
  capture.frames[0].draws[1].transform[0] = std::numeric_limits<float>::infinity();
  capture.frames[1].point_lights = {PointLight{{0, 0, 0}, {-1, 0, 0}, 0}};
  const std::vector<Problem> problems = validate_capture(capture);
  for (const char* text :
       {"metadata, field metres_per_unit", "material 0, field roughness", "frame 0, field view: singular",
        "draw 0 (indexed), field position.buffer", "draw 1 (list), field transform",
        "point_lights[0].intensity: negative", "point_lights[0].range"}) {
    EXPECT_EQ(count(problems, Problem::Severity::error, text), 1u) << text;
  }
}

TEST(CaptureValidator, StopsAtAThousand) {
  Capture capture;
  capture.materials.resize(5000);
  for (Material& material : capture.materials) material.metallic = -1;
  EXPECT_EQ(validate_capture(capture).size(), 1000u);
}

TEST(CaptureWriter, RefusesWhatTheReaderWould) {
  Capture capture = small_capture();
  capture.frames[0].draws[0].index_offset = 0;
  try {
    encode_capture(capture);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("frame 0, draw 0, field index_buffer"), std::string::npos) << error.what();
  }
}

TEST(CaptureChecks, Utf8) {
  for (const char* good : {"", "plain", "\xc3\xa4", "\xe2\x82\xac", "\xf0\x9f\x8c\xb3", "\xed\x9f\xbf"}) {
    EXPECT_TRUE(is_utf8(good)) << good;
  }
  // A lone continuation, an overlong form, a surrogate, beyond Unicode, sequences cut short.
  for (const char* bad :
       {"\x80", "\xc0\xaf", "\xe0\x80\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xc3", "\xe2\x82", "a\xff"}) {
    EXPECT_FALSE(is_utf8(bad)) << bad;
  }
}

TEST(CaptureRecorder, MakesTheSameCapture) {
  const Capture wanted = small_capture();
  Recorder recorder(wanted.metadata);
  for (const Buffer& buffer : wanted.buffers) recorder.add_buffer(buffer.name, buffer.bytes);
  EXPECT_EQ(recorder.capture().buffers.size(), 4u) << "equal buffers are one";
  for (const Texture& texture : wanted.textures) recorder.add_texture(texture);
  EXPECT_EQ(recorder.add_texture(wanted.textures[0]), 0u);
  for (const Material& material : wanted.materials) recorder.add_material(material);
  for (const Frame& frame : wanted.frames) {
    Frame head = frame;
    head.draws.clear();
    recorder.begin_frame(head);
    for (Draw draw : frame.draws) {
      if (draw.uv.buffer == 3) draw.uv.buffer = 0;
      recorder.draw(draw);
    }
    recorder.end_frame();
  }
  EXPECT_EQ(recorder.capture().frames.size(), 2u);
  EXPECT_EQ(refusal(encode_capture(recorder.capture())), "");
  const Capture taken = recorder.take();
  EXPECT_EQ(taken.frames[0].draws.size(), 2u);
  EXPECT_TRUE(recorder.capture().frames.empty());
}

TEST(CaptureRecorder, EqualTexturesWithOtherSamplersAreOthers) {
  Recorder recorder(Metadata{});
  const Texture texture = small_capture().textures[0];
  EXPECT_EQ(recorder.add_texture(texture), 0u);
  std::vector<Texture> others(5, texture);
  others[0].sampler.wrap_u = Wrap::clamp_to_edge;
  others[1].sampler.wrap_v = Wrap::clamp_to_edge;
  others[2].sampler.magnify = TexelFilter::nearest;
  others[3].sampler.minify = TexelFilter::nearest;
  others[4].sampler.mip = MipFilter::nearest;
  for (std::uint32_t i = 0; i < others.size(); ++i) EXPECT_EQ(recorder.add_texture(others[i]), i + 1);
  for (std::uint32_t i = 0; i < others.size(); ++i) EXPECT_EQ(recorder.add_texture(others[i]), i + 1);
  EXPECT_EQ(recorder.add_texture(texture), 0u);
  const Capture read = decode_capture(encode_capture(recorder.take()));
  ASSERT_EQ(read.textures.size(), 6u);
  EXPECT_EQ(read.textures[5].sampler, others[4].sampler);
}

TEST(CaptureRecorder, RefusesAtTheCallAndGoesOn) {
  Recorder recorder(Metadata{});
  EXPECT_THROW(recorder.draw(Draw{}), UsageError);
  EXPECT_THROW(recorder.end_frame(), UsageError);
  Frame negative;
  negative.exposure = -1;
  EXPECT_THROW(recorder.begin_frame(negative), UsageError);
  Material material;
  material.base_colour_texture = 0;
  EXPECT_THROW(recorder.add_material(material), UsageError);
  recorder.begin_frame(Frame{});
  EXPECT_THROW(recorder.begin_frame(Frame{}), UsageError);
  EXPECT_THROW(recorder.save("never"), UsageError);
  try {
    recorder.draw(Draw{});
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_EQ(std::string(error.what()), "can't record the draw: 0 is not below 0: field material");
  }
  recorder.end_frame();
  EXPECT_EQ(recorder.capture().frames.size(), 1u);
}

TEST(CaptureSummary, CountsAndNamesFeatures) {
  const nlohmann::json summary = summarize(small_capture(), "abc", 123);
  EXPECT_EQ(summary["frame_count"], 2);
  EXPECT_EQ(summary["width"], 64);
  EXPECT_EQ(summary["triangles"], 5);
  EXPECT_EQ(summary["draws"], 2);
  EXPECT_EQ(summary["point_lights"], 2);
  EXPECT_EQ(summary["hash"], "abc");
  EXPECT_EQ(summary["features"], (nlohmann::json{"textures", "alpha test", "normal maps", "emissive", "two-sided",
                                                 "instancing", "shadows"}));
  EXPECT_EQ(summary["feature_reasons"]["alpha test"], "1 of 2 materials: leaf");
  EXPECT_EQ(summary["frames"][1]["draws"], 0);
  EXPECT_EQ(summary["notices"], nlohmann::json::array());
  EXPECT_TRUE(used_features(Capture{}).empty());
}

TEST(CaptureSummary, NamesWhatVersion2Adds) {
  Capture capture = version_2_capture();
  const nlohmann::json summary = summarize(capture, "abc", 123);
  EXPECT_EQ(summary["notices"], (nlohmann::json{"ignored: morph targets of 3 meshes", ""}));
  const std::vector<std::string> all{
      "textures",    "alpha test",     "normal maps",   "emissive",           "two-sided", "instancing", "shadows",
      "spot lights", "vertex colours", "second UV set", "texture transforms", "samplers",  "unlit"};
  EXPECT_EQ(summary["features"], nlohmann::json(all));
  const auto has = [&](const char* feature) {
    return std::ranges::any_of(used_features(capture), [&](const UsedFeature& used) { return used.name == feature; });
  };
  // What stands in a capture without any effect is not used.
  capture.materials[1].base_colour_texture = capture.materials[1].normal_texture = kNone;
  EXPECT_FALSE(has("second UV set"));
  EXPECT_FALSE(has("texture transforms"));
  EXPECT_FALSE(has("samplers"));
  capture.materials[1].emissive_texture = 0;
  EXPECT_TRUE(has("texture transforms"));
  EXPECT_TRUE(has("samplers"));
  capture.frames[0].draws[0].material = 0;
  EXPECT_FALSE(has("unlit"));
}

// Why a feature is needed: which materials, or how many draws or frames, of those that are drawn.
TEST(CaptureSummary, SaysWhyAFeatureIsNeeded) {
  Capture capture;
  capture.materials.resize(8);
  for (std::size_t i = 0; i < 8; ++i) {
    capture.materials[i].name = i == 1 ? "" : "m" + std::to_string(i);
    capture.materials[i].metallic = 1;
  }
  capture.materials[0].name = "a\nb" + std::string(100, 'x');
  capture.frames.resize(3);
  capture.frames[1].sun.emplace();
  capture.frames[1].sun->shadows = true;
  Draw draw;
  for (std::uint32_t i : {0u, 1u}) {
    draw.material = i;
    draw.instance_count = i + 1;
    capture.frames[i].draws.push_back(draw);
  }
  const auto why = [&](const char* feature) {
    for (const UsedFeature& used : used_features(capture))
      if (used.name == feature) return used.why;
    return std::string("not needed");
  };
  EXPECT_EQ(why("instancing"), "1 of 2 draws");
  EXPECT_EQ(why("shadows"), "1 of 3 frames have a sun that casts them");
  EXPECT_EQ(why("alpha test"), "not needed");
  const std::string metal = why("metal");
  EXPECT_TRUE(metal.starts_with("2 of 2 materials: a\\x0ab")) << metal;
  EXPECT_TRUE(metal.ends_with(", material 1")) << metal;
  EXPECT_LT(metal.size(), 120u);
  for (std::uint32_t i = 2; i < 8; ++i) {
    draw.material = i;
    capture.frames[2].draws.push_back(draw);
  }
  capture.materials[7].metallic = 0;
  EXPECT_TRUE(why("metal").starts_with("7 of 8 materials: ")) << why("metal");
  EXPECT_TRUE(why("metal").ends_with(", material 1, m2, m3, m4 and 2 more")) << why("metal");
}

TEST(CaptureCamera, SineIsTheMachinesToElevenDigits) {
  for (int i = -100000; i <= 100000; ++i) {
    const double x = i * 0.0137;
    ASSERT_NEAR(sine(x), std::sin(x), 1e-12) << x;
    ASSERT_NEAR(cosine(x), std::cos(x), 1e-12) << x;
  }
  EXPECT_EQ(sine(0), 0.0);
  EXPECT_EQ(cosine(0), 1.0);
}

TEST(CaptureCamera, ProjectionIsReversedAndPointsDown) {
  const glm::dmat4 projection = perspective(90, 2, 0.1);
  const glm::dvec4 near = projection * glm::dvec4(0, 0, -0.1, 1);
  EXPECT_NEAR(near.z / near.w, 1, 1e-12);
  const glm::dvec4 corner = projection * glm::dvec4(20, 10, -10, 1);
  EXPECT_NEAR(corner.x / corner.w, 1, 1e-12);
  EXPECT_NEAR(corner.y / corner.w, -1, 1e-12);
  EXPECT_NEAR(corner.z / corner.w, 0.01, 1e-12);
}

TEST(CaptureCamera, LooksAtItsTarget) {
  for (const glm::dvec3 target : {glm::dvec3(1, 2, -5), {0, 9, 0.001}, {4, -9, 3}}) {
    const glm::dvec3 eye(0.5, 1, 2);
    const glm::dmat4 view = look_at(eye, target);
    const glm::dvec4 seen = view * glm::dvec4(target, 1);
    EXPECT_NEAR(seen.x, 0, 1e-12);
    EXPECT_NEAR(seen.y, 0, 1e-12);
    EXPECT_NEAR(seen.z, -glm::length(target - eye), 1e-12);
    EXPECT_NEAR(glm::determinant(view), 1, 1e-12);
  }
}

TEST(CaptureCamera, PathPassesItsKeysWithoutCorners) {
  const CameraPath path(
      {{0, {0, 0, 0}, {0, 0, -1}, 50}, {1, {1, 0, 0}, {0, 1, -1}, 50}, {3, {1, 4, 0}, {0, 0, -2}, 60}});
  EXPECT_EQ(path.at(-1).eye, glm::dvec3(0, 0, 0));
  EXPECT_EQ(path.at(9).eye, glm::dvec3(1, 4, 0));
  EXPECT_NEAR(glm::length(path.at(1).eye - glm::dvec3(1, 0, 0)), 0, 1e-12);
  constexpr double kStep = 1e-5;
  const glm::dvec3 before = (path.at(1).eye - path.at(1 - kStep).eye) / kStep;
  const glm::dvec3 after = (path.at(1 + kStep).eye - path.at(1).eye) / kStep;
  EXPECT_NEAR(glm::length(before - after), 0, 1e-3);
}

// Each edge of a closed mesh is walked once in each direction, by position.
bool is_closed(const Mesh& mesh) {
  std::map<std::array<double, 6>, int> edges;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec3& a = mesh.positions[mesh.indices[i + k]];
      const glm::dvec3& b = mesh.positions[mesh.indices[i + (k + 1) % 3]];
      ++edges[{a.x, a.y, a.z, b.x, b.y, b.z}];
      --edges[{b.x, b.y, b.z, a.x, a.y, a.z}];
    }
  }
  return std::all_of(edges.begin(), edges.end(), [](const auto& edge) { return edge.second == 0; });
}

TEST(CaptureMesh, SolidsAreClosedAndFaceOutwards) {
  Mesh box;
  add_box(box, {-1, -2, -3}, {1, 2, 3});
  Mesh sphere;
  add_sphere(sphere, {0, 0, 0}, 2, 8);
  Mesh bar;
  add_bar(bar, {0, -1, 0}, {0.5, 1, 0.2}, 0.3, 7);
  for (const Mesh* mesh : {&box, &sphere, &bar}) {
    EXPECT_TRUE(is_closed(*mesh));
    double volume = 0;  // positive when the faces are counter-clockwise from outside
    for (std::size_t i = 0; i < mesh->indices.size(); i += 3) {
      const glm::dvec3& a = mesh->positions[mesh->indices[i]];
      const glm::dvec3& b = mesh->positions[mesh->indices[i + 1]];
      const glm::dvec3& c = mesh->positions[mesh->indices[i + 2]];
      volume += glm::dot(a, glm::cross(b, c)) / 6;
      EXPECT_GT(glm::dot(glm::cross(b - a, c - a), mesh->normals[mesh->indices[i]]), 0) << "against its normal";
    }
    EXPECT_GT(volume, 0.1);
  }
}

TEST(CaptureMesh, TangentsFollowTheTexture) {
  Mesh mesh;
  add_quad(mesh, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  compute_tangents(mesh);
  for (const glm::dvec4& tangent : mesh.tangents) {
    EXPECT_NEAR(glm::length(glm::dvec3(tangent) - glm::dvec3(1, 0, 0)), 0, 1e-12);
    EXPECT_EQ(tangent.w, 1.0) << "cross(normal, tangent) is up the image";
  }
}

}  // namespace
}  // namespace subpixel::capture
