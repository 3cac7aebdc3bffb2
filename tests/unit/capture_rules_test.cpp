// Every rule of SPEC.md, by its name there, broken by files in which nothing else is wrong; what the reader says of
// each and where it says that it is.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <sstream>

#include "capture_format/limits.hpp"
#include "tests/unit/capture_forgery.hpp"
#include "tests/unit/foreign_file.hpp"

namespace subpixel::capture {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr std::uint64_t kFar = std::numeric_limits<std::uint64_t>::max();

struct Broken {
  std::string rule;
  std::string why;                    // what the message begins with
  std::string chunk;                  // as the message names it; empty where it names none
  std::string field;                  // what the message ends with
  std::optional<std::uint64_t> byte;  // of the message, from where the chunk begins
  std::function<Bytes()> file;
  ReadLimits limits{};
};

// Where what messages call `chunk` begins in a file: chunks may have lied about themselves but not about their sizes.
std::uint64_t offset_of(const Bytes& file, const std::string& chunk) {
  if (chunk.empty() || chunk == "header") return 0;
  if (chunk == "footer") return file.size() - kFooterBytes;
  for (std::uint64_t at = kHeaderBytes; at + kChunkHeaderBytes <= file.size();) {
    const std::string type(reinterpret_cast<const char*>(file.data() + at), 4);
    if (type + " " + std::to_string(load<std::uint32_t>(file, at + 4)) == chunk) return at;
    at = aligned(at + kChunkHeaderBytes + load<std::uint64_t>(file, at + 16));
  }
  ADD_FAILURE() << "no chunk " << chunk;
  return 0;
}

// The file of `from`, uncompressed, after a change that makes its own checksums right.
Bytes forged(const std::function<void(Forgery&)>& change, const Capture& from = version_2_capture()) {
  Forgery forgery(from);
  change(forgery);
  return {forgery.bytes().begin(), forgery.bytes().end()};
}

Bytes header_field(ChunkType type, std::uint32_t id, std::size_t offset, auto value) {
  return forged([&](Forgery& forgery) {
    const std::size_t at = forgery.chunk(type, id);
    forgery.set(at + offset, value);
    forgery.sign(at);
  });
}

Bytes rebuilt(const std::function<void(ForeignFile&)>& change, Codec codec = Codec::raw,
              const Capture& from = version_2_capture()) {
  ForeignFile file = foreign(from, codec, 0);
  change(file);
  return file.bytes();
}

void set_payload(Part& part, Bytes payload) {
  part.header.decoded_bytes = payload.size();
  part.stored = std::move(payload);
}

// A file whose records say what `tell` made of the capture, which no writer would write; its bytes stay.
Bytes lying(const std::function<void(Capture&)>& tell, const Capture& honest = version_2_capture()) {
  Capture capture = honest;
  tell(capture);
  ForeignFile file = foreign(honest, Codec::raw, 0);
  const RecordWriter records(file.version);
  set_payload(file.part(ChunkType::metadata), records.metadata(capture.metadata));
  for (std::uint32_t i = 0; i < capture.buffers.size(); ++i) {
    Part& part = file.part(ChunkType::buffer, i);
    set_payload(part, records.buffer(capture.buffers[i], load<std::uint32_t>(part.stored, part.stored.size() - 4)));
  }
  for (std::uint32_t i = 0; i < capture.textures.size(); ++i) {
    Part& part = file.part(ChunkType::texture, i);
    const std::size_t data = 4 + load<std::uint32_t>(part.stored, 0) + 16;
    set_payload(part, records.texture(capture.textures[i], load<std::uint32_t>(part.stored, data)));
  }
  set_payload(file.part(ChunkType::material), records.materials(capture.materials));
  set_payload(file.part(ChunkType::frame), records.frame(capture.frames[0]));
  return file.bytes();
}

// A file in which a field that `turn` changes from 0 to 1 or back is 2.
Bytes flag_of_two(ChunkType type, std::uint32_t id, const std::function<void(Capture&)>& turn) {
  const auto payload = [&](const std::function<void(Capture&)>& change) {
    return parts_of(lying(change)).part(type, id).stored;
  };
  const Bytes before = payload([](Capture&) {}), after = payload(turn);
  const auto at = std::mismatch(before.begin(), before.end(), after.begin()).first - before.begin();
  return forged([&](Forgery& forgery) { forgery.set_payload(type, id, static_cast<std::size_t>(at), 2u); });
}

Draw& indexed(Capture& capture) {
  return capture.frames[0].draws[0];
}
Draw& list(Capture& capture) {
  return capture.frames[0].draws[1];
}
Material& leaf(Capture& capture) {
  return capture.materials[1];
}
PointLight& spot(Capture& capture) {
  return capture.frames[0].point_lights[1];
}

// Of version 3: the second draw is a strip.
Capture version_3_capture() {
  Capture capture = version_2_capture();
  list(capture).topology = Topology::triangle_strip;
  return capture;
}

// A file of version 3 whose chunk `from` stands where chunk `to` stood.
Bytes moved_chunk(std::pair<ChunkType, std::uint32_t> from, std::size_t to) {
  return rebuilt(
      [&](ForeignFile& file) {
        const Part part = file.part(from.first, from.second);
        std::erase_if(file.chunks, [&](const Part& each) {
          return each.header.type == from.first && each.header.id == from.second;
        });
        file.chunks.insert(file.chunks.begin() + static_cast<std::ptrdiff_t>(to), part);
      },
      Codec::raw, version_3_capture());
}

// Where the counts of draws and point lights are in the payload of frame 0.
std::size_t draw_count_at(const Forgery& forgery) {
  return forgery.find_in_frame(std::array<char, 7>{'i', 'n', 'd', 'e', 'x', 'e', 'd'}) - 8;
}
std::size_t light_count_at(const Forgery& forgery) {
  return draw_count_at(forgery) - 32 - 52 - 4;  // without and with a cone
}

// A file with `count` more chunks that are like the last of `type`.
Bytes with_more(ChunkType type, std::uint32_t count) {
  return rebuilt([&](ForeignFile& file) {
    std::size_t last = file.chunks.size() - 1;
    while (file.chunks[last].header.type != type) --last;
    std::vector<Part> more(count, file.chunks[last]);
    for (std::uint32_t i = 0; i < count; ++i) more[i].header.id += i + 1;
    file.chunks.insert(file.chunks.begin() + static_cast<std::ptrdiff_t>(last) + 1, more.begin(), more.end());
  });
}

Bytes compressed() {
  Capture capture = version_2_capture();
  capture.buffers[0].bytes.resize(10000);
  return encode_capture(capture);
}

Bytes resized_data(int change) {
  ForeignFile file = parts_of(compressed());
  Part& data = file.part(ChunkType::data);
  EXPECT_EQ(data.header.codec, Codec::zstd);
  data.stored.resize(data.stored.size() + static_cast<std::size_t>(change));
  return file.bytes();
}

Bytes deflated_frame(const std::function<void(Part&)>& change) {
  return rebuilt([&](ForeignFile& file) { change(file.part(ChunkType::frame)); }, Codec::zlib);
}

std::vector<Broken> broken_files() {
  return {
      {"magic", "this is no .spcap capture", "header", "magic", 0,
       [] { return forged([](Forgery& f) { f.set(0, 'X'); }); }},
      {"magic", "the end is missing", "footer", "end_magic", 24,
       [] { return forged([](Forgery& f) { f.set(f.bytes().size() - 1, 'X'); }); }},
      {"version", "version 0, this program reads 1 to ", "header", "version", 8,
       [] { return forged([](Forgery& f) { f.set_version(0); }); }},
      {"version", "version " + std::to_string(kNewestVersion + 1) + ", this program reads 1 to ", "header", "version",
       8, [] { return forged([](Forgery& f) { f.set_version(kNewestVersion + 1); }); }},
      {"flags", "2 is no checksum", "header", "flags", 12, [] { return rebuilt([](ForeignFile& f) { f.flags = 2; }); }},
      {"flags", "not 0", "header", "flags", 12,
       [] { return rebuilt([](ForeignFile& f) { f.flags = 1; }, Codec::raw, small_capture()); }},
      {"file-size", "the file is truncated to 15 bytes", "", "", 15,
       [] {
         Bytes file = forged([](Forgery&) {});
         file.resize(15);
         return file;
       }},
      {"file-size", "the file is truncated to 87 bytes", "", "", 87,
       [] {
         Bytes file = forged([](Forgery&) {});
         file.resize(87);
         return file;
       }},
      {"file-size", "differs from the file's ", "footer", "file_bytes", 8,
       [] {
         return forged([](Forgery& f) {
           f.set(f.bytes().size() - 24, f.bytes().size() + 8);
           f.sign_footer();
         });
       }},
      {"file-checksum", "header or footer is damaged", "footer", "checksum", 16,
       [] { return forged([](Forgery& f) { f.set(f.bytes().size() - 16, std::uint64_t{1}); }); }},
      {"index-offset", "8 is outside the file's chunks", "footer", "index_offset", 0,
       [] {
         return forged([](Forgery& f) {
           f.set(f.bytes().size() - 32, std::uint64_t{8});
           f.sign_footer();
         });
       }},
      {"index-offset", "20 is outside the file's chunks", "footer", "index_offset", 0,
       [] {
         return forged([](Forgery& f) {
           f.set(f.bytes().size() - 32, std::uint64_t{20});
           f.sign_footer();
         });
       }},
      {"index-offset", std::to_string(kFar - 7) + " is outside the file's chunks", "footer", "index_offset", 0,
       [] {
         return forged([](Forgery& f) {
           f.set(f.bytes().size() - 32, kFar - 7);
           f.sign_footer();
         });
       }},
      {"index", "not the index", "INDX 1", "type", 0, [] { return header_field(ChunkType::index, 0, 4, 1u); }},
      {"index", "the index is never compressed", "INDX 0", "codec", 8,
       [] { return header_field(ChunkType::index, 0, 8, Codec::zstd); }},
      {"index", "the index does not end at the footer", "INDX 0", "stored_bytes", 16,
       [] {
         return forged([](Forgery& f) {
           const std::size_t at = f.chunk(ChunkType::index);
           const auto shorter = f.get<std::uint64_t>(at + 16) - kIndexEntryBytes;
           f.set(at + 16, shorter);
           f.set(at + 24, shorter);
           f.sign(at);
         });
       }},
      {"index", "the index does not list the file's ", "INDX 0", "stored_bytes", 16,
       [] {
         return forged([](Forgery& f) {
           const std::size_t at = f.chunk(ChunkType::index);
           const auto shorter = f.get<std::uint64_t>(at + 16) - 1;
           f.set(at + 16, shorter);
           f.set(at + 24, shorter);
           f.sign(at);
         });
       }},
      {"index", "differs from the chunk that is there", "INDX 0", "entry 1", kChunkHeaderBytes + kIndexEntryBytes,
       [] { return forged([](Forgery& f) { f.set_payload(ChunkType::index, 0, kIndexEntryBytes + 8, 24u); }); }},

      {"chunk-fits", "1099511627776 bytes are said to follow", "BUFR 1", "stored_bytes", 16,
       [] { return header_field(ChunkType::buffer, 1, 16, std::uint64_t{1} << 40); }},
      {"chunk-fits", std::to_string(kFar) + " bytes are said to follow", "BUFR 1", "stored_bytes", 16,
       [] { return header_field(ChunkType::buffer, 1, 16, kFar); }},
      {"chunk-fits", "no room for a chunk header", "", "", std::nullopt,
       [] {
         return forged([](Forgery& f) {
           const std::size_t at = f.chunk(ChunkType::frame, 1);
           const auto shorter = f.get<std::uint64_t>(at + 16) - 8;
           f.set(at + 16, shorter);
           f.set(at + 24, shorter);
           f.sign(at);
         });
       }},
      {"chunk-type", "unknown chunk type", "AAAA 1", "type", 0,
       [] { return header_field(ChunkType::buffer, 1, 0, std::uint32_t{0x41414141}); }},
      {"chunk-type", "the chunk's bytes are damaged", "AAAA 9", "checksum", 32,
       [] {
         Bytes file = rebuilt(
             [](ForeignFile& f) {
               Part unknown = f.part(ChunkType::buffer);
               unknown.header.type = ChunkType{0x41414141};
               unknown.header.id = 9;
               f.chunks.push_back(unknown);
             },
             Codec::raw, version_3_capture());
         file[offset_of(file, "AAAA 9") + kChunkHeaderBytes] ^= std::byte{1};
         return file;
       }},
      {"chunk-order", "stands after a later kind of chunk", "META 1", "type", 0,
       [] { return header_field(ChunkType::buffer, 1, 0, ChunkType::metadata); }},
      {"chunk-order", "stands before META", "DATA 0", "type", 0,
       [] {
         return moved_chunk({ChunkType::metadata, 0}, 1);
       }},
      {"chunk-order", "0 is not below 0", "BUFR 0", "data", 0,
       [] {
         return moved_chunk({ChunkType::buffer, 0}, 1);
       }},
      {"chunk-order", "1 is not below 0", "FRAM 0", "material", 0,
       [] {
         return moved_chunk({ChunkType::frame, 0}, 1);
       }},
      {"chunk-numbers", "out of sequence", "BUFR 7", "id", 4, [] { return header_field(ChunkType::buffer, 1, 4, 7u); }},
      {"chunk-numbers", "out of sequence", "DATA 1", "id", 4, [] { return header_field(ChunkType::data, 0, 4, 1u); }},
      {"chunk-once", "chunk META is missing", "", "", 0,
       [] { return rebuilt([](ForeignFile& f) { f.chunks.erase(f.chunks.begin()); }); }},
      {"chunk-once", "chunk MATL is missing", "", "", 0,
       [] {
         return rebuilt([](ForeignFile& f) {
           std::erase_if(f.chunks, [](const Part& part) {
             return part.header.type == ChunkType::material || part.header.type == ChunkType::frame;
           });
         });
       }},
      {"chunk-once", "more than 1 of this kind", "META 1", "id", 0, [] { return with_more(ChunkType::metadata, 1); }},
      {"chunk-once", "more than 1 of this kind", "MATL 1", "id", 0, [] { return with_more(ChunkType::material, 1); }},
      {"chunk-once", "chunk MATL is missing", "", "", 0,
       [] {
         return rebuilt(
             [](ForeignFile& f) {
               std::erase_if(f.chunks, [](const Part& part) {
                 return part.header.type == ChunkType::material || part.header.type == ChunkType::frame;
               });
             },
             Codec::raw, version_3_capture());
       }},
      {"codec", "unknown codec", "BUFR 1", "codec", 8, [] { return header_field(ChunkType::buffer, 1, 8, 3u); }},
      {"codec", "version 1 knows no zlib", "META 0", "codec", 8,
       [] { return rebuilt([](ForeignFile&) {}, Codec::zlib, small_capture()); }},
      {"reserved", "not 0", "BUFR 1", "reserved", 12, [] { return header_field(ChunkType::buffer, 1, 12, 1u); }},
      {"raw-size", "differs from stored_bytes of an uncompressed chunk", "BUFR 1", "decoded_bytes", 24,
       [] { return header_field(ChunkType::buffer, 1, 24, std::uint64_t{0}); }},
      {"raw-size", "differs from stored_bytes of an uncompressed chunk", "BUFR 1", "decoded_bytes", 24,
       [] { return header_field(ChunkType::buffer, 1, 24, kFar); }},
      {"zlib-ratio", "more than zlib can make of ", "FRAM 0", "decoded_bytes", 24,
       [] { return deflated_frame([](Part& part) { part.header.decoded_bytes = std::uint64_t{1} << 32; }); }},
      {"zstd-size", "differs from the compressed payload's own size", "FRAM 0", "decoded_bytes", 24,
       [] { return header_field(ChunkType::frame, 0, 8, Codec::zstd); }},
      {"zstd-size", "differs from the compressed payload's own size", "DATA 0", "decoded_bytes", 24,
       [] {
         ForeignFile file = parts_of(compressed());
         file.part(ChunkType::data).header.decoded_bytes = 9999;
         return file.bytes();
       }},
      {"decompression", "zstd: ", "DATA 0", "payload", 40, [] { return resized_data(-1); }},
      {"decompression", "zstd: ", "DATA 0", "payload", 40, [] { return resized_data(1); }},
      {"decompression", "zlib: the stream does not end", "FRAM 0", "payload", std::nullopt,
       [] { return deflated_frame([](Part& part) { part.stored.pop_back(); }); }},
      {"decompression", "1 bytes follow the zlib stream", "FRAM 0", "payload", std::nullopt,
       [] { return deflated_frame([](Part& part) { part.stored.push_back(std::byte{0}); }); }},
      {"decompression", "zlib: incorrect data check", "FRAM 0", "payload", std::nullopt,
       [] { return deflated_frame([](Part& part) { part.stored.back() ^= std::byte{1}; }); }},
      {"decompression", "zlib: a dictionary is asked for", "FRAM 0", "payload", 40,
       [] {
         return deflated_frame([](Part& part) {
           part.stored[0] = std::byte{0x78};
           part.stored[1] = std::byte{0xbb};
         });
       }},
      {"decompression", "the payload decodes to more", "FRAM 0", "decoded_bytes", 24,
       [] { return deflated_frame([](Part& part) { --part.header.decoded_bytes; }); }},
      {"decompression", "the payload decodes to ", "FRAM 0", "decoded_bytes", 24,
       [] { return deflated_frame([](Part& part) { ++part.header.decoded_bytes; }); }},
      {"padding", "not 0", "DATA 1", "padding", 40 + 14,
       [] {
         return forged([](Forgery& f) {
           const std::size_t at = f.chunk(ChunkType::data, 1);
           f.set(at + kChunkHeaderBytes + f.get<std::uint64_t>(at + 16), std::uint8_t{1});
         });
       }},
      {"checksum", "the chunk's bytes are damaged", "FRAM 0", "checksum", 32,
       [] {
         return forged([](Forgery& f) { f.set(f.chunk(ChunkType::frame) + kChunkHeaderBytes, std::uint8_t{77}); });
       }},
      {"checksum", "the chunk's bytes are damaged", "META 0", "checksum", 32,
       [] {
         Bytes file = foreign(version_2_capture(), Codec::raw).bytes();
         file[kHeaderBytes + 36] = std::byte{1};
         return file;
       }},
      {"data-used", "no buffer or texture refers to it", "DATA 6", "id", 0,
       [] {
         return forged([](Forgery& f) { f.set_payload(ChunkType::texture, 1, 4 + 4 + 16, 0u); });  // after "file"
       }},

      {"payload-size", "the chunk ends before it", "FRAM 1", "draws", 0,
       [] {
         return rebuilt([](ForeignFile& f) {
           Part& part = f.part(ChunkType::frame, 1);
           set_payload(part, Bytes(part.stored.begin(), part.stored.end() - 1));
         });
       }},
      {"payload-size", "1 bytes follow the last field", "BUFR 0", "end", 0,
       [] {
         return rebuilt([](ForeignFile& f) {
           Bytes longer = f.part(ChunkType::buffer).stored;
           longer.push_back(std::byte{0});
           set_payload(f.part(ChunkType::buffer), longer);
         });
       }},
      {"count-fits", "3 records do not fit the chunk", "MATL 0", "materials", 0,
       [] { return forged([](Forgery& f) { f.set_payload(ChunkType::material, 0, 0, 3u); }); }},
      {"count-fits", "4096 records do not fit the chunk", "META 0", "notices", 0,
       [] { return forged([](Forgery& f) { f.set_payload(ChunkType::metadata, 0, 66, 4096u); }); }},
      {"count-fits", "3 records do not fit the chunk", "FRAM 0", "draws", 0,
       [] { return forged([](Forgery& f) { f.set_payload(ChunkType::frame, 0, draw_count_at(f), 3u); }); }},
      {"count-fits", "60000 records do not fit the chunk", "FRAM 0", "point_lights", 0,
       [] { return forged([](Forgery& f) { f.set_payload(ChunkType::frame, 0, light_count_at(f), 60000u); }); }},
      {"data-number", "4294967280 is not below ", "BUFR 1", "data", 0,
       [] { return forged([](Forgery& f) { f.set_payload(ChunkType::buffer, 1, 4 + 7, 0xfffffff0u); }); }},
      {"data-number", "99 is not below ", "TEXR 1", "data", 0,
       [] { return forged([](Forgery& f) { f.set_payload(ChunkType::texture, 1, 4 + 4 + 16, 99u); }); }},
      {"buffer-number", "6 is not below 6", "FRAM 0", "position.buffer", 0,
       [] { return lying([](Capture& c) { indexed(c).position.buffer = 6; }); }},
      {"buffer-number", "6 is not below 6", "FRAM 0", "normal.buffer", 0,
       [] { return lying([](Capture& c) { indexed(c).normal.buffer = 6; }); }},
      {"buffer-number", "4294967294 is not below 6", "FRAM 0", "uv.buffer", 0,
       [] { return lying([](Capture& c) { indexed(c).uv.buffer = kNone - 1; }); }},
      {"buffer-number", "6 is not below 6", "FRAM 0", "tangent.buffer", 0,
       [] { return lying([](Capture& c) { indexed(c).tangent.buffer = 6; }); }},
      {"buffer-number", "6 is not below 6", "FRAM 0", "uv2.buffer", 0,
       [] { return lying([](Capture& c) { indexed(c).uv2.buffer = 6; }); }},
      {"buffer-number", "6 is not below 6", "FRAM 0", "colour.buffer", 0,
       [] { return lying([](Capture& c) { indexed(c).colour.buffer = 6; }); }},
      {"buffer-number", "4294967295 is not below 6", "FRAM 0", "index_buffer", 0,
       [] { return lying([](Capture& c) { indexed(c).index_buffer = kNone; }); }},
      {"buffer-number", "6 is not below 6", "FRAM 0", "instance_buffer", 0,
       [] { return lying([](Capture& c) { indexed(c).instance_buffer = 6; }); }},
      {"texture-number", "2 is not below 2", "MATL 0", "base_colour_texture", 0,
       [] { return lying([](Capture& c) { leaf(c).base_colour_texture = 2; }); }},
      {"texture-number", "2 is not below 2", "MATL 0", "metallic_roughness_texture", 0,
       [] { return lying([](Capture& c) { leaf(c).metallic_roughness_texture = 2; }); }},
      {"texture-number", "4294967294 is not below 2", "MATL 0", "normal_texture", 0,
       [] { return lying([](Capture& c) { leaf(c).normal_texture = kNone - 1; }); }},
      {"texture-number", "2 is not below 2", "MATL 0", "emissive_texture", 0,
       [] { return lying([](Capture& c) { leaf(c).emissive_texture = 2; }); }},
      {"material-number", "2 is not below 2", "FRAM 0", "material", 0,
       [] { return lying([](Capture& c) { indexed(c).material = 2; }); }},
      {"material-number", "4294967295 is not below 2", "FRAM 0", "material", 0,
       [] { return lying([](Capture& c) { list(c).material = kNone; }); }},
      {"utf8", "not UTF-8", "META 0", "title", 0,
       [] { return lying([](Capture& c) { c.metadata.title = std::string("a\xff"); }); }},
      {"utf8", "not UTF-8", "META 0", "application", 0,
       [] { return lying([](Capture& c) { c.metadata.application = std::string("\xc0\x80"); }); }},
      {"utf8", "not UTF-8", "META 0", "tool", 0,
       [] { return lying([](Capture& c) { c.metadata.tool = std::string("\xed\xa0\x80"); }); }},
      {"utf8", "not UTF-8", "META 0", "licence", 0,
       [] { return lying([](Capture& c) { c.metadata.licence = std::string("\xf4\x90\x80\x80"); }); }},
      {"utf8", "not UTF-8", "META 0", "notices[1]", 0,
       [] { return lying([](Capture& c) { c.metadata.notices[1] = std::string("\x80"); }); }},
      {"utf8", "not UTF-8", "BUFR 1", "name", 0,
       [] { return lying([](Capture& c) { c.buffers[1].name = std::string("\xe2\x82"); }); }},
      {"utf8", "not UTF-8", "TEXR 0", "name", 0,
       [] { return lying([](Capture& c) { c.textures[0].name = std::string("\xfe"); }); }},
      {"utf8", "not UTF-8", "MATL 0", "name", 0,
       [] { return lying([](Capture& c) { leaf(c).name = std::string("\xc3"); }); }},
      {"utf8", "not UTF-8", "FRAM 0", "name", 0,
       [] { return lying([](Capture& c) { c.frames[0].name = std::string("\xc3("); }); }},
      {"utf8", "not UTF-8", "FRAM 0", "name", 0,
       [] { return lying([](Capture& c) { list(c).name = std::string("\xe0\x80\x80"); }); }},
      {"flag", "2 is neither 0 nor 1", "TEXR 0", "srgb", 0,
       [] { return flag_of_two(ChunkType::texture, 0, [](Capture& c) { c.textures[0].srgb = false; }); }},
      {"flag", "2 is neither 0 nor 1", "MATL 0", "two_sided", 0,
       [] { return flag_of_two(ChunkType::material, 0, [](Capture& c) { leaf(c).two_sided = false; }); }},
      {"flag", "2 is neither 0 nor 1", "MATL 0", "unlit", 0,
       [] { return flag_of_two(ChunkType::material, 0, [](Capture& c) { leaf(c).unlit = false; }); }},
      {"flag", "2 is neither 0 nor 1", "FRAM 0", "clip_y_up", 0,
       [] { return flag_of_two(ChunkType::frame, 0, [](Capture& c) { c.frames[0].clip_y_up = true; }); }},
      {"flag", "2 is neither 0 nor 1", "FRAM 0", "has_sun", 0,
       [] { return flag_of_two(ChunkType::frame, 0, [](Capture& c) { c.frames[0].sun.reset(); }); }},
      {"flag", "2 is neither 0 nor 1", "FRAM 0", "sun.shadows", 0,
       [] { return flag_of_two(ChunkType::frame, 0, [](Capture& c) { c.frames[0].sun->shadows = false; }); }},
      {"flag", "2 is neither 0 nor 1", "FRAM 0", "point_lights.has_cone", 0,
       [] { return flag_of_two(ChunkType::frame, 0, [](Capture& c) { spot(c).cone.reset(); }); }},
      {"flag", "2 is neither 0 nor 1", "FRAM 0", "restart", 0,
       [] {
         return forged(
             [](Forgery& f) {
               const std::size_t end = f.get<std::uint64_t>(f.chunk(ChunkType::frame) + 16);
               f.set_payload(ChunkType::frame, 0, end - 4, 2u);
             },
             version_3_capture());
       }},
      {"enumeration", "2 is no texture encoding", "TEXR 0", "encoding", 0,
       [] { return lying([](Capture& c) { c.textures[0].encoding = TextureEncoding{2}; }); }},
      {"enumeration", "3 is no wrap", "TEXR 0", "sampler.wrap_u", 0,
       [] { return lying([](Capture& c) { c.textures[0].sampler.wrap_u = Wrap{3}; }); }},
      {"enumeration", "4294967295 is no wrap", "TEXR 0", "sampler.wrap_v", 0,
       [] { return lying([](Capture& c) { c.textures[0].sampler.wrap_v = Wrap{kNone}; }); }},
      {"enumeration", "2 is no texel filter", "TEXR 0", "sampler.magnify", 0,
       [] { return lying([](Capture& c) { c.textures[0].sampler.magnify = TexelFilter{2}; }); }},
      {"enumeration", "2 is no texel filter", "TEXR 0", "sampler.minify", 0,
       [] { return lying([](Capture& c) { c.textures[0].sampler.minify = TexelFilter{2}; }); }},
      {"enumeration", "5 is no mip filter", "TEXR 1", "sampler.mip", 0,
       [] { return lying([](Capture& c) { c.textures[1].sampler.mip = MipFilter{5}; }, version_3_capture()); }},
      {"enumeration", "3 is no mip filter of version 2", "TEXR 1", "sampler.mip", 0,
       [] { return lying([](Capture& c) { c.textures[1].sampler.mip = MipFilter::linear_of_means; }); }},
      {"enumeration", "3 is no alpha mode", "MATL 0", "alpha_mode", 0,
       [] { return lying([](Capture& c) { leaf(c).alpha_mode = AlphaMode{3}; }); }},
      {"enumeration", "3 is no clip depth", "FRAM 0", "clip_depth", 0,
       [] { return lying([](Capture& c) { c.frames[0].clip_depth = ClipDepth{3}; }); }},
      {"enumeration", "3 is no index type", "FRAM 0", "index_type", 0,
       [] { return lying([](Capture& c) { indexed(c).index_type = IndexType{3}; }); }},
      {"enumeration", "4294967295 is no index type", "FRAM 0", "index_type", 0,
       [] { return lying([](Capture& c) { indexed(c).index_type = IndexType{kNone}; }); }},
      {"enumeration", "4 is no index type", "FRAM 0", "index_type", 0,
       [] { return lying([](Capture& c) { indexed(c).index_type = IndexType{4}; }, version_3_capture()); }},
      {"enumeration", "3 is no topology", "FRAM 0", "topology", 0,
       [] { return lying([](Capture& c) { list(c).topology = Topology{3}; }, version_3_capture()); }},
      {"texture-bytes", "8 bytes instead of 12", "TEXR 0", "bytes", 0,
       [] { return lying([](Capture& c) { c.textures[0].width = 3; }); }},
      {"texture-bytes", "8 bytes instead of 16", "TEXR 0", "bytes", 0,
       [] { return lying([](Capture& c) { c.textures[0].height = 2; }); }},
      {"texture-bytes", "set on a texture that is an image file", "TEXR 1", "width", 0,
       [] { return lying([](Capture& c) { c.textures[1].height = 1; }); }},
      {"texture-bytes", "empty", "TEXR 1", "bytes", 0,
       [] {
         return forged([](Forgery& f) {
           const std::size_t nothing = f.chunk(ChunkType::buffer, 4) + kChunkHeaderBytes + 4 + 7;
           f.set_payload(ChunkType::texture, 1, 4 + 4 + 16, f.get<std::uint32_t>(nothing));
         });
       }},
      {"metres", "not a positive number", "META 0", "metres_per_unit", 0,
       [] { return lying([](Capture& c) { c.metadata.metres_per_unit = 0; }); }},
      {"metres", "not a positive number", "META 0", "metres_per_unit", 0,
       [] { return lying([](Capture& c) { c.metadata.metres_per_unit = -1; }); }},
      {"metres", "not a positive number", "META 0", "metres_per_unit", 0,
       [] { return lying([](Capture& c) { c.metadata.metres_per_unit = kNan; }); }},
      {"metres", "not a positive number", "META 0", "metres_per_unit", 0,
       [] { return lying([](Capture& c) { c.metadata.metres_per_unit = kInfinity; }); }},
      {"finite", "not finite", "FRAM 0", "time_s", 0,
       [] { return lying([](Capture& c) { c.frames[0].time_s = kNan; }); }},
      {"finite", "not finite", "FRAM 0", "view", 0,
       [] { return lying([](Capture& c) { c.frames[0].view[0] = kNan; }); }},
      {"finite", "not finite", "FRAM 0", "view", 0,
       [] { return lying([](Capture& c) { c.frames[0].view[15] = -kInfinity; }); }},
      {"finite", "not finite", "FRAM 0", "projection", 0,
       [] { return lying([](Capture& c) { c.frames[0].projection[7] = kInfinity; }); }},
      {"finite", "not finite", "FRAM 0", "point_lights[1].position", 0,
       [] { return lying([](Capture& c) { spot(c).position[2] = kNan; }); }},
      {"finite", "not finite", "MATL 0", "normal_scale", 0,
       [] { return lying([](Capture& c) { leaf(c).normal_scale = kInfinity; }); }},
      {"finite", "not finite", "MATL 0", "base_colour_uv.matrix", 0,
       [] { return lying([](Capture& c) { leaf(c).base_colour_uv.matrix[0] = kNan; }); }},
      {"finite", "not finite", "MATL 0", "metallic_roughness_uv.matrix", 0,
       [] { return lying([](Capture& c) { leaf(c).metallic_roughness_uv.matrix[1] = kNan; }); }},
      {"finite", "not finite", "MATL 0", "normal_uv.matrix", 0,
       [] { return lying([](Capture& c) { leaf(c).normal_uv.matrix[2] = kInfinity; }); }},
      {"finite", "not finite", "MATL 0", "emissive_uv.matrix", 0,
       [] { return lying([](Capture& c) { leaf(c).emissive_uv.matrix[5] = -kInfinity; }); }},
      {"unit-range", "outside 0 to 1", "MATL 0", "base_colour", 0,
       [] { return lying([](Capture& c) { leaf(c).base_colour[3] = 1.001f; }); }},
      {"unit-range", "outside 0 to 1", "MATL 0", "base_colour", 0,
       [] { return lying([](Capture& c) { leaf(c).base_colour[0] = kNan; }); }},
      {"unit-range", "outside 0 to 1", "MATL 0", "alpha_cutoff", 0,
       [] { return lying([](Capture& c) { leaf(c).alpha_cutoff = -0.1f; }); }},
      {"unit-range", "outside 0 to 1", "MATL 0", "metallic", 0,
       [] { return lying([](Capture& c) { leaf(c).metallic = kInfinity; }); }},
      {"unit-range", "outside 0 to 1", "MATL 0", "roughness", 0,
       [] { return lying([](Capture& c) { leaf(c).roughness = kNan; }); }},
      {"not-negative", "negative", "MATL 0", "emissive", 0,
       [] { return lying([](Capture& c) { leaf(c).emissive[2] = -1; }); }},
      {"not-negative", "not finite", "MATL 0", "emissive", 0,
       [] { return lying([](Capture& c) { leaf(c).emissive[0] = kInfinity; }); }},
      {"not-negative", "negative", "FRAM 0", "exposure", 0,
       [] { return lying([](Capture& c) { c.frames[0].exposure = -1; }); }},
      {"not-negative", "not finite", "FRAM 0", "exposure", 0,
       [] { return lying([](Capture& c) { c.frames[0].exposure = kNan; }); }},
      {"not-negative", "negative", "FRAM 0", "sky", 0,
       [] { return lying([](Capture& c) { c.frames[0].sky[1] = -1; }); }},
      {"not-negative", "not finite", "FRAM 0", "ambient", 0,
       [] { return lying([](Capture& c) { c.frames[0].ambient[0] = kNan; }); }},
      {"not-negative", "negative", "FRAM 0", "sun.irradiance", 0,
       [] { return lying([](Capture& c) { c.frames[0].sun->irradiance[2] = -1; }); }},
      {"not-negative", "negative", "FRAM 0", "point_lights[1].intensity", 0,
       [] { return lying([](Capture& c) { spot(c).intensity[0] = -1; }); }},
      {"light-range", "not a positive number", "FRAM 0", "point_lights[1].range", 0,
       [] { return lying([](Capture& c) { spot(c).range = 0; }); }},
      {"light-range", "not a positive number", "FRAM 0", "point_lights[1].range", 0,
       [] { return lying([](Capture& c) { spot(c).range = kInfinity; }); }},
      {"direction", "of length 0", "FRAM 0", "sun.direction", 0,
       [] { return lying([](Capture& c) {
              c.frames[0].sun->direction = {0, 0, 0};
            }); }},
      {"direction", "not finite", "FRAM 0", "sun.direction", 0,
       [] { return lying([](Capture& c) { c.frames[0].sun->direction[1] = kNan; }); }},
      {"direction", "of length 0", "FRAM 0", "point_lights[1].cone.direction", 0,
       [] { return lying([](Capture& c) {
              spot(c).cone->direction = {0, -0.0f, 0};
            }); }},
      {"direction", "not finite", "FRAM 0", "point_lights[1].cone.direction", 0,
       [] { return lying([](Capture& c) { spot(c).cone->direction[0] = kInfinity; }); }},
      {"cone", "outside -1 to 1", "FRAM 0", "point_lights[1].cone.inner_cosine", 0,
       [] { return lying([](Capture& c) { spot(c).cone->inner_cosine = 1.001f; }); }},
      {"cone", "outside -1 to 1", "FRAM 0", "point_lights[1].cone.outer_cosine", 0,
       [] { return lying([](Capture& c) { spot(c).cone->outer_cosine = kNan; }); }},
      {"cone", "not above outer_cosine", "FRAM 0", "point_lights[1].cone.inner_cosine", 0,
       [] { return lying([](Capture& c) { spot(c).cone->inner_cosine = -0.25f; }); }},
      {"uv-set", "2 is neither 0 nor 1", "MATL 0", "base_colour_uv.set", 0,
       [] { return lying([](Capture& c) { leaf(c).base_colour_uv.set = 2; }); }},
      {"uv-set", "4294967295 is neither 0 nor 1", "MATL 0", "emissive_uv.set", 0,
       [] { return lying([](Capture& c) { leaf(c).emissive_uv.set = kNone; }); }},

      {"position", "absent", "FRAM 0", "position.buffer", 0,
       [] { return lying([](Capture& c) { indexed(c).position.buffer = kNone; }); }},
      {"vertex-format", "10 is no vertex format of version 2", "FRAM 0", "normal.format", 0,
       [] { return lying([](Capture& c) { indexed(c).normal.format = VertexFormat{10}; }); }},
      {"vertex-format", "8 is no vertex format of version 1", "FRAM 0", "uv.format", 0,
       [] { return lying([](Capture& c) { indexed(c).uv.format = VertexFormat::unorm8x4; }, small_capture()); }},
      {"vertex-format", "4294967295 is no vertex format", "FRAM 0", "position.format", 0,
       [] { return lying([](Capture& c) { indexed(c).position.format = VertexFormat{kNone}; }); }},
      {"colour-format", "7 is no format of colours", "FRAM 0", "colour.format", 0,
       [] { return lying([](Capture& c) { indexed(c).colour.format = VertexFormat::unorm16x2; }); }},
      {"colour-format", "5 is no format of colours", "FRAM 0", "colour.format", 0,
       [] { return lying([](Capture& c) { indexed(c).colour.format = VertexFormat::snorm8x4; }); }},
      {"stride", "11 bytes is less than an element", "FRAM 0", "position.stride", 0,
       [] { return lying([](Capture& c) { indexed(c).position.stride = 11; }); }},
      {"stride", "0 bytes is less than an element", "FRAM 0", "position.stride", 0,
       [] { return lying([](Capture& c) { indexed(c).position.stride = 0; }); }},
      {"stride", "3 bytes is less than an element", "FRAM 0", "colour.stride", 0,
       [] { return lying([](Capture& c) { indexed(c).colour.stride = 3; }); }},
      {"stream-range", "4 vertices at byte 9 leave the buffer's 80 bytes", "FRAM 0", "position.offset", 0,
       [] { return lying([](Capture& c) { indexed(c).position.offset = 9; }); }},
      {"stream-range", "4 vertices at byte " + std::to_string(kFar - 70), "FRAM 0", "normal.offset", 0,
       [] { return lying([](Capture& c) { indexed(c).normal.offset = kFar - 70; }); }},
      {"stream-range", "5 vertices at byte 0 leave the buffer's 80 bytes", "FRAM 0", "position.offset", 0,
       [] { return lying([](Capture& c) { list(c).vertex_count = 5; }); }},
      {"stream-range", "4 vertices at byte 0 leave the buffer's 48 bytes", "FRAM 0", "uv2.offset", 0,
       [] { return lying([](Capture& c) { indexed(c).uv2.stride = kNone; }); }},
      {"index-range", "6 indices at byte 4 leave the buffer's 14 bytes", "FRAM 0", "index_offset", 0,
       [] { return lying([](Capture& c) { indexed(c).index_offset = 4; }); }},
      {"index-range", "6 indices at byte " + std::to_string(kFar), "FRAM 0", "index_offset", 0,
       [] { return lying([](Capture& c) { indexed(c).index_offset = kFar; }); }},
      {"index-range", "4294967292 indices at byte 2 leave the buffer's 14 bytes", "FRAM 0", "index_offset", 0,
       [] { return lying([](Capture& c) { indexed(c).index_count = 0xfffffffc; }); }},
      {"index-absent", "set on a draw without indices", "FRAM 0", "index_buffer", 0,
       [] { return lying([](Capture& c) { list(c).index_buffer = 1; }); }},
      {"index-absent", "vertices 2 to 5 are not all among the 4", "FRAM 0", "index_count", 0,
       [] { return lying([](Capture& c) { list(c).base_vertex = 2; }); }},
      {"index-absent", "vertices -1 to 2 are not all among the 4", "FRAM 0", "index_count", 0,
       [] { return lying([](Capture& c) { list(c).base_vertex = -1; }); }},
      {"index-values", "indices 0 to 9 (base_vertex added) are not all among the 4", "FRAM 0", "index_buffer", 0,
       [] { return lying([](Capture& c) { indexed(c).index_offset = 0; }); }},
      {"index-values", "indices 1 to 4 (base_vertex added) are not all among the 4", "FRAM 0", "index_buffer", 0,
       [] { return lying([](Capture& c) { indexed(c).base_vertex = 1; }); }},
      {"index-values", "indices -1 to 2 (base_vertex added) are not all among the 4", "FRAM 0", "index_buffer", 0,
       [] { return lying([](Capture& c) { indexed(c).base_vertex = -1; }); }},
      {"triangles", "5 is no multiple of 3", "FRAM 0", "index_count", 0,
       [] { return lying([](Capture& c) { indexed(c).index_count = 5; }); }},
      {"triangles", "2 is no multiple of 3", "FRAM 0", "index_count", 0,
       [] { return lying([](Capture& c) { list(c).index_count = 2; }); }},
      {"restart", "set on a draw that is no indexed strip or fan", "FRAM 0", "restart", 0,
       [] { return lying([](Capture& c) { indexed(c).restart = true; }, version_3_capture()); }},
      {"restart", "set on a draw that is no indexed strip or fan", "FRAM 0", "restart", 0,
       [] { return lying([](Capture& c) { list(c).restart = true; }, version_3_capture()); }},
      {"instance-range", "3 matrices at byte 0 leave the buffer's 128 bytes", "FRAM 0", "instance_offset", 0,
       [] { return lying([](Capture& c) { indexed(c).instance_count = 3; }); }},
      {"instance-range", "2 matrices at byte " + std::to_string(kFar - 60), "FRAM 0", "instance_offset", 0,
       [] { return lying([](Capture& c) { indexed(c).instance_offset = kFar - 60; }); }},
      {"one-instance", "must be 1 without an instance buffer", "FRAM 0", "instance_count", 0,
       [] { return lying([](Capture& c) { indexed(c).instance_buffer = kNone; }); }},
      {"one-instance", "must be 1 without an instance buffer", "FRAM 0", "instance_count", 0,
       [] { return lying([](Capture& c) { list(c).instance_count = 0; }); }},

      {"most-buffers", "more than 1048576 of this kind", "BUFR 1048576", "id", 0,
       [] { return with_more(ChunkType::buffer, kMaxBuffers - 5); }},
      {"most-textures", "more than 65536 of this kind", "TEXR 65536", "id", 0,
       [] { return with_more(ChunkType::texture, kMaxTextures - 1); }},
      {"most-materials", "65537 is more than 65536", "MATL 0", "materials", 0,
       [] { return forged([](Forgery& f) { f.set_payload(ChunkType::material, 0, 0, kMaxMaterials + 1); }); }},
      {"most-materials", "more than 65536 in all", "MATL 1", "materials", 0,
       [] {
         return rebuilt(
             [](ForeignFile& f) {
               Capture many;
               many.materials.resize(kMaxMaterials - 1);
               Part part = f.part(ChunkType::material);
               part.header.id = 1;
               set_payload(part, RecordWriter(3).materials(many.materials));
               f.chunks.insert(f.chunks.end() - 2, part);
             },
             Codec::raw, version_3_capture());
       }},
      {"most-frames", "more than 65536 of this kind", "FRAM 65536", "id", 0,
       [] { return with_more(ChunkType::frame, kMaxFrames - 1); }},
      {"most-draws", "1048577 is more than 1048576", "FRAM 0", "draws", 0,
       [] { return forged([](Forgery& f) { f.set_payload(ChunkType::frame, 0, draw_count_at(f), kMaxDraws + 1); }); }},
      {"most-lights", "65537 is more than 65536", "FRAM 0", "point_lights", 0,
       [] {
         return forged([](Forgery& f) { f.set_payload(ChunkType::frame, 0, light_count_at(f), kMaxPointLights + 1); });
       }},
      {"most-triangles", "more than 268435456 triangles, instances counted", "FRAM 0", "draws", 0,
       [] {
         Capture capture = version_2_capture();
         capture.buffers[2].bytes.resize(sizeof(Matrix4) << 16);
         // 2^16 instances of 2 triangles, drawn 2^11 + 1 times.
         return lying(
             [](Capture& c) {
               indexed(c).instance_count = 1u << 16;
               const Draw draw = indexed(c);
               c.frames[0].draws.assign((1u << 11) + 1, draw);
             },
             capture);
       }},
      {"text-bytes", "longer than 65536 bytes", "META 0", "title", 0,
       [] { return lying([](Capture& c) { c.metadata.title.resize(kMaxTextBytes + 1, 'x'); }); }},
      {"text-bytes", "longer than 65536 bytes", "FRAM 0", "name", 0,
       [] { return lying([](Capture& c) { list(c).name.resize(kMaxTextBytes + 1, 'x'); }); }},
      {"most-notices", "4097 is more than 4096", "META 0", "notices", 0,
       [] { return lying([](Capture& c) { c.metadata.notices.resize(kMaxNotices + 1); }); }},
      {"texture-side", "16385 is outside 1 to 16384", "TEXR 0", "height", 0,
       [] { return lying([](Capture& c) { c.textures[0].height = kMaxTextureSide + 1; }); }},
      {"texture-side", "0 is outside 1 to 16384", "TEXR 0", "width", 0,
       [] { return lying([](Capture& c) { c.textures[0].width = 0; }); }},
      {"frame-side", "16385 is outside 1 to 16384", "FRAM 0", "width", 0,
       [] { return lying([](Capture& c) { c.frames[0].width = kMaxFrameSide + 1; }); }},
      {"frame-side", "0 is outside 1 to 16384", "FRAM 0", "height", 0,
       [] { return lying([](Capture& c) { c.frames[0].height = 0; }); }},
      {"most-indices", "the draws' different index ranges hold more than 2147483648 indices", "FRAM 0", "index_count",
       0,
       [] {
         Capture capture = version_2_capture();
         capture.buffers[1].bytes.assign(std::size_t{2} * ((1u << 24) + 128), std::byte{0});
         return lying(
             [](Capture& c) {
               Draw draw = indexed(c);
               draw.index_count = (1u << 24) - 1;  // a multiple of 3
               c.frames[0].draws.clear();
               for (std::uint64_t i = 0; i < 129; ++i) {
                 draw.index_offset = 2 * i;
                 c.frames[0].draws.push_back(draw);
               }
             },
             capture);
       }},
      {"decoded-bytes",
       "more than 1000 bytes in all",
       "FRAM 0",
       "decoded_bytes",
       24,
       [] { return forged([](Forgery&) {}); },
       {.decoded_bytes = 1000}},
      {"resource-bytes",
       "too many bytes in all buffers and textures",
       "BUFR 50",
       "data",
       0,
       [] {
         Capture capture;
         for (int i = 0; i < 100; ++i) capture.buffers.push_back({"b", Bytes(1000, std::byte{5})});
         return encode_capture(capture, {.zstd_level = 0});
       },
       {.decoded_bytes = 50000}},
      {"resource-bytes",
       "its strips and fans are too large as triangle lists",
       "",
       "",
       std::nullopt,
       [] {
         Capture capture = version_3_capture();
         capture.buffers[1].bytes.assign(20000, std::byte{0});
         indexed(capture).index_count = 9999;
         indexed(capture).topology = Topology::triangle_strip;
         return encode_capture(capture, {.zstd_level = 0});
       },
       {.decoded_bytes = 30000}}};
}

// Rules that more than one case of the table above can hold; this one needs a file that is one.
constexpr const char* kRuleOfFiles = "file-bytes";

TEST(CaptureRules, EveryBrokenFileIsRefusedForItsRule) {
  for (const Broken& broken : broken_files()) {
    SCOPED_TRACE(broken.rule + ", " + broken.chunk + ", " + broken.field);
    const Bytes file = broken.file();
    const std::string message = refusal(file, broken.limits);
    EXPECT_TRUE(message.starts_with("the capture can't be read: " + broken.why)) << message;
    if (broken.byte) {
      const std::string byte = ": byte " + std::to_string(offset_of(file, broken.chunk) + *broken.byte);
      EXPECT_NE((message + ",").find(byte + ","), std::string::npos) << message << "\nand not" << byte;
    }
    if (!broken.chunk.empty()) {
      EXPECT_NE(message.find(", chunk " + broken.chunk + ","), std::string::npos) << message;
    }
    if (!broken.field.empty()) {
      EXPECT_TRUE(message.ends_with(", field " + broken.field)) << message;
    }
  }
}

TEST(CaptureRules, WhatTheBrokenFilesAreMadeOfIsFine) {
  EXPECT_EQ(refusal(lying([](Capture&) {})), "");
  EXPECT_EQ(refusal(lying([](Capture&) {}, small_capture())), "");
  EXPECT_EQ(refusal(lying([](Capture&) {}, version_3_capture())), "");
  EXPECT_EQ(refusal(forged([](Forgery&) {})), "");
  EXPECT_EQ(refusal(rebuilt([](ForeignFile&) {})), "");
  EXPECT_EQ(refusal(deflated_frame([](Part&) {})), "");
  EXPECT_EQ(refusal(compressed()), "");
  EXPECT_EQ(refusal(resized_data(0)), "");
  EXPECT_EQ(refusal(with_more(ChunkType::texture, kMaxTextures - 2)), "");
}

TEST(CaptureRules, FilesLargerThanTheCallerTakesAreNotRead) {
  const std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) / ("capture_rules_" + std::to_string(::getpid()));
  write_capture(small_capture(), path);
  const std::uint64_t size = std::filesystem::file_size(path);
  EXPECT_NO_THROW(read_capture(path, {.file_bytes = size}));
  try {
    read_capture(path, {.file_bytes = size - 1});
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("larger than " + std::to_string(size - 1) + " bytes"), std::string::npos)
        << error.what();
  }
  std::filesystem::remove(path);
}

