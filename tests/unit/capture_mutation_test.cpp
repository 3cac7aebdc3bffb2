// A short form of the fuzzer (capture_format/reading/fuzz): captures changed as captures, their checksums right. Each
// is refused with one clear error, or is a capture that can be used, written and read again.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "capture_format/reading/summary.hpp"
#include "capture_format/reading/validator.hpp"
#include "capture_format/streams.hpp"
#include "capture_format/writer.hpp"
#include "tests/unit/capture_fixture.hpp"

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most,
                                               unsigned int seed);

// libFuzzer's own, in place of which: some bytes become others, or go, or come.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most) {
  static std::minstd_rand random(7);
  if (size == 0) return 0;
  if (random() % 4 == 0 && size < most) ++size, data[size - 1] = static_cast<std::uint8_t>(random());
  if (random() % 4 == 0) --size;
  if (size > 0) data[random() % size] = static_cast<std::uint8_t>(random());
  return size;
}

namespace subpixel::capture {
namespace {

void use(const Capture& capture) {
  for (const Frame& frame : capture.frames) {
    for (const Draw& draw : frame.draws) {
      decode_stream(capture, draw.position, draw.vertex_count, 3);
      decode_stream(capture, draw.colour, draw.vertex_count, 4);
      for (const std::uint32_t index : decode_indices(capture, draw)) ASSERT_LT(index, draw.vertex_count);
      world_transforms(capture, draw);
    }
  }
  validate_capture(capture);
  summarize(capture, "", 0);
}

Capture with_strips() {
  Capture capture = small_capture();
  Draw strip = capture.frames[0].draws[0];
  strip.topology = Topology::triangle_strip;
  strip.restart = true;
  capture.frames[0].draws.push_back(strip);
  return capture;
}

TEST(CaptureMutation, WhateverIsReadCanBeUsedAndWritten) {
  constexpr std::size_t kMost = 1 << 14;
  std::vector<std::vector<std::byte>> corpus{encode_capture(small_capture(), {.zstd_level = 0}),
                                             encode_capture(small_capture()),
                                             encode_capture(with_strips(), {.zstd_level = 0})};
  std::minstd_rand random(1);
  std::size_t read = 0, refused = 0;
  for (unsigned int i = 0; i < 20000; ++i) {
    std::vector<std::byte> bytes = corpus[random() % corpus.size()];
    const std::size_t size = bytes.size();
    bytes.resize(kMost);
    bytes.resize(LLVMFuzzerCustomMutator(reinterpret_cast<std::uint8_t*>(bytes.data()), size, kMost,
                                         static_cast<unsigned int>(random())));
    try {
      const Capture capture = decode_capture(bytes, {.decoded_bytes = 1 << 20});
      use(capture);
      const std::vector<std::byte> written = encode_capture(capture, {.zstd_level = 0});
      ASSERT_EQ(encode_capture(decode_capture(written), {.zstd_level = 0}), written) << i;
      ++read;
      if (corpus.size() < 200) corpus.push_back(bytes);
    } catch (const InputError& error) {
      ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      ++refused;
      try {
        use(recover_capture(bytes, {.decoded_bytes = 1 << 20}).capture);
      } catch (const InputError&) {
      }
    }
  }
  // Both halves are tried.
  EXPECT_GT(read, 1000u);
  EXPECT_GT(refused, 1000u);
}

}  // namespace
}  // namespace subpixel::capture
