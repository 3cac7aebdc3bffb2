// .spcap written and read back; files that are foreign, cut, lengthened or damaged.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "base/hash.hpp"
#include "capture_format/writer.hpp"
#include "tests/unit/capture_fixture.hpp"

namespace subpixel::capture {
namespace {

class CaptureFile : public testing::Test {
 protected:
  CaptureFile() : folder_(std::filesystem::path(testing::TempDir()) / ("capture_file_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~CaptureFile() override { std::filesystem::remove_all(folder_); }

  std::size_t files_in_folder() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder_), {}));
  }

  std::filesystem::path folder_;
};

TEST_F(CaptureFile, ComesBackAsItWas) {
  const Capture capture = small_capture();
  const Capture read = decode_capture(encode_capture(capture));
  EXPECT_EQ(read.metadata.title, "Small");
  EXPECT_EQ(read.metadata.licence, capture.metadata.licence);
  EXPECT_EQ(read.metadata.metres_per_unit, 0.01f);
  ASSERT_EQ(read.buffers.size(), 5u);
  EXPECT_EQ(read.buffers[3].name, "vertices again");
  EXPECT_EQ(read.buffers[3].bytes, capture.buffers[0].bytes);
  EXPECT_TRUE(read.buffers[4].bytes.empty());
  EXPECT_EQ(read.textures[0].width, 2u);
  EXPECT_TRUE(read.textures[0].srgb);
  EXPECT_EQ(read.textures[1].encoding, TextureEncoding::image_file);
  EXPECT_EQ(read.materials[1].emissive, capture.materials[1].emissive);
  EXPECT_EQ(read.materials[1].alpha_mode, AlphaMode::test);
  ASSERT_EQ(read.frames.size(), 2u);
  EXPECT_EQ(read.frames[0].point_lights[1].range, 7.0f);
  EXPECT_EQ(read.frames[0].draws[0].uv.buffer, 3u);
  EXPECT_EQ(read.frames[0].draws[1].transform, capture.frames[0].draws[1].transform);
  EXPECT_FALSE(read.frames[1].sun.has_value());
  EXPECT_TRUE(read.frames[1].clip_y_up);
  // What the members above leave out: encoding what was read gives the same bytes.
  EXPECT_EQ(encode_capture(read), encode_capture(capture));
}

TEST_F(CaptureFile, UncompressedIsTheSameCapture) {
  const Capture capture = small_capture();
  const std::vector<std::byte> plain = encode_capture(capture, {.zstd_level = 0});
  EXPECT_EQ(encode_capture(decode_capture(plain)), encode_capture(capture));
}

TEST_F(CaptureFile, ACaptureOfNothingIsOne) {
  const Capture read = decode_capture(encode_capture(Capture{}));
  EXPECT_TRUE(read.frames.empty());
}

TEST_F(CaptureFile, EqualBuffersAreStoredOnce) {
  Capture capture = small_capture();
  capture.buffers[0].bytes.resize(100000, std::byte{1});
  for (std::size_t i = 0; i < capture.buffers[0].bytes.size(); ++i) {
    capture.buffers[0].bytes[i] = static_cast<std::byte>((i * i * 2654435761u) >> 13);
  }
  capture.frames.clear();
  const std::size_t once = encode_capture(capture, {.zstd_level = 0}).size();
  capture.buffers[3].bytes = capture.buffers[0].bytes;
  EXPECT_LT(encode_capture(capture, {.zstd_level = 0}).size(), once + 1000);
}

TEST_F(CaptureFile, EveryTruncationIsRefused) {
  const std::vector<std::byte> bytes = encode_capture(small_capture());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    // A copy of just this size, so that the address sanitizer sees any read behind it.
    const std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_NE(refusal(cut), "") << size << " of " << bytes.size() << " bytes";
  }
}

TEST_F(CaptureFile, EveryFlippedBitIsRefused) {
  std::vector<std::byte> bytes = encode_capture(small_capture());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      bytes[i] ^= static_cast<std::byte>(1 << bit);
      EXPECT_NE(refusal(bytes), "") << "byte " << i << ", bit " << bit;
      bytes[i] ^= static_cast<std::byte>(1 << bit);
    }
  }
  EXPECT_EQ(refusal(bytes), "");
}

