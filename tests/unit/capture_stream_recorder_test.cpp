// Recordings that go to the file as they come: what is read of them whole, broken off at any byte, and in part.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "capture_format/reading/capture_file.hpp"
#include "capture_format/reading/summary.hpp"
#include "capture_format/reading/validator.hpp"
#include "capture_format/recorder.hpp"
#include "capture_format/stream_recorder.hpp"
#include "capture_format/streams.hpp"
#include "capture_format/writer.hpp"
#include "tests/unit/capture_forgery.hpp"
#include "tests/unit/capture_stream_fixture.hpp"

namespace subpixel::capture {
namespace {

std::string draws_of(const Capture& capture, std::size_t frame) {
  std::string text;
  for (const Draw& draw : capture.frames[frame].draws) {
    text += draw.name + " " + capture.materials[draw.material].name;
    const std::uint32_t texture = capture.materials[draw.material].base_colour_texture;
    text.append(" ").append(std::to_string(static_cast<int>(capture.textures[texture].bytes[0])));
    const std::vector<float> positions = decode_stream(capture, draw.position, draw.vertex_count, 3);
    for (const std::uint32_t i : decode_indices(capture, draw))
      text.append(" ").append(std::to_string(positions[3 * i + 1]));
    text += "\n";
  }
  return text;
}

TEST_F(CaptureStreamRecorder, ReadsAsWhatTheOtherRecorderKeeps) {
  StreamRecorder recorder(Metadata{"Streamed", "a test", "a recorder", "CC0-1.0"}, path_);
  for (std::uint32_t f = 0; f < kFrames; ++f) record_frame(recorder, f);
  EXPECT_FALSE(std::filesystem::exists(path_));
  recorder.finish();
  EXPECT_FALSE(std::filesystem::exists(recorder.part_path()));
  const Capture read = read_capture(path_);
  // The canonical file of both is the same: equal resources, numbers and draws.
  EXPECT_EQ(encode_capture(read), encode_capture(in_memory()));
  EXPECT_TRUE(validate_capture(read).empty() || validate_capture(read)[0].severity == Problem::Severity::note);
}

TEST_F(CaptureStreamRecorder, OneFrameLoadsWithWhatItUsesAlone) {
  StreamRecorder recorder(Metadata{}, path_);
  for (std::uint32_t f = 0; f < kFrames; ++f) record_frame(recorder, f);
  recorder.finish();
  const CaptureFile file(path_);
  const Capture all = read_capture(path_);
  ASSERT_EQ(file.frame_count(), kFrames);
  for (std::size_t f = 0; f < kFrames; ++f) {
    const Capture one = file.load(f, f);
    ASSERT_EQ(one.frames.size(), kFrames);
    EXPECT_EQ(draws_of(one, f), draws_of(all, f)) << f;
    EXPECT_EQ(one.buffers.size(), 3u);
    EXPECT_EQ(one.materials.size(), f == 0 ? 1u : 2u);
    EXPECT_EQ(one.textures.size(), f < 2 ? 1u : 2u);
    for (std::size_t other = 0; other < kFrames; ++other) EXPECT_TRUE(other == f || one.frames[other].draws.empty());
    EXPECT_EQ(one.frames[0].name, "frame 0");
  }
  const CaptureFile::Outline outline = file.outline();
  EXPECT_EQ(summarize(outline.capture, outline.buffer_bytes, outline.texture_bytes, "h", 1), summarize(all, "h", 1));
}

// A frame that is loaded alone is held to its indices, like one that is read with all others.
TEST_F(CaptureStreamRecorder, AFrameLoadedAloneIsHeldToItsIndices) {
  Forgery forgery(small_capture());
  const std::size_t buffer = forgery.chunk(ChunkType::buffer, 1) + kChunkHeaderBytes;  // the indices
  const auto data = forgery.get<std::uint32_t>(buffer + 4 + forgery.get<std::uint32_t>(buffer));
  forgery.set_payload(ChunkType::data, data, 4, std::uint16_t{4});  // of four vertices
  std::ofstream out(path_, std::ios::binary);
  out.write(reinterpret_cast<const char*>(forgery.bytes().data()),
            static_cast<std::streamsize>(forgery.bytes().size()));
  out.close();
  EXPECT_REFUSED(forgery, "field index_buffer");
  const CaptureFile file(path_);
  try {
    file.load(0, 0);
    ADD_FAILURE() << "was taken";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("FRAM 0, draw 0, field index_buffer"), std::string::npos) << error.what();
  }
}

// An outline looks at no bytes of a texture, but at all that is said of it.
TEST_F(CaptureStreamRecorder, AnOutlineHoldsTexturesToTheRules) {
  Forgery forgery(small_capture());
  forgery.set_payload(ChunkType::texture, 0, 4 + 4, std::uint32_t{7});  // the encoding, after the name "dots"
  std::ofstream out(path_, std::ios::binary);
  out.write(reinterpret_cast<const char*>(forgery.bytes().data()),
            static_cast<std::streamsize>(forgery.bytes().size()));
  out.close();
  try {
    CaptureFile(path_).outline();
    ADD_FAILURE() << "was taken";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("field encoding"), std::string::npos) << error.what();
  }
}

