// Files that other programs write: CRC-32 in the place of XXH3-64, zlib in the place of zstd.
#include <gtest/gtest.h>

#include <functional>

#include "tests/unit/foreign_file.hpp"

namespace subpixel::capture {
namespace {

#define EXPECT_REFUSED_AS(file, text)                                                               \
  {                                                                                                 \
    const std::string said = refusal((file).bytes());                                               \
    EXPECT_NE(said.find(text), std::string::npos) << "refused with: " << said << "\nfor " << #file; \
  }

TEST(CaptureCodec, Crc32IsTheOneOfZlib) {
  const Bytes digits = bytes_of(std::vector<char>{'1', '2', '3', '4', '5', '6', '7', '8', '9'});
  const std::span<const std::byte> all(digits);
  for (std::size_t cut = 0; cut <= digits.size(); ++cut) {
    EXPECT_EQ(checksum_of(all.first(cut), all.subspan(cut), Checksum::crc32), 0xcbf43926u) << cut;
  }
  EXPECT_EQ(checksum_of({}, {}, Checksum::crc32), 0u);
}

TEST(CaptureCodec, EveryChoiceIsTheSameCaptureAndIsWrittenAsEver) {
  const Bytes own = encode_capture(version_2_capture());
  for (const std::uint32_t flags : {0u, 1u}) {
    for (const Codec codec : {Codec::raw, Codec::zlib}) {
      const Bytes bytes = foreign(version_2_capture(), codec, flags).bytes();
      ASSERT_EQ(refusal(bytes), "") << flags << static_cast<std::uint32_t>(codec);
      EXPECT_EQ(encode_capture(decode_capture(bytes)), own);
    }
  }
}

TEST(CaptureCodec, CodecsMayMixInAFile) {
  ForeignFile file = foreign(version_2_capture(), Codec::raw);
  Part& frame = file.part(ChunkType::frame);
  frame.stored = deflated(frame.stored, 9);
  frame.header.codec = Codec::zlib;
  EXPECT_EQ(encode_capture(decode_capture(file.bytes())), encode_capture(version_2_capture()));
}

TEST(CaptureCodec, EveryTruncationIsRefused) {
  for (const Codec codec : {Codec::raw, Codec::zlib}) {
    const Bytes bytes = foreign(version_2_capture(), codec).bytes();
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const Bytes cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
      ASSERT_NE(refusal(cut), "") << size << " of " << bytes.size() << " bytes";
    }
  }
}

TEST(CaptureCodec, EveryFlippedBitIsSeen) {
  for (const Codec codec : {Codec::raw, Codec::zlib}) {
    Bytes bytes = foreign(version_2_capture(), codec).bytes();
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      bytes[bit / 8] ^= std::byte(1u << bit % 8);
      ASSERT_NE(refusal(bytes), "") << "bit " << bit % 8 << " of byte " << bit / 8;
      bytes[bit / 8] ^= std::byte(1u << bit % 8);
    }
    EXPECT_EQ(refusal(bytes), "");
  }
}

TEST(CaptureCodec, Version1HasNeither) {
  ForeignFile crc = foreign(small_capture(), Codec::raw);
  ASSERT_EQ(crc.version, 1u);
  EXPECT_REFUSED_AS(crc, "not 0: byte 12, chunk header, field flags");
  EXPECT_REFUSED_AS(foreign(small_capture(), Codec::zlib, 0), "version 1 knows no zlib");
}

TEST(CaptureCodec, UnknownChoices) {
  for (const std::uint32_t flags : {2u, 3u, 0x80000000u}) {
    ForeignFile file = foreign(version_2_capture(), Codec::raw);
    file.flags = flags;
    EXPECT_REFUSED_AS(file, "is no checksum: byte 12, chunk header, field flags");
  }
  ForeignFile codec = foreign(version_2_capture(), Codec::raw);
  codec.part(ChunkType::frame).header.codec = Codec{3};
  EXPECT_REFUSED_AS(codec, "unknown codec");
}

