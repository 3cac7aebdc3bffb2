// libFuzzer target of the reader: whatever it takes must hold what it promises to everyone who uses a capture.
// The fuzz build skips checksums (chunk_reader.cpp), which a fuzzer could not guess.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "base/error.hpp"
#include "capture_format/reading/reader.hpp"
#include "capture_format/reading/summary.hpp"
#include "capture_format/reading/validator.hpp"
#include "capture_format/streams.hpp"
#include "capture_format/writer.hpp"

namespace {

// Reads every vertex, index and instance, so that the sanitizers see any range that was let through wrongly.
void use(const subpixel::capture::Capture& capture) {
  using namespace subpixel::capture;
  for (const Frame& frame : capture.frames) {
    for (const Draw& draw : frame.draws) {
      for (const VertexStream* stream :
           {&draw.position, &draw.normal, &draw.uv, &draw.tangent, &draw.uv2, &draw.colour}) {
        decode_stream(capture, *stream, draw.vertex_count, 4);
      }
      for (const std::uint32_t index : decode_indices(capture, draw)) {
        if (index >= draw.vertex_count) std::abort();
      }
      world_transforms(capture, draw);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace subpixel::capture;
  const std::span<const std::byte> bytes(reinterpret_cast<const std::byte*>(data), size);
  try {
    const Capture capture = decode_capture(bytes, {.file_bytes = 1u << 20, .decoded_bytes = 1u << 20});
    use(capture);
    validate_capture(capture);
    static_cast<void>(summarize(capture, "", size).dump());
    // What was read can be written, and comes back the same.
    const std::vector<std::byte> written = encode_capture(capture, {.zstd_level = 0});
    if (encode_capture(decode_capture(written), {.zstd_level = 0}) != written) std::abort();
  } catch (const subpixel::InputError&) {
    // What of it is whole is a capture like others.
    try {
      const Capture capture = recover_capture(bytes, {.file_bytes = 1u << 20, .decoded_bytes = 1u << 20}).capture;
      use(capture);
      decode_capture(encode_capture(capture, {.zstd_level = 0}));
    } catch (const subpixel::InputError&) {
    }
  }
  return 0;
}
