// The C interface of the recorder: that it says the same as the C++ one, and that no call of whatever kind ends the
// process.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "capture_format/reading/validator.hpp"
#include "capture_format/stream_recorder.hpp"
#include "capture_format/streams.hpp"
#include "capture_format/writer.hpp"
#include "recorder/subpixel_recorder.h"
#include "replay/scene/textures.hpp"
#include "tests/unit/capture_fixture.hpp"
#include "tests/unit/memory_faults.hpp"

namespace subpixel::capture {
namespace {

template <typename T>
T initialised(subpixel_status (*init)(T*, size_t)) {
  T value;
  EXPECT_EQ(init(&value, sizeof value), SUBPIXEL_OK);
  EXPECT_EQ(value.struct_size, sizeof value);
  return value;
}

class RecorderC : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_);
    metadata_ = initialised(subpixel_metadata_init);
    frame_ = initialised(subpixel_frame_init);
    draw_ = initialised(subpixel_draw_init);
    material_ = initialised(subpixel_material_init);
  }
  void TearDown() override {
    subpixel_recorder_destroy(recorder_);
    std::filesystem::remove_all(folder_);
  }

  void create(const subpixel_options* options = nullptr) {
    ASSERT_EQ(subpixel_recorder_create(path_.c_str(), &metadata_, options, &recorder_), SUBPIXEL_OK) << error();
  }

  // A triangle with a material, as resources and in draw_.
  void add_triangle() {
    const float corners[] = {0, 0, -2, 1, 0, -2, 0, 1, -2};
    ASSERT_EQ(subpixel_recorder_add_buffer(recorder_, "corners", corners, sizeof corners, &draw_.position.buffer),
              SUBPIXEL_OK);
    ASSERT_EQ(subpixel_recorder_add_material(recorder_, &material_, &draw_.material), SUBPIXEL_OK);
    draw_.position.stride = 12;
    draw_.vertex_count = draw_.index_count = 3;
  }

  void record_frame() {
    ASSERT_EQ(subpixel_recorder_begin_frame(recorder_, &frame_), SUBPIXEL_OK) << error();
    ASSERT_EQ(subpixel_recorder_draw(recorder_, &draw_), SUBPIXEL_OK) << error();
    ASSERT_EQ(subpixel_recorder_end_frame(recorder_), SUBPIXEL_OK) << error();
  }

  Capture finished() {
    EXPECT_EQ(subpixel_recorder_finish(recorder_), SUBPIXEL_OK) << error();
    return read_capture(path_);
  }

  static std::string error() { return subpixel_recorder_error(); }

  void expect(subpixel_status status, subpixel_status wanted, const std::string& part) {
    EXPECT_EQ(status, wanted) << part;
    EXPECT_NE(error().find(part), std::string::npos) << error() << " lacks " << part;
  }

  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("subpixel_recorder_c_" + std::to_string(::getpid()));
  const std::filesystem::path path_ = folder_ / "recorded.spcap";
  subpixel_recorder* recorder_ = nullptr;
  subpixel_metadata metadata_;
  subpixel_frame frame_;
  subpixel_draw draw_;
  subpixel_material material_;
};

TEST_F(RecorderC, HasVersions) {
  EXPECT_EQ(subpixel_recorder_version(), std::uint32_t{SUBPIXEL_RECORDER_VERSION});
  EXPECT_GE(subpixel_recorder_format_version(), 3u);
  EXPECT_TRUE(std::strchr(subpixel_recorder_release(), '.'));
}

// One draw with all of the defaults by both recorders is the same file.
TEST_F(RecorderC, DefaultsAreThoseOfCpp) {
  create();
  add_triangle();
  subpixel_texture texture = initialised(subpixel_texture_init);
  subpixel_point_light light = initialised(subpixel_point_light_init);
  const subpixel_options options = initialised(subpixel_options_init);
  const std::uint8_t texel[4] = {1, 2, 3, 4};
  texture.bytes = texel, texture.size = 4, texture.width = texture.height = 1;
  std::uint32_t number = 7;
  ASSERT_EQ(subpixel_recorder_add_texture(recorder_, &texture, &number), SUBPIXEL_OK) << error();
  EXPECT_EQ(number, 0u);
  frame_.has_sun = 1, frame_.point_lights = &light, frame_.point_light_count = 1;
  record_frame();
  const Capture c = finished();

  const StreamOptions cpp_options;
  EXPECT_EQ(options.zstd_level, cpp_options.zstd_level);
  EXPECT_EQ(options.queued_bytes, cpp_options.queued_bytes);
  EXPECT_EQ(options.kept_bytes, cpp_options.kept_bytes);
  EXPECT_EQ(options.most_bytes, cpp_options.most_bytes);
  const std::filesystem::path other = folder_ / "cpp.spcap";
  StreamRecorder recorder(Metadata{}, other);
  Draw draw;
  const std::vector<float> corners{0, 0, -2, 1, 0, -2, 0, 1, -2};
  draw.position = {recorder.add_buffer("corners", bytes_of(corners)), VertexFormat::float32x3, 0, 12};
  draw.material = recorder.add_material({});
  draw.vertex_count = draw.index_count = 3;
  recorder.add_texture({"", TextureEncoding::rgba8, false, 1, 1, bytes_of(std::vector<std::uint8_t>{1, 2, 3, 4}), {}});
  Frame frame;
  frame.view = frame.projection = Draw{}.transform;
  frame.sun.emplace();
  frame.point_lights.emplace_back();
  recorder.begin_frame(frame);
  recorder.draw(draw);
  recorder.end_frame();
  recorder.finish();
  EXPECT_EQ(encode_capture(c), encode_capture(read_capture(other)));
}