TEST_F(CaptureFile, ExtraBytesAreRefused) {
  std::vector<std::byte> bytes = encode_capture(small_capture());
  for (const std::size_t extra : {1u, 7u, 8u, 32u, 40u, 1000u}) {
    std::vector<std::byte> longer = bytes;
    longer.resize(bytes.size() + extra);
    EXPECT_NE(refusal(longer), "") << extra;
    longer = bytes;
    longer.insert(longer.end(), bytes.end() - static_cast<std::ptrdiff_t>(std::min(extra, bytes.size())), bytes.end());
    EXPECT_NE(refusal(longer), "") << extra;
  }
}

TEST_F(CaptureFile, ForeignFilesAreNamedAsSuch) {
  const std::string text = "v 0 0 0\nv 1 0 0\n";
  EXPECT_NE(refusal(std::as_bytes(std::span(text))).find("no .spcap capture"), std::string::npos);
  EXPECT_NE(refusal({}).find("no .spcap capture"), std::string::npos);
  std::vector<std::byte> converted = encode_capture(small_capture());
  converted.insert(converted.begin() + 6, std::byte{'\r'});  // a transfer that turned line ends
  EXPECT_NE(refusal(converted).find("no .spcap capture"), std::string::npos);
}

TEST_F(CaptureFile, AnotherVersionIsNamed) {
  for (const unsigned version : {0u, 4u, 255u}) {
    std::vector<std::byte> bytes = encode_capture(small_capture());
    bytes[8] = static_cast<std::byte>(version);
    EXPECT_NE(refusal(bytes).find("version " + std::to_string(version) +
                                  ", this program reads 1 to 3: byte 8, chunk header, field version"),
              std::string::npos)
        << refusal(bytes);
  }
}

TEST_F(CaptureFile, LimitsOfTheCallerHold) {
  const std::vector<std::byte> bytes = encode_capture(small_capture());
  EXPECT_EQ(refusal(bytes, {.decoded_bytes = 100000}), "");
  EXPECT_NE(refusal(bytes, {.decoded_bytes = 500}).find("more than 500 bytes in all"), std::string::npos);
}

TEST_F(CaptureFile, SharingCannotMultiplyMemory) {
  Capture capture;
  for (int i = 0; i < 100; ++i) capture.buffers.push_back({"b", std::vector<std::byte>(1000, std::byte{5})});
  const std::vector<std::byte> bytes = encode_capture(capture);
  EXPECT_EQ(refusal(bytes, {.decoded_bytes = 100000}), "");
  EXPECT_NE(refusal(bytes, {.decoded_bytes = 50000}).find("too many bytes in all buffers"), std::string::npos);
}

TEST_F(CaptureFile, IsWrittenWholeOrNotAtAll) {
  const std::filesystem::path path = folder_ / "small.spcap";
  write_capture(small_capture(), path);
  EXPECT_EQ(files_in_folder(), 1u);
  EXPECT_EQ(encode_capture(read_capture(path)), encode_capture(small_capture()));
  const std::vector<std::byte> bytes = encode_capture(small_capture());
  EXPECT_EQ(content_hash_hex(path), content_hash_hex(bytes));
  EXPECT_EQ(content_hash_hex(path).size(), 32u);
  ContentHasher pieces;
  pieces.add(std::span(bytes).first(1));
  pieces.add(std::span(bytes).subspan(1));
  EXPECT_EQ(pieces.hash().hex(), content_hash_hex(bytes));

  // A limit on the file's size stands for a full disk.
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit old_limit{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old_limit), 0);
  const rlimit limit{1000, old_limit.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  Capture other = small_capture();
  other.metadata.title = "Other";
  std::string message;
  try {
    write_capture(other, path);
  } catch (const InputError& error) {
    message = error.what();
  }
  ::setrlimit(RLIMIT_FSIZE, &old_limit);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_NE(message.find("can't write the file: File too large: " + path.string()), std::string::npos) << message;
  EXPECT_EQ(files_in_folder(), 1u);
  EXPECT_EQ(read_capture(path).metadata.title, "Small");
}

TEST_F(CaptureFile, PathsThatCannotBeAreErrors) {
  EXPECT_THROW(write_capture(small_capture(), folder_ / "no folder" / "x.spcap"), InputError);
  EXPECT_THROW(read_capture(folder_ / "nothing"), InputError);
  EXPECT_THROW(read_capture(folder_), InputError);
  EXPECT_THROW(content_hash_hex(folder_ / "nothing"), InputError);
  std::ofstream(folder_ / "foreign") << "foreign";
  try {
    read_capture(folder_ / "foreign");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_TRUE(std::string(error.what()).starts_with((folder_ / "foreign").string()));
  }
}

}  // namespace
}  // namespace subpixel::capture