// At whatever byte a recording breaks off, what is read are the frames that were whole by then.
TEST_F(CaptureStreamRecorder, EveryTruncationKeepsTheFramesBeforeIt) {
  StreamRecorder recorder(Metadata{}, path_, {.zstd_level = 0});
  for (std::uint32_t f = 0; f < kFrames; ++f) record_frame(recorder, f);
  recorder.finish();
  const std::vector<std::byte> bytes = bytes_of_file(path_);
  const Capture all = read_capture(path_);
  std::size_t most = 0;
  for (std::size_t size = 0; size < bytes.size(); size += 3) {
    const auto part = std::span(bytes).first(size);
    EXPECT_NE(refusal(part), "") << size;
    try {
      const Recovered recovered = recover_capture(part);
      const std::size_t frames = recovered.capture.frames.size();
      EXPECT_GE(frames, most) << size;
      most = std::max(most, frames);
      for (std::size_t f = 0; f < frames; ++f) ASSERT_EQ(draws_of(recovered.capture, f), draws_of(all, f)) << size;
      // What was recovered is a capture like others.
      EXPECT_EQ(refusal(encode_capture(recovered.capture)), "") << size;
    } catch (const InputError&) {
      EXPECT_EQ(most, 0u) << size;
    }
  }
  EXPECT_EQ(most, kFrames);
  EXPECT_EQ(recover_capture(bytes).stopped, "");
}

TEST_F(CaptureStreamRecorder, AFlippedByteEndsWhatIsRead) {
  StreamRecorder recorder(Metadata{}, path_, {.zstd_level = 0});
  for (std::uint32_t f = 0; f < kFrames; ++f) record_frame(recorder, f);
  recorder.finish();
  std::vector<std::byte> bytes = bytes_of_file(path_);
  bytes[bytes.size() / 2] ^= std::byte{4};
  const Recovered recovered = recover_capture(bytes);
  EXPECT_LT(recovered.capture.frames.size(), kFrames);
  EXPECT_GT(recovered.capture.frames.size(), 0u);
  EXPECT_NE(recovered.stopped.find("damaged"), std::string::npos) << recovered.stopped;
}

// The process that records is killed in the middle of its work.
TEST_F(CaptureStreamRecorder, AKilledProcessLeavesWholeFrames) {
  for (int wait_ms : {5, 20, 60}) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    const pid_t child = ::fork();
    if (child == 0) {
      StreamRecorder recorder(Metadata{}, path_);
      for (std::uint32_t f = 0; f < 60000; ++f) record_frame(recorder, f);
      ::_exit(0);
    }
    ::usleep(static_cast<useconds_t>(1000 * wait_ms));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    const std::filesystem::path part = path_.string() + ".part";
    ASSERT_TRUE(std::filesystem::exists(part) || wait_ms < 20);
    if (!std::filesystem::exists(part) || std::filesystem::file_size(part) < 500) continue;
    const Recovered recovered = recover_capture(part);
    for (std::size_t f = 0; f < recovered.capture.frames.size(); f += 97) {
      EXPECT_EQ(recovered.capture.frames[f].name, "frame " + std::to_string(f));
      EXPECT_EQ(recovered.capture.frames[f].draws.size(), 2u);
    }
  }
}