// Every field has a value of its own, by both recorders: none is lost or exchanged.
TEST_F(RecorderC, EveryFieldArrives) {
  const char* notices[] = {"left out: decals", nullptr};
  metadata_.title = "title", metadata_.application = "application", metadata_.tool = "tool";
  metadata_.licence = "licence", metadata_.metres_per_unit = 0.5f, metadata_.notices = notices;
  metadata_.notice_count = 2;
  subpixel_options options = initialised(subpixel_options_init);
  options.zstd_level = 0, options.queued_bytes = 1000, options.kept_bytes = 2000, options.most_bytes = 1 << 20;
  create(&options);
  const std::vector<std::byte> bytes(400, std::byte{0});
  std::uint32_t buffer = 9, texture_number = 9;
  ASSERT_EQ(subpixel_recorder_add_buffer(recorder_, "bytes", bytes.data(), bytes.size(), &buffer), SUBPIXEL_OK);
  subpixel_texture texture = initialised(subpixel_texture_init);
  texture.name = "texture", texture.bytes = bytes.data(), texture.size = 24, texture.width = 3, texture.height = 2;
  texture.srgb = 1, texture.wrap_u = 1, texture.wrap_v = 2, texture.magnify = 1, texture.minify = 0, texture.mip = 2;
  std::vector<std::uint32_t> textures;
  for (std::uint32_t i = 0; i < 4; ++i) {
    ASSERT_EQ(subpixel_recorder_add_texture(recorder_, &texture, &texture_number), SUBPIXEL_OK) << error();
    EXPECT_EQ(texture_number, i);
    texture.format = SUBPIXEL_TEXTURE_IMAGE_FILE, texture.width = texture.height = 0, texture.size = 30 + i;
  }
  material_.name = "material", material_.alpha_mode = SUBPIXEL_ALPHA_TEST;
  for (int i = 0; i < 4; ++i) material_.base_colour[i] = 0.1f * static_cast<float>(i);
  for (int i = 0; i < 3; ++i) material_.emissive[i] = static_cast<float>(i + 1);
  material_.alpha_cutoff = 0.6f, material_.metallic = 0.7f, material_.roughness = 0.65f, material_.normal_scale = 2;
  material_.two_sided = 1, material_.unlit = 0;
  material_.base_colour_texture = 0, material_.metallic_roughness_texture = 1, material_.normal_texture = 2;
  material_.emissive_texture = 3;
  float value = 0;
  for (subpixel_uv_mapping* mapping :
       {&material_.base_colour_uv, &material_.metallic_roughness_uv, &material_.normal_uv, &material_.emissive_uv}) {
    for (float& m : mapping->matrix) m = ++value;
  }
  material_.normal_uv.set = 1;
  std::uint32_t material = 9;
  ASSERT_EQ(subpixel_recorder_add_material(recorder_, &material_, &material), SUBPIXEL_OK) << error();
  material_.unlit = 1, material_.two_sided = 0;
  ASSERT_EQ(subpixel_recorder_add_material(recorder_, &material_, &draw_.material), SUBPIXEL_OK) << error();
  frame_.name = "frame", frame_.clip_depth = 2, frame_.clip_y_up = 1, frame_.time_s = 1.5, frame_.width = 12;
  frame_.height = 13, frame_.exposure = 1.25f, frame_.has_sun = 1, frame_.sun_shadows = 0;
  for (int i = 0; i < 16; ++i) {
    frame_.view[i] = static_cast<float>(i), frame_.projection[i] = static_cast<float>(20 + i);
    draw_.transform[i] = static_cast<float>(40 + i);
  }
  for (int i = 0; i < 3; ++i) {
    frame_.sky[i] = static_cast<float>(60 + i), frame_.ambient[i] = static_cast<float>(70 + i);
    frame_.sun_direction[i] = static_cast<float>(80 + i), frame_.sun_irradiance[i] = static_cast<float>(90 + i);
  }
  subpixel_point_light lights[2] = {initialised(subpixel_point_light_init), initialised(subpixel_point_light_init)};
  for (int i = 0; i < 3; ++i) {
    lights[1].position[i] = static_cast<float>(i), lights[1].intensity[i] = static_cast<float>(10 + i);
    lights[1].direction[i] = static_cast<float>(20 + i);
  }
  lights[1].range = 30, lights[1].has_cone = 1, lights[1].inner_cosine = 0.75f, lights[1].outer_cosine = 0.25f;
  frame_.point_lights = lights, frame_.point_light_count = 2;
  draw_.name = "draw";
  draw_.position = {buffer, SUBPIXEL_FLOAT32X4, 4, 16};
  draw_.normal = {buffer, SUBPIXEL_SNORM8X4, 8, 4};
  draw_.uv = {buffer, SUBPIXEL_UNORM16X2, 12, 8};
  draw_.tangent = {buffer, SUBPIXEL_SNORM16X4, 16, 12};
  draw_.uv2 = {buffer, SUBPIXEL_FLOAT16X2, 20, 0};
  draw_.colour = {buffer, SUBPIXEL_UNORM8X4, 24, 4};
  draw_.index_type = SUBPIXEL_INDEX_UINT32, draw_.index_buffer = buffer, draw_.index_offset = 28;
  draw_.index_count = 6, draw_.base_vertex = 2, draw_.vertex_count = 5;
  draw_.instance_buffer = buffer, draw_.instance_offset = 32, draw_.instance_count = 3;
  record_frame();
  const Capture c = finished();

  const std::filesystem::path other = folder_ / "cpp.spcap";
  StreamRecorder recorder(Metadata{"title", "application", "tool", "licence", 0.5f, {"left out: decals", ""}}, other);
  recorder.add_buffer("bytes", bytes);
  const Sampler sampler{Wrap::clamp_to_edge, Wrap::mirrored_repeat, TexelFilter::nearest, TexelFilter::linear,
                        MipFilter::none};
  recorder.add_texture({"texture", TextureEncoding::rgba8, true, 3, 2, std::vector<std::byte>(24), sampler});
  for (std::size_t i = 1; i < 4; ++i) {
    recorder.add_texture(
        {"texture", TextureEncoding::image_file, true, 0, 0, std::vector<std::byte>(30 + i - 1), sampler});
  }
  Material paint;
  paint.name = "material";
  paint.base_colour = {0, 0.1f, 0.2f, 0.1f * 3.0f};
  paint.base_colour_texture = 0, paint.alpha_mode = AlphaMode::test, paint.alpha_cutoff = 0.6f;
  paint.metallic = 0.7f, paint.roughness = 0.65f, paint.metallic_roughness_texture = 1, paint.normal_texture = 2;
  paint.emissive = {1, 2, 3}, paint.emissive_texture = 3, paint.two_sided = true, paint.normal_scale = 2;
  paint.base_colour_uv = {0, {1, 2, 3, 4, 5, 6}}, paint.metallic_roughness_uv = {0, {7, 8, 9, 10, 11, 12}};
  paint.normal_uv = {1, {13, 14, 15, 16, 17, 18}}, paint.emissive_uv = {0, {19, 20, 21, 22, 23, 24}};
  recorder.add_material(paint);
  paint.unlit = true, paint.two_sided = false;
  recorder.add_material(paint);
  Frame frame;
  frame.name = "frame", frame.time_s = 1.5, frame.clip_depth = ClipDepth::minus_one_to_one, frame.clip_y_up = true;
  frame.width = 12, frame.height = 13, frame.exposure = 1.25f;
  Draw draw;
  for (std::size_t i = 0; i < 16; ++i) {
    frame.view[i] = static_cast<float>(i), frame.projection[i] = static_cast<float>(20 + i);
    draw.transform[i] = static_cast<float>(40 + i);
  }
  frame.sky = {60, 61, 62}, frame.ambient = {70, 71, 72};
  frame.sun = DirectionalLight{{80, 81, 82}, {90, 91, 92}, false};
  frame.point_lights = {{}, {{0, 1, 2}, {10, 11, 12}, 30, SpotCone{{20, 21, 22}, 0.75f, 0.25f}}};
  draw.name = "draw", draw.material = 1;
  draw.position = {0, VertexFormat::float32x4, 4, 16};
  draw.normal = {0, VertexFormat::snorm8x4, 8, 4};
  draw.uv = {0, VertexFormat::unorm16x2, 12, 8};
  draw.tangent = {0, VertexFormat::snorm16x4, 16, 12};
  draw.uv2 = {0, VertexFormat::float16x2, 20, 0};
  draw.colour = {0, VertexFormat::unorm8x4, 24, 4};
  draw.index_type = IndexType::uint32, draw.index_buffer = 0, draw.index_offset = 28, draw.index_count = 6;
  draw.base_vertex = 2, draw.vertex_count = 5;
  draw.instance_buffer = 0, draw.instance_offset = 32, draw.instance_count = 3;
  recorder.begin_frame(frame);
  recorder.draw(draw);
  recorder.end_frame();
  recorder.finish();
  EXPECT_EQ(encode_capture(c), encode_capture(read_capture(other)));
}