// The names in brackets at the beginning of list entries and table rows of the section of rules; what begins so without
// a name is given as it is.
std::set<std::string> rules_of_specification() {
  std::ifstream file(SUBPIXEL_SOURCE_DIR "/capture_format/SPEC.md");
  std::set<std::string> rules;
  bool is_inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("## ")) is_inside = line == "## Rules a reader enforces";
    if (!is_inside || !(line.starts_with("- ") || line.starts_with("| "))) continue;
    if (line == "| limit | most |" || line.starts_with("| ---")) continue;
    const std::size_t end = line.find(']');
    const bool has_name = line[2] == '[' && end != std::string::npos;
    const std::string rule = has_name ? line.substr(3, end - 3) : line;
    EXPECT_TRUE(rules.insert(rule).second) << "twice in SPEC.md: " << rule;
  }
  return rules;
}

TEST(CaptureRules, EachOfTheSpecificationIsBrokenHere) {
  std::set<std::string> broken{kRuleOfFiles};
  for (const Broken& each : broken_files()) broken.insert(each.rule);
  const std::set<std::string> rules = rules_of_specification();
  EXPECT_GT(rules.size(), 60u);
  for (const std::string& rule : rules) EXPECT_TRUE(broken.contains(rule)) << "no file here breaks: " << rule;
  for (const std::string& rule : broken) EXPECT_TRUE(rules.contains(rule)) << "not in SPEC.md: " << rule;
}

}  // namespace
}  // namespace subpixel::capture