TEST_F(CaptureStreamRecorder, AnOlderPartIsNeverWrittenOver) {
  const std::filesystem::path part = path_.string() + ".part";
  std::ofstream(part) << "frames of a crash";
  StreamRecorder recorder(Metadata{}, path_);
  record_frame(recorder, 0);
  EXPECT_EQ(recorder.part_path(), path_.string() + ".2.part");
  recorder.finish();
  EXPECT_EQ(std::filesystem::file_size(part), 17u);
  EXPECT_EQ(read_capture(path_).frames.size(), 1u);
}

TEST_F(CaptureStreamRecorder, BuffersThatLeftMemoryAreReadBack) {
  StreamRecorder recorder(Metadata{}, path_, {.kept_bytes = 1});
  const std::vector<float> positions(3000, 1.0f);
  const std::vector<std::uint16_t> order{0, 1, 2, 999, 998, 1000};
  const std::uint32_t vertices = recorder.add_buffer("v", std::as_bytes(std::span(positions)));
  const std::uint32_t indices = recorder.add_buffer("i", std::as_bytes(std::span(order)));
  recorder.add_buffer("other", std::as_bytes(std::span(positions).first(7)));
  Draw draw;
  draw.material = recorder.add_material({});
  draw.position = {vertices, VertexFormat::float32x3, 0, 12};
  draw.vertex_count = 1000;
  draw.index_type = IndexType::uint16;
  draw.index_buffer = indices;
  draw.index_count = 3;
  Frame frame;
  frame.view = frame.projection = Draw{}.transform;
  recorder.begin_frame(frame);
  recorder.draw(draw);
  draw.index_count = 6;  // 1000 is one too many
  EXPECT_THROW(recorder.draw(draw), UsageError);
  recorder.end_frame();
  recorder.finish();
  EXPECT_EQ(read_capture(path_).frames[0].draws.size(), 1u);
}

TEST_F(CaptureStreamRecorder, RefusesAtTheCallAndGoesOn) {
  StreamRecorder recorder(Metadata{}, path_);
  EXPECT_THROW(recorder.end_frame(), UsageError);
  EXPECT_THROW(recorder.draw({}), UsageError);
  Material material;
  material.base_colour_texture = 0;
  EXPECT_THROW(recorder.add_material(material), UsageError);
  record_frame(recorder, 0);
  Frame frame;
  frame.view = frame.projection = Draw{}.transform;
  recorder.begin_frame(frame);
  EXPECT_THROW(recorder.draw({}), UsageError);
  EXPECT_THROW(recorder.begin_frame(frame), UsageError);
  EXPECT_THROW(recorder.finish(), UsageError);
  recorder.end_frame();
  recorder.finish();
  EXPECT_EQ(read_capture(path_).frames.size(), 2u);
}

TEST_F(CaptureStreamRecorder, MoreThanReadersTakeIsRefused) {
  StreamRecorder recorder(Metadata{}, path_, {.most_bytes = 8000});
  const std::vector<std::byte> bytes(3000);
  recorder.add_buffer("a", bytes);
  EXPECT_THROW(recorder.add_buffer("b", std::vector<std::byte>(6000)), UsageError);
  record_frame(recorder, 0);
  recorder.finish();
  EXPECT_EQ(read_capture(path_).frames.size(), 1u);
}

// A draw of `count` triangles by indices, with `instances`.
template <typename Recorder>
Draw many_triangles(Recorder& recorder, std::uint32_t count, std::uint32_t instances) {
  const std::vector<float> corners{0, 0, -2, 1, 0, -2, 0, 1, -2};
  std::vector<std::uint8_t> order;
  for (std::uint32_t i = 0; i < 3 * count; ++i) order.push_back(static_cast<std::uint8_t>(i % 3));
  const std::vector<Matrix4> places(instances, Draw{}.transform);
  Draw draw;
  draw.name = "many";
  draw.position = {recorder.add_buffer("corners", std::as_bytes(std::span(corners))), VertexFormat::float32x3, 0, 12};
  draw.vertex_count = 3;
  draw.index_type = IndexType::uint8;
  draw.index_buffer = recorder.add_buffer("order", std::as_bytes(std::span(order)));
  draw.index_count = 3 * count;
  draw.instance_buffer = recorder.add_buffer("places", std::as_bytes(std::span(places)));
  draw.instance_count = instances;
  Material material;
  material.name = "of the frame that is dropped";
  draw.material = recorder.add_material(material);
  return draw;
}