TEST_F(RecorderC, NullIsRefusedByName) {
  std::uint32_t number = 3;
  expect(subpixel_recorder_create(path_.c_str(), &metadata_, nullptr, nullptr), SUBPIXEL_BAD_ARGUMENT, "recorder");
  expect(subpixel_recorder_create(nullptr, &metadata_, nullptr, &recorder_), SUBPIXEL_BAD_ARGUMENT, "path");
  expect(subpixel_recorder_create("", &metadata_, nullptr, &recorder_), SUBPIXEL_BAD_ARGUMENT, "path");
  expect(subpixel_recorder_create(path_.c_str(), nullptr, nullptr, &recorder_), SUBPIXEL_BAD_ARGUMENT, "metadata");
  EXPECT_EQ(recorder_, nullptr);
  expect(subpixel_recorder_add_buffer(nullptr, "", "", 1, &number), SUBPIXEL_BAD_ARGUMENT, "recorder");
  EXPECT_EQ(number, SUBPIXEL_NONE);
  expect(subpixel_recorder_add_texture(nullptr, nullptr, nullptr), SUBPIXEL_BAD_ARGUMENT, "recorder");
  expect(subpixel_recorder_add_material(nullptr, nullptr, nullptr), SUBPIXEL_BAD_ARGUMENT, "recorder");
  expect(subpixel_recorder_begin_frame(nullptr, &frame_), SUBPIXEL_BAD_ARGUMENT, "recorder");
  expect(subpixel_recorder_draw(nullptr, &draw_), SUBPIXEL_BAD_ARGUMENT, "recorder");
  expect(subpixel_recorder_end_frame(nullptr), SUBPIXEL_BAD_ARGUMENT, "recorder");
  expect(subpixel_recorder_finish(nullptr), SUBPIXEL_BAD_ARGUMENT, "recorder");
  EXPECT_EQ(subpixel_recorder_part_path(nullptr), nullptr);
  subpixel_recorder_destroy(nullptr);
  expect(subpixel_metadata_init(nullptr, 64), SUBPIXEL_BAD_ARGUMENT, "null");
  expect(subpixel_options_init(nullptr, 64), SUBPIXEL_BAD_ARGUMENT, "null");
  expect(subpixel_texture_init(nullptr, 64), SUBPIXEL_BAD_ARGUMENT, "null");
  expect(subpixel_material_init(nullptr, 64), SUBPIXEL_BAD_ARGUMENT, "null");
  expect(subpixel_point_light_init(nullptr, 64), SUBPIXEL_BAD_ARGUMENT, "null");
  expect(subpixel_frame_init(nullptr, 64), SUBPIXEL_BAD_ARGUMENT, "null");
  expect(subpixel_draw_init(nullptr, 64), SUBPIXEL_BAD_ARGUMENT, "null");

  metadata_.notice_count = 1;
  expect(subpixel_recorder_create(path_.c_str(), &metadata_, nullptr, &recorder_), SUBPIXEL_BAD_ARGUMENT, "notices");
  metadata_.notice_count = 0;
  create();
  expect(subpixel_recorder_add_buffer(recorder_, "", nullptr, 1, &number), SUBPIXEL_BAD_ARGUMENT, "bytes");
  expect(subpixel_recorder_add_buffer(recorder_, "", "", 1, nullptr), SUBPIXEL_BAD_ARGUMENT, "buffer");
  expect(subpixel_recorder_add_texture(recorder_, nullptr, &number), SUBPIXEL_BAD_ARGUMENT, "texture");
  subpixel_texture texture = initialised(subpixel_texture_init);
  expect(subpixel_recorder_add_texture(recorder_, &texture, nullptr), SUBPIXEL_BAD_ARGUMENT, "number");
  texture.width = texture.height = 1, texture.size = 4;
  expect(subpixel_recorder_add_texture(recorder_, &texture, &number), SUBPIXEL_BAD_ARGUMENT, "bytes");
  expect(subpixel_recorder_add_material(recorder_, nullptr, &number), SUBPIXEL_BAD_ARGUMENT, "material");
  expect(subpixel_recorder_add_material(recorder_, &material_, nullptr), SUBPIXEL_BAD_ARGUMENT, "number");
  expect(subpixel_recorder_begin_frame(recorder_, nullptr), SUBPIXEL_BAD_ARGUMENT, "frame");
  frame_.point_light_count = 1;
  expect(subpixel_recorder_begin_frame(recorder_, &frame_), SUBPIXEL_BAD_ARGUMENT, "point_lights");
  frame_.point_light_count = 0;
  EXPECT_EQ(subpixel_recorder_begin_frame(recorder_, &frame_), SUBPIXEL_OK);
  expect(subpixel_recorder_draw(recorder_, nullptr), SUBPIXEL_BAD_ARGUMENT, "draw");
  // No bytes need no address, and a null text is an empty one.
  EXPECT_EQ(subpixel_recorder_add_buffer(recorder_, nullptr, nullptr, 0, &number), SUBPIXEL_OK);
}

