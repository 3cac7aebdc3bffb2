// Recorders of which calls run out of memory: what was said to be added is in the file, and nothing else is.
#include "capture_format/reading/reader.hpp"
#include "capture_format/stream_recorder.hpp"
#include "capture_format/writer.hpp"
#include "tests/unit/capture_stream_fixture.hpp"
#include "tests/unit/memory_faults.hpp"

namespace subpixel::capture {
namespace {

using CaptureStreamMemory = CaptureStreamRecorder;

// A recorder of which each call runs out of memory first, at its allocation of one number, and is made again then.
template <typename Recorder>
class Repeated {
 public:
  Repeated(Recorder& recorder, std::int64_t allocations) : recorder_(recorder), allocations_(allocations) {}

  std::size_t faults() const { return faults_; }

  std::uint32_t add_buffer(const std::string& name, std::span<const std::byte> bytes) {
    return repeated([&] { return recorder_.add_buffer(name, bytes); });
  }
  std::uint32_t add_texture(const Texture& texture) {
    return repeated([&] { return recorder_.add_texture(texture); });
  }
  std::uint32_t add_material(const Material& material) {
    return repeated([&] { return recorder_.add_material(material); });
  }
  void begin_frame(const Frame& frame) {
    frame_ = frame;
    draws_.clear();
    repeated([&] { recorder_.begin_frame(frame); });
  }
  void draw(const Draw& draw) {
    draws_.push_back(draw);
    repeated([&] { recorder_.draw(draw); });
  }
  // Memory that lacks here takes the frame with it.
  void end_frame() {
    if (!failed([&] { recorder_.end_frame(); })) return;
    recorder_.begin_frame(frame_);
    for (const Draw& draw : draws_) recorder_.draw(draw);
    recorder_.end_frame();
  }

 private:
  template <typename Call>
  bool failed(Call call) {
    try {
      const tests::MemoryFault fault(allocations_);
      call();
      return false;
    } catch (const std::bad_alloc&) {
      ++faults_;
      return true;
    }
  }
  template <typename Call>
  auto repeated(Call call) {
    try {
      const tests::MemoryFault fault(allocations_);
      return call();
    } catch (const std::bad_alloc&) {
      ++faults_;
    }
    return call();
  }

  Recorder& recorder_;
  std::int64_t allocations_;
  std::size_t faults_ = 0;
  Frame frame_;
  std::vector<Draw> draws_;
};

// At every allocation of every call: what was said to be added is in the file under its number, and nothing else is.
TEST_F(CaptureStreamMemory, NoMemoryForACallLeavesAllAsItWas) {
  const std::vector<std::byte> expected = encode_capture(in_memory());
  std::size_t faults = 1;
  std::int64_t allocations = 0;
  for (; faults > 0; ++allocations) {
    SCOPED_TRACE(allocations);
    ASSERT_LT(allocations, 1000);
    StreamRecorder recorder(Metadata{"Streamed", "a test", "a recorder", "CC0-1.0"}, path_);
    Recorder memory(Metadata{"Streamed", "a test", "a recorder", "CC0-1.0"});
    Repeated repeated(recorder, allocations);
    Repeated in_memory(memory, allocations);
    for (std::uint32_t f = 0; f < kFrames; ++f) {
      record_frame(repeated, f);
      record_frame(in_memory, f);
    }
    recorder.finish();
    ASSERT_EQ(encode_capture(read_capture(path_)), expected);
    ASSERT_EQ(encode_capture(memory.capture()), expected);
    faults = repeated.faults() + in_memory.faults();
  }
  EXPECT_GT(allocations, 8);
}

// The same where the call is not made again: no bytes are left that nothing refers to, which a reader would refuse.
TEST_F(CaptureStreamMemory, WhatHadNoMemoryLeavesNothingBehind) {
  const std::vector<std::byte> bytes(50, std::byte{9});
  const Texture texture{"lost", TextureEncoding::rgba8, true, 1, 2, std::vector<std::byte>(8, std::byte{7}), {}};
  bool is_lost = true;
  std::int64_t allocations = 0;
  for (; is_lost; ++allocations) {
    SCOPED_TRACE(allocations);
    ASSERT_LT(allocations, 1000);
    is_lost = false;
    StreamRecorder recorder(Metadata{}, path_);
    const auto lose = [&](auto call) {
      try {
        const tests::MemoryFault fault(allocations);
        call();
      } catch (const std::bad_alloc&) {
        is_lost = true;
      }
    };
    lose([&] { recorder.add_buffer("lost", bytes); });
    lose([&] { recorder.add_texture(texture); });
    record_frame(recorder, 0);
    recorder.finish();
    ASSERT_EQ(read_capture(path_).frames.size(), 1u);
  }
  EXPECT_GT(allocations, 8);
}

}  // namespace
}  // namespace subpixel::capture