// One with more triangles than a frame may have: whatever was added for it is there for the next.
template <typename Recorder>
void record_between_refused_frames(Recorder& recorder) {
  Frame frame;
  frame.view = frame.projection = Draw{}.transform;
  const Draw draw = many_triangles(recorder, 1024, 1024);
  for (const char* const name : {"first", "second"}) {
    recorder.begin_frame(frame);
    for (int i = 0; i < 257; ++i) recorder.draw(draw);
    EXPECT_THROW(recorder.end_frame(), UsageError);
    EXPECT_THROW(recorder.end_frame(), UsageError) << "none is begun";
    EXPECT_THROW(recorder.draw(draw), UsageError);
    Frame small = frame;
    small.name = name;
    recorder.begin_frame(small);
    recorder.draw(draw);
    recorder.end_frame();
  }
  recorder.begin_frame(frame);
  for (int i = 0; i < 257; ++i) recorder.draw(draw);
  EXPECT_THROW(recorder.end_frame(), UsageError);
}

TEST_F(CaptureStreamRecorder, AFrameThatIsRefusedIsDroppedWhole) {
  StreamRecorder recorder(Metadata{}, path_);
  record_between_refused_frames(recorder);
  recorder.finish();
  const Capture read = read_capture(path_);
  ASSERT_EQ(read.frames.size(), 2u);
  EXPECT_EQ(read.frames[0].name, "first");
  EXPECT_EQ(read.frames[1].name, "second");
  EXPECT_EQ(read.frames[1].draws.size(), 1u);
  EXPECT_EQ(read.materials[read.frames[1].draws[0].material].name, "of the frame that is dropped");

  Recorder memory(Metadata{});
  record_between_refused_frames(memory);
  EXPECT_EQ(encode_capture(memory.capture()), encode_capture(read));
}

// The frame is too large, or its new materials are: neither is in the file, and the numbers go on.
TEST_F(CaptureStreamRecorder, AFrameThatPassesTheMostBytesIsDroppedWhole) {
  StreamRecorder recorder(Metadata{}, path_, {.most_bytes = 8000});
  record_frame(recorder, 0);
  const Draw draw = many_triangles(recorder, 1, 1);
  Frame frame;
  frame.view = frame.projection = Draw{}.transform;
  recorder.begin_frame(frame);
  for (int i = 0; i < 100; ++i) recorder.draw(draw);
  EXPECT_THROW(recorder.end_frame(), UsageError);
  recorder.begin_frame(frame);
  recorder.draw(draw);
  recorder.end_frame();
  Material large;
  large.name.assign(7000, 'x');
  recorder.add_material(large);
  recorder.begin_frame(frame);
  EXPECT_THROW(recorder.end_frame(), UsageError);
  recorder.finish();
  const Capture read = read_capture(path_);
  ASSERT_EQ(read.frames.size(), 2u);
  EXPECT_EQ(read.materials[read.frames[1].draws[0].material].name, "of the frame that is dropped");
  EXPECT_EQ(read.materials.size(), 2u) << "the one that no frame draws with is left out";
}

TEST_F(CaptureStreamRecorder, AnAbsentFolderIsSaid) {
  EXPECT_THROW(StreamRecorder(Metadata{}, folder_ / "absent" / "x.spcap"), InputError);
}

// Files of this process may not grow beyond 64 KiB: the disk is full there.
TEST_F(CaptureStreamRecorder, AFullDiskIsSaidByTheNextCallAndAllAfter) {
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{.rlim_cur = 64 << 10, .rlim_max = before.rlim_max};
  StreamOptions options;
  options.zstd_level = 0;
  StreamRecorder recorder(Metadata{}, path_, options);
  record_frame(recorder, 0);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  std::string message;
  try {
    const std::vector<std::byte> bytes(100 << 10, std::byte{9});
    recorder.add_buffer("more than there is room for", bytes);
    recorder.finish();
  } catch (const InputError& error) {
    message = error.what();
  }
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(message, "can't write the recording: File too large: " + recorder.part_path().string());
  EXPECT_THROW(record_frame(recorder, 1), InputError);
  EXPECT_THROW(recorder.finish(), InputError);
  EXPECT_FALSE(std::filesystem::exists(path_));
}

}  // namespace
}  // namespace subpixel::capture