TEST_F(RecorderC, SizesOfStructuresAreHeldToTheVersions) {
  subpixel_draw draw;
  for (const size_t size : {size_t{0}, size_t{4}, sizeof draw - 1, size_t{1} << 20, SIZE_MAX}) {
    expect(subpixel_draw_init(&draw, size), SUBPIXEL_BAD_ARGUMENT, "struct_size");
  }
  metadata_.struct_size = 0;
  expect(subpixel_recorder_create(path_.c_str(), &metadata_, nullptr, &recorder_), SUBPIXEL_BAD_ARGUMENT,
         "metadata: 0 is not what the init function sets: field struct_size");
  metadata_.struct_size = sizeof metadata_;
  subpixel_options options{};
  expect(subpixel_recorder_create(path_.c_str(), &metadata_, &options, &recorder_), SUBPIXEL_BAD_ARGUMENT,
         "struct_size");
  create();
  std::uint32_t number = 0;
  subpixel_texture texture{};
  expect(subpixel_recorder_add_texture(recorder_, &texture, &number), SUBPIXEL_BAD_ARGUMENT, "struct_size");
  material_.struct_size -= 8;
  expect(subpixel_recorder_add_material(recorder_, &material_, &number), SUBPIXEL_BAD_ARGUMENT, "struct_size");
  frame_.struct_size = 0xcccccccc;  // never set
  expect(subpixel_recorder_begin_frame(recorder_, &frame_), SUBPIXEL_BAD_ARGUMENT, "struct_size");
  frame_ = initialised(subpixel_frame_init);
  subpixel_point_light lights[2] = {initialised(subpixel_point_light_init), initialised(subpixel_point_light_init)};
  frame_.point_lights = lights, frame_.point_light_count = 2;
  lights[1].struct_size = sizeof lights[1] + 4;
  expect(subpixel_recorder_begin_frame(recorder_, &frame_), SUBPIXEL_BAD_ARGUMENT, "point_lights[1].struct_size");
  lights[0].struct_size = 0;
  expect(subpixel_recorder_begin_frame(recorder_, &frame_), SUBPIXEL_BAD_ARGUMENT, "struct_size");
  frame_.point_light_count = 0;
  EXPECT_EQ(subpixel_recorder_begin_frame(recorder_, &frame_), SUBPIXEL_OK);
  draw_.struct_size = 8;
  expect(subpixel_recorder_draw(recorder_, &draw_), SUBPIXEL_BAD_ARGUMENT, "struct_size");
}

// Compiled with a header of a later version, whose structures have more at their end.
TEST_F(RecorderC, LaterCallersAreServedAsFarAsTheyAskForNothingNew) {
  struct Later {
    subpixel_draw draw;
    std::uint64_t added, more;
  } later;
  std::memset(&later, 0xab, sizeof later);
  ASSERT_EQ(subpixel_draw_init(&later.draw, sizeof later), SUBPIXEL_OK);
  EXPECT_EQ(later.draw.struct_size, sizeof later);
  EXPECT_EQ(later.draw.instance_count, 1u);
  EXPECT_EQ(later.added, 0u);
  EXPECT_EQ(later.more, 0u);
  create();
  add_triangle();
  later.draw.position = draw_.position, later.draw.index_count = later.draw.vertex_count = 3;
  ASSERT_EQ(subpixel_recorder_begin_frame(recorder_, &frame_), SUBPIXEL_OK);
  EXPECT_EQ(subpixel_recorder_draw(recorder_, &later.draw), SUBPIXEL_OK) << error();
  later.more = 1;
  expect(subpixel_recorder_draw(recorder_, &later.draw), SUBPIXEL_BAD_ARGUMENT, "struct_size");
  EXPECT_EQ(subpixel_recorder_end_frame(recorder_), SUBPIXEL_OK);
  EXPECT_EQ(finished().frames[0].draws.size(), 1u);
}