TEST(CaptureCodec, TheHighHalfOfACrcIs0) {
  Bytes bytes = foreign(version_2_capture(), Codec::raw).bytes();
  bytes[kHeaderBytes + 36] = std::byte{1};
  EXPECT_NE(refusal(bytes).find("field checksum"), std::string::npos);
}

TEST(CaptureCodec, TheIndexIsStoredAsItIs) {
  Bytes bytes = foreign(version_2_capture(), Codec::raw).bytes();
  const auto index = load<std::uint64_t>(bytes, bytes.size() - kFooterBytes);
  bytes[index + 8] = std::byte{2};
  EXPECT_NE(refusal(bytes).find("the index is never compressed"), std::string::npos);
}

TEST(CaptureCodec, SizesThatLie) {
  const auto lying = [](std::uint64_t decoded_bytes) {
    ForeignFile file = foreign(version_2_capture(), Codec::zlib);
    file.part(ChunkType::frame).header.decoded_bytes = decoded_bytes;
    return file;
  };
  const std::uint64_t right = foreign(version_2_capture(), Codec::raw).part(ChunkType::frame).stored.size();
  EXPECT_EQ(refusal(lying(right).bytes()), "");
  EXPECT_REFUSED_AS(lying(right - 1), "the payload decodes to more");
  EXPECT_REFUSED_AS(lying(0), "the payload decodes to more");
  EXPECT_REFUSED_AS(lying(right + 1), "the payload decodes to " + std::to_string(right) + " bytes");
  EXPECT_REFUSED_AS(lying(std::uint64_t{1} << 32), "more than zlib can make of");
  EXPECT_REFUSED_AS(lying(~std::uint64_t{0}), "more than zlib can make of");
}

TEST(CaptureCodec, TheRatioAllowsWhatDeflateReaches) {
  Capture capture = version_2_capture();
  capture.buffers.push_back({"zeros", Bytes(std::size_t{1} << 20)});
  ForeignFile file = foreign(capture, Codec::zlib);
  EXPECT_EQ(encode_capture(decode_capture(file.bytes())), encode_capture(capture));
}

TEST(CaptureCodec, StreamsThatLie) {
  const auto changed = [](const std::function<void(Bytes&)>& change) {
    ForeignFile file = foreign(version_2_capture(), Codec::zlib);
    change(file.part(ChunkType::frame).stored);
    return file;
  };
  EXPECT_REFUSED_AS(changed([](Bytes& s) { s.pop_back(); }), "zlib: the stream does not end");
  EXPECT_REFUSED_AS(changed([](Bytes& s) { s.resize(s.size() / 2); }), "zlib: the stream does not end");
  EXPECT_REFUSED_AS(changed([](Bytes& s) { s.push_back(std::byte{0}); }), "1 bytes follow the zlib stream");
  EXPECT_REFUSED_AS(changed([](Bytes& s) { s.insert(s.end(), s.begin(), s.end()); }), "bytes follow the zlib stream");
  EXPECT_REFUSED_AS(changed([](Bytes& s) { s[0] = std::byte{0}; }), "zlib: ");
  EXPECT_REFUSED_AS(changed([](Bytes& s) { s.back() ^= std::byte{1}; }), "zlib: incorrect data check");
  // FDICT, and FCHECK that fits it.
  EXPECT_REFUSED_AS(changed([](Bytes& s) {
                      s[0] = std::byte{0x78};
                      s[1] = std::byte{0xbb};
                    }),
                    "zlib: a dictionary is asked for");
  EXPECT_REFUSED_AS(changed([](Bytes& s) { s.resize(2); }), "zlib: the stream does not end");
}

TEST(CaptureCodec, AnEmptyPayloadOfNoStoredBytesIsNoStream) {
  ForeignFile file = foreign(version_2_capture(), Codec::zlib);
  for (Part& part : file.chunks) {
    if (part.header.decoded_bytes == 0) part.stored.clear();
  }
  EXPECT_REFUSED_AS(file, "zlib: the stream does not end");
}

}  // namespace
}  // namespace subpixel::capture