TEST_F(RecorderC, OrderIsHeldAndRecordingGoesOn) {
  create();
  expect(subpixel_recorder_end_frame(recorder_), SUBPIXEL_BAD_ORDER, "none has begun");
  expect(subpixel_recorder_draw(recorder_, &draw_), SUBPIXEL_BAD_ORDER, "no frame has begun");
  add_triangle();
  record_frame();
  ASSERT_EQ(subpixel_recorder_begin_frame(recorder_, &frame_), SUBPIXEL_OK);
  expect(subpixel_recorder_begin_frame(recorder_, &frame_), SUBPIXEL_BAD_ORDER, "has not ended");
  expect(subpixel_recorder_finish(recorder_), SUBPIXEL_BAD_ORDER, "has not ended");
  EXPECT_EQ(subpixel_recorder_draw(recorder_, &draw_), SUBPIXEL_OK);
  EXPECT_EQ(subpixel_recorder_end_frame(recorder_), SUBPIXEL_OK);
  EXPECT_EQ(finished().frames.size(), 2u);
  std::uint32_t number = 3;
  expect(subpixel_recorder_add_buffer(recorder_, "", "x", 1, &number), SUBPIXEL_BAD_ORDER, "finished");
  EXPECT_EQ(number, SUBPIXEL_NONE);
  expect(subpixel_recorder_add_material(recorder_, &material_, &number), SUBPIXEL_BAD_ORDER, "finished");
  expect(subpixel_recorder_begin_frame(recorder_, &frame_), SUBPIXEL_BAD_ORDER, "finished");
  expect(subpixel_recorder_finish(recorder_), SUBPIXEL_BAD_ORDER, "finished");
  EXPECT_EQ(read_capture(path_).frames.size(), 2u);
}

TEST_F(RecorderC, WrongFieldsAreNamedAndChangeNothing) {
  subpixel_options options = initialised(subpixel_options_init);
  for (const std::int32_t level : {-1, 23}) {
    options.zstd_level = level;
    expect(subpixel_recorder_create(path_.c_str(), &metadata_, &options, &recorder_), SUBPIXEL_BAD_ARGUMENT,
           "zstd_level");
  }
  options.zstd_level = 1, options.most_bytes = 0;
  expect(subpixel_recorder_create(path_.c_str(), &metadata_, &options, &recorder_), SUBPIXEL_BAD_ARGUMENT, "0 bytes");
  metadata_.notice_count = SIZE_MAX;
  expect(subpixel_recorder_create(path_.c_str(), &metadata_, nullptr, &recorder_), SUBPIXEL_BAD_ARGUMENT, "notice");
  metadata_.notice_count = 0, metadata_.title = "\xff";
  expect(subpixel_recorder_create(path_.c_str(), &metadata_, nullptr, &recorder_), SUBPIXEL_BAD_ARGUMENT, "title");
  metadata_.title = "t";
  create();
  add_triangle();

  std::uint32_t number = 3;
  expect(subpixel_recorder_add_buffer(recorder_, "", "x", SIZE_MAX, &number), SUBPIXEL_BAD_ARGUMENT, "size");
  expect(subpixel_recorder_add_buffer(recorder_, "\xff", "x", 1, &number), SUBPIXEL_BAD_ARGUMENT, "name");
  const auto refuse_texture = [&](const char* field, const std::function<void(subpixel_texture&)>& change) {
    const std::uint8_t texel[4] = {};
    subpixel_texture texture = initialised(subpixel_texture_init);
    texture.width = texture.height = 1, texture.size = 4, texture.bytes = texel;
    change(texture);
    expect(subpixel_recorder_add_texture(recorder_, &texture, &number), SUBPIXEL_BAD_ARGUMENT, field);
    EXPECT_EQ(number, SUBPIXEL_NONE);
  };
  refuse_texture("format", [](auto& texture) { texture.format = 10; });
  refuse_texture("srgb", [](auto& texture) { texture.srgb = 2; });
  refuse_texture("size", [](auto& texture) { texture.size = SIZE_MAX; });
  refuse_texture("bytes", [](auto& texture) { texture.size = 3; });
  refuse_texture("width", [](auto& texture) { texture.width = 0; });
  refuse_texture("width", [](auto& texture) { texture.format = SUBPIXEL_TEXTURE_IMAGE_FILE; });
  refuse_texture("wrap_u", [](auto& texture) { texture.wrap_u = 3; });
  refuse_texture("wrap_v", [](auto& texture) { texture.wrap_v = 3; });
  refuse_texture("magnify", [](auto& texture) { texture.magnify = 2; });
  refuse_texture("minify", [](auto& texture) { texture.minify = 2; });
  refuse_texture("mip", [](auto& texture) { texture.mip = 5; });
  refuse_texture("size", [](auto& texture) { texture.format = SUBPIXEL_TEXTURE_BC1; });
  refuse_texture("height", [](auto& texture) { texture.format = SUBPIXEL_TEXTURE_BC7, texture.height = 0; });
  refuse_texture("width", [](auto& texture) { texture.format = SUBPIXEL_TEXTURE_BC7, texture.width = 0xffffffff; });

  const auto refuse_material = [&](const char* field, const std::function<void(subpixel_material&)>& change) {
    subpixel_material material = initialised(subpixel_material_init);
    change(material);
    expect(subpixel_recorder_add_material(recorder_, &material, &number), SUBPIXEL_BAD_ARGUMENT, field);
    EXPECT_EQ(number, SUBPIXEL_NONE);
  };
  refuse_material("alpha_mode", [](auto& material) { material.alpha_mode = 3; });
  refuse_material("two_sided", [](auto& material) { material.two_sided = 2; });
  refuse_material("unlit", [](auto& material) { material.unlit = 2; });
  refuse_material("base_colour", [](auto& material) { material.base_colour[3] = 2; });
  refuse_material("normal_texture", [](auto& material) { material.normal_texture = 0; });
  refuse_material("emissive_uv.set", [](auto& material) { material.emissive_uv.set = 2; });

  const auto refuse_frame = [&](const char* field, const std::function<void(subpixel_frame&)>& change) {
    subpixel_frame frame = initialised(subpixel_frame_init);
    change(frame);
    expect(subpixel_recorder_begin_frame(recorder_, &frame), SUBPIXEL_BAD_ARGUMENT, field);
  };
  subpixel_point_light light = initialised(subpixel_point_light_init);
  refuse_frame("clip_depth", [](auto& frame) { frame.clip_depth = 3; });
  refuse_frame("clip_y_up", [](auto& frame) { frame.clip_y_up = 2; });
  refuse_frame("has_sun", [](auto& frame) { frame.has_sun = 2; });
  refuse_frame("sun_shadows", [](auto& frame) { frame.sun_shadows = 2; });
  refuse_frame("width", [](auto& frame) { frame.width = 0; });
  refuse_frame("point_light_count",
               [&](auto& frame) { frame.point_lights = &light, frame.point_light_count = SIZE_MAX; });
  light.has_cone = 2;
  refuse_frame("has_cone", [&](auto& frame) { frame.point_lights = &light, frame.point_light_count = 1; });
  light.has_cone = 0, light.range = -1;
  refuse_frame("point_lights[0].range", [&](auto& frame) { frame.point_lights = &light, frame.point_light_count = 1; });

  ASSERT_EQ(subpixel_recorder_begin_frame(recorder_, &frame_), SUBPIXEL_OK);
  const auto refuse_draw = [&](const char* field, const std::function<void(subpixel_draw&)>& change) {
    subpixel_draw draw = draw_;
    change(draw);
    expect(subpixel_recorder_draw(recorder_, &draw), SUBPIXEL_BAD_ARGUMENT, field);
  };
  refuse_draw("material", [](auto& draw) { draw.material = 1; });
  refuse_draw("position.buffer", [](auto& draw) { draw.position.buffer = SUBPIXEL_NONE; });
  refuse_draw("position.stride", [](auto& draw) { draw.position.stride = 0; });
  refuse_draw("position.offset", [](auto& draw) { draw.position.offset = UINT64_MAX; });
  refuse_draw("normal.format", [](auto& draw) { draw.normal = {0, 17, 0, 0}; });
  refuse_draw("colour.format", [](auto& draw) { draw.colour = {0, SUBPIXEL_FLOAT32X2, 0, 0}; });
  refuse_draw("position.offset",
              [](auto& draw) { draw.vertex_count = draw.index_count = 0xffffffff, draw.index_type = 9; });
  refuse_draw("topology", [](auto& draw) { draw.topology = 3; });
  refuse_draw("restart", [](auto& draw) { draw.restart = 2; });
  refuse_draw("restart", [](auto& draw) { draw.restart = 1; });
  refuse_draw("index_type", [](auto& draw) { draw.index_type = 4; });
  refuse_draw("index_buffer", [](auto& draw) { draw.index_type = SUBPIXEL_INDEX_UINT16; });
  refuse_draw("index_count", [](auto& draw) { draw.index_count = 2; });
  refuse_draw("instance_count", [](auto& draw) { draw.instance_count = 0; });
  refuse_draw("instance_offset", [](auto& draw) { draw.instance_buffer = 0, draw.instance_offset = UINT64_MAX; });
  // All of which left the recorder as it was.
  EXPECT_EQ(subpixel_recorder_draw(recorder_, &draw_), SUBPIXEL_OK) << error();
  EXPECT_EQ(subpixel_recorder_end_frame(recorder_), SUBPIXEL_OK);
  const Capture capture = finished();
  EXPECT_EQ(capture.frames.size(), 1u);
  EXPECT_EQ(capture.frames[0].draws.size(), 1u);
  EXPECT_EQ(capture.materials.size(), 1u);
  EXPECT_EQ(capture.textures.size(), 0u);
  EXPECT_EQ(capture.buffers.size(), 1u);
}

TEST_F(RecorderC, StripsSmallIndicesAndEveryFormatAreReached) {
  create();
  add_triangle();
  const std::uint8_t order[] = {0, 1, 2, 0xff, 2, 1, 0};
  const std::vector<std::byte> bytes(64);
  std::uint32_t zeros = 9;
  ASSERT_EQ(subpixel_recorder_add_buffer(recorder_, "zeros", bytes.data(), bytes.size(), &zeros), SUBPIXEL_OK);
  ASSERT_EQ(subpixel_recorder_add_buffer(recorder_, "order", order, sizeof order, &draw_.index_buffer), SUBPIXEL_OK);
  draw_.index_type = SUBPIXEL_INDEX_UINT8, draw_.index_count = 7, draw_.restart = 1;
  draw_.topology = SUBPIXEL_TRIANGLE_STRIP;
  ASSERT_EQ(subpixel_recorder_begin_frame(recorder_, &frame_), SUBPIXEL_OK);
  EXPECT_EQ(subpixel_recorder_draw(recorder_, &draw_), SUBPIXEL_OK) << error();
  draw_.topology = SUBPIXEL_TRIANGLE_FAN;
  EXPECT_EQ(subpixel_recorder_draw(recorder_, &draw_), SUBPIXEL_OK) << error();
  for (std::uint32_t format = 0; format <= SUBPIXEL_SNORM16X2; ++format) {
    draw_.normal = {zeros, format, 0, 0};
    EXPECT_EQ(subpixel_recorder_draw(recorder_, &draw_), SUBPIXEL_OK) << error();
  }
  EXPECT_EQ(subpixel_recorder_end_frame(recorder_), SUBPIXEL_OK);
  const Capture capture = finished();
  const std::vector<Draw>& draws = capture.frames[0].draws;
  ASSERT_EQ(draws.size(), 19u);
  EXPECT_EQ(decode_indices(capture, draws[0]), (std::vector<std::uint32_t>{0, 1, 2, 2, 1, 0}));
  for (std::uint32_t format = 0; format <= SUBPIXEL_SNORM16X2; ++format) {
    EXPECT_EQ(draws[format + 2].normal.format, VertexFormat{format});
  }
}

// Fields of a block from its lowest bit on.
class Bits {
 public:
  Bits& put(std::uint32_t value, int count) {
    for (int i = 0; i < count; ++i, ++at_) bytes_[at_ / 8] |= static_cast<std::uint8_t>((value >> i & 1) << at_ % 8);
    return *this;
  }
  std::vector<std::uint8_t> bytes() const { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_ = std::vector<std::uint8_t>(16);
  std::size_t at_ = 0;
};

// Blocks of one colour each, put together from the formats' definitions, are that colour when a replay decodes them: in
// an image whose sides are no multiples of 4, too.
TEST_F(RecorderC, BlockCompressedTexturesDecode) {
  create();
  const std::vector<std::uint8_t> red{0x00, 0xf8, 0, 0, 0, 0, 0, 0};  // 5:6:5, all of the first end
  const std::vector<std::uint8_t> opaque(8, 0xff), full{255, 0, 0, 0, 0, 0, 0, 0}, half{128, 0, 0, 0, 0, 0, 0, 0};
  const auto joined = [](std::vector<std::uint8_t> a, const std::vector<std::uint8_t>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
  };
  const auto bc6 = [](std::uint32_t r, std::uint32_t g) {  // mode 11: ten bits an end, both ends alike
    return Bits().put(3, 5).put(r, 10).put(g, 10).put(0, 10).put(r, 10).put(g, 10).put(0, 10).bytes();
  };
  Bits bc7;  // mode 6: seven bits an end and one in common
  bc7.put(64, 7);
  for (const std::uint32_t value : {127u, 64u, 0u, 127u}) bc7.put(value, 7).put(value, 7);
  bc7.put(3, 2);
  struct Case {
    std::uint32_t format;
    std::vector<std::uint8_t> block;
    std::array<int, 4> texel;
  };
  const std::vector<Case> cases{
      {SUBPIXEL_TEXTURE_BC1, red, {255, 0, 0, 255}},
      {SUBPIXEL_TEXTURE_BC2, joined(opaque, red), {255, 0, 0, 255}},
      {SUBPIXEL_TEXTURE_BC3, joined(half, red), {255, 0, 0, 128}},
      {SUBPIXEL_TEXTURE_BC4, half, {128, 128, 128, 255}},
      {SUBPIXEL_TEXTURE_BC5, joined(half, half), {128, 128, 255, 255}},
      {SUBPIXEL_TEXTURE_BC5, joined(full, half), {255, 128, 128, 255}},
      {SUBPIXEL_TEXTURE_BC6H_UFLOAT, bc6(495, 462), {255, 128, 0, 255}},
      {SUBPIXEL_TEXTURE_BC6H_SFLOAT, bc6(248, 231), {255, 128, 0, 255}},
      {SUBPIXEL_TEXTURE_BC7, bc7.bytes(), {255, 129, 1, 255}},
  };
  for (const Case& c : cases) {
    const std::vector<std::uint8_t> blocks = joined(joined(c.block, c.block), joined(c.block, c.block));
    subpixel_texture texture = initialised(subpixel_texture_init);
    texture.format = c.format, texture.width = 7, texture.height = 5;
    texture.bytes = blocks.data(), texture.size = blocks.size();
    std::uint32_t number = 0;
    ASSERT_EQ(subpixel_recorder_add_texture(recorder_, &texture, &number), SUBPIXEL_OK) << error();
    EXPECT_EQ(number, static_cast<std::uint32_t>(&c - cases.data()));
  }
  add_triangle();
  record_frame();
  const Capture capture = finished();
  ASSERT_EQ(capture.textures.size(), cases.size());
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const replay::Mipmaps decoded = replay::decode_texture(capture.textures[i]);
    ASSERT_EQ(decoded.width, 7u) << i;
    ASSERT_EQ(decoded.height, 5u) << i;
    for (std::size_t byte = 0; byte < decoded.levels[0].size(); ++byte) {
      ASSERT_NEAR(decoded.levels[0][byte], cases[i].texel[byte % 4], 2)
          << "format " << cases[i].format << " byte " << byte;
    }
  }
}

TEST_F(RecorderC, WithoutFinishThePartIsRecovered) {
  create();
  add_triangle();
  for (int i = 0; i < 3; ++i) record_frame();
  const std::filesystem::path part = subpixel_recorder_part_path(recorder_);
  EXPECT_EQ(part, path_.string() + ".part");
  ASSERT_EQ(subpixel_recorder_begin_frame(recorder_, &frame_), SUBPIXEL_OK);
  subpixel_recorder_destroy(std::exchange(recorder_, nullptr));
  EXPECT_FALSE(std::filesystem::exists(path_));
  EXPECT_EQ(recover_capture(part).capture.frames.size(), 3u);
}

TEST_F(RecorderC, WhatCantBeWrittenIsSaidAndLasts) {
  const std::filesystem::path absent = folder_ / "absent" / "x.spcap";
  expect(subpixel_recorder_create(absent.c_str(), &metadata_, nullptr, &recorder_), SUBPIXEL_CANT_WRITE, "absent");
  EXPECT_EQ(recorder_, nullptr);
  // A file-size limit stands for a full disk.
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto signal_before = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit few{20000, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &few), 0);
  subpixel_options options = initialised(subpixel_options_init);
  options.zstd_level = 0;
  create(&options);
  add_triangle();
  subpixel_status status = SUBPIXEL_OK;
  int frames = 0;
  for (; status == SUBPIXEL_OK && frames < 100000; ++frames) {
    status = subpixel_recorder_begin_frame(recorder_, &frame_);
    if (status == SUBPIXEL_OK) status = subpixel_recorder_draw(recorder_, &draw_);
    if (status == SUBPIXEL_OK) status = subpixel_recorder_end_frame(recorder_);
  }
  expect(status, SUBPIXEL_CANT_WRITE, "recorded.spcap.part");
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, signal_before);
  std::uint32_t number = 0;
  expect(subpixel_recorder_add_material(recorder_, &material_, &number), SUBPIXEL_CANT_WRITE, "recorded.spcap.part");
  EXPECT_EQ(number, SUBPIXEL_NONE);
  expect(subpixel_recorder_draw(recorder_, &draw_), SUBPIXEL_CANT_WRITE, "recorded.spcap.part");
  expect(subpixel_recorder_finish(recorder_), SUBPIXEL_CANT_WRITE, "recorded.spcap.part");
  const std::size_t kept = recover_capture(std::filesystem::path(path_.string() + ".part")).capture.frames.size();
  EXPECT_GT(kept, 10u);
  EXPECT_LE(kept, static_cast<std::size_t>(frames));
}

// Refused as an argument, since the recorder still has all that fitted.
TEST_F(RecorderC, MoreThanMostBytesIsRefusedAndTheRestIsThere) {
  subpixel_options options = initialised(subpixel_options_init);
  options.most_bytes = 8000;
  create(&options);
  add_triangle();
  const std::vector<std::byte> bytes(7990);
  std::uint32_t number = 0;
  expect(subpixel_recorder_add_buffer(recorder_, "b", bytes.data(), bytes.size(), &number), SUBPIXEL_BAD_ARGUMENT,
         "passes 8000 bytes");
  record_frame();
  EXPECT_EQ(finished().frames.size(), 1u);
}

// A frame that is refused, or has no memory, has ended, and the recording goes on.
TEST_F(RecorderC, AFrameThatIsRefusedIsDroppedWhole) {
  subpixel_options options = initialised(subpixel_options_init);
  options.most_bytes = 8000;
  create(&options);
  add_triangle();
  record_frame();
  ASSERT_EQ(subpixel_recorder_begin_frame(recorder_, &frame_), SUBPIXEL_OK);
  for (int i = 0; i < 100; ++i) ASSERT_EQ(subpixel_recorder_draw(recorder_, &draw_), SUBPIXEL_OK);
  expect(subpixel_recorder_end_frame(recorder_), SUBPIXEL_BAD_ARGUMENT, "passes 8000 bytes");
  expect(subpixel_recorder_end_frame(recorder_), SUBPIXEL_BAD_ORDER, "none has begun");
  expect(subpixel_recorder_draw(recorder_, &draw_), SUBPIXEL_BAD_ORDER, "no frame has begun");
  ASSERT_EQ(subpixel_recorder_begin_frame(recorder_, &frame_), SUBPIXEL_OK);
  subpixel_status status = SUBPIXEL_OK;
  {
    const tests::MemoryFault fault(0);
    status = subpixel_recorder_end_frame(recorder_);
  }
  expect(status, SUBPIXEL_NO_MEMORY, "no memory");
  std::uint32_t number = 0;
  const float other[] = {1, 2, 3};
  {
    const tests::MemoryFault fault(2);
    status = subpixel_recorder_add_buffer(recorder_, "other", other, sizeof other, &number);
  }
  expect(status, SUBPIXEL_NO_MEMORY, "no memory");
  EXPECT_EQ(number, SUBPIXEL_NONE);
  ASSERT_EQ(subpixel_recorder_add_buffer(recorder_, "other", other, sizeof other, &number), SUBPIXEL_OK) << error();
  EXPECT_EQ(number, 1u);
  record_frame();
  EXPECT_EQ(finished().frames.size(), 2u);
}

TEST_F(RecorderC, ErrorsAreTheThreadsOwn) {
  expect(subpixel_recorder_finish(nullptr), SUBPIXEL_BAD_ARGUMENT, "recorder");
  std::string other = "none";
  std::thread([&] { other = subpixel_recorder_error(); }).join();
  EXPECT_EQ(other, "");
}

// Two recorders in two threads, and one that goes from thread to thread.
TEST_F(RecorderC, RecordersDontShareAnything) {
  create();
  std::thread([&] { add_triangle(); }).join();
  std::thread second([&] {
    subpixel_recorder* other = nullptr;
    EXPECT_EQ(subpixel_recorder_create((folder_ / "other.spcap").c_str(), &metadata_, nullptr, &other), SUBPIXEL_OK);
    for (int i = 0; i < 50; ++i) {
      EXPECT_EQ(subpixel_recorder_begin_frame(other, &frame_), SUBPIXEL_OK);
      EXPECT_EQ(subpixel_recorder_end_frame(other), SUBPIXEL_OK);
    }
    EXPECT_EQ(subpixel_recorder_finish(other), SUBPIXEL_OK);
    subpixel_recorder_destroy(other);
  });
  for (int i = 0; i < 50; ++i) record_frame();
  second.join();
  EXPECT_EQ(finished().frames.size(), 50u);
  EXPECT_EQ(read_capture(folder_ / "other.spcap").frames.size(), 50u);
}

}  // namespace
}  // namespace subpixel::capture
