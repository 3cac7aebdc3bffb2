// Mutates captures as captures: chunk by chunk, sizes, index and footer made right again, so that most of what the
// fuzzer tries gets past the frame of the file to the records. Checksums of files without CRC-32 are right too, so that
// a build that looks at them can use it (tests/unit/capture_mutation_test.cpp).
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <random>
#include <span>
#include <vector>

#include "capture_format/chunk.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace {

using namespace subpixel::capture;

struct Chunk {
  std::uint32_t type = 0, id = 0, codec = 0;
  std::uint64_t decoded_bytes = 0;
  std::vector<std::uint8_t> stored;
};

struct File {
  std::uint32_t version = 1, flags = 0;
  std::vector<Chunk> chunks;  // all but the index
};

template <typename T>
T load(std::span<const std::uint8_t> from, std::size_t at) {
  T value;
  std::memcpy(&value, from.data() + at, sizeof value);
  return value;
}

template <typename T>
void put(std::vector<std::uint8_t>& to, const T& value) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&value);
  to.insert(to.end(), bytes, bytes + sizeof value);
}

// Whatever of it has the form of chunks.
File parse(std::span<const std::uint8_t> data) {
  File file;
  if (data.size() < kHeaderBytes) return file;
  file.version = load<std::uint32_t>(data, 8);
  file.flags = load<std::uint32_t>(data, 12);
  std::size_t at = kHeaderBytes;
  while (data.size() >= at + kChunkHeaderBytes) {
    Chunk chunk{load<std::uint32_t>(data, at),
                load<std::uint32_t>(data, at + 4),
                load<std::uint32_t>(data, at + 8),
                load<std::uint64_t>(data, at + 24),
                {}};
    const auto stored = load<std::uint64_t>(data, at + 16);
    at += kChunkHeaderBytes;
    if (chunk.type == static_cast<std::uint32_t>(ChunkType::index) || stored > data.size() - at) break;
    chunk.stored.assign(data.begin() + static_cast<std::ptrdiff_t>(at),
                        data.begin() + static_cast<std::ptrdiff_t>(at + stored));
    at = aligned(at + stored);
    file.chunks.push_back(std::move(chunk));
    if (at > data.size()) break;
  }
  return file;
}

void put_chunk(std::vector<std::uint8_t>& out, const Chunk& chunk) {
  put(out, chunk.type);
  put(out, chunk.id);
  put(out, chunk.codec);
  put(out, std::uint32_t{0});
  put(out, std::uint64_t{chunk.stored.size()});
  put(out, chunk.codec == 0 ? std::uint64_t{chunk.stored.size()} : chunk.decoded_bytes);
  const auto head = std::as_bytes(std::span(out)).last(kChunkHeaderBytes - 8);
  put(out, xxh3_64_of(head, std::as_bytes(std::span(chunk.stored))));
  out.insert(out.end(), chunk.stored.begin(), chunk.stored.end());
  out.resize(aligned(out.size()));
}

std::vector<std::uint8_t> written(const File& file) {
  std::vector<std::uint8_t> out(kMagic.begin(), kMagic.end());
  put(out, file.version);
  put(out, file.flags);
  Chunk index{static_cast<std::uint32_t>(ChunkType::index), 0, 0, 0, {}};
  for (const Chunk& chunk : file.chunks) {
    put(index.stored, chunk.type);
    put(index.stored, chunk.id);
    put(index.stored, std::uint64_t{out.size()});
    put_chunk(out, chunk);
  }
  const std::uint64_t index_offset = out.size();
  put_chunk(out, index);
  put(out, index_offset);
  put(out, std::uint64_t{out.size() + kFooterBytes - 8});
  const auto all = std::as_bytes(std::span(out));
  put(out, xxh3_64_of(all.first(kHeaderBytes), all.last(16)));
  out.insert(out.end(), kEndMagic.begin(), kEndMagic.end());
  return out;
}

// Ids count up by type again after chunks came, went or moved.
void renumber(File& file) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> next;
  for (Chunk& chunk : file.chunks) {
    auto found = std::find_if(next.begin(), next.end(), [&](const auto& entry) { return entry.first == chunk.type; });
    if (found == next.end()) found = next.insert(next.end(), {chunk.type, 0});
    chunk.id = found->second++;
  }
}

// A number of a payload becomes one that tends to be on the edge of something.
void set_number(std::vector<std::uint8_t>& payload, std::minstd_rand& random) {
  if (payload.size() < 4) return;
  constexpr std::uint32_t kEdges[] = {0,          1,          2,          3,       4,          8,          16,
                                      0xff,       0x100,      0xffff,     0x10000, 0x7fc00000, 0x7f800000, 0x80000000,
                                      0x7fffffff, 0xfffffffe, 0xffffffff, 17,      100000000,  5};
  const std::size_t at = random() % (payload.size() - 3);
  auto value = load<std::uint32_t>(payload, at);
  value =
      random() % 2 == 0 ? kEdges[random() % std::size(kEdges)] : value + static_cast<std::uint32_t>(random() % 9) - 4;
  std::memcpy(payload.data() + at, &value, sizeof value);
}

void mutate(File& file, std::minstd_rand& random) {
  if (file.chunks.empty()) return;
  Chunk& chunk = file.chunks[random() % file.chunks.size()];
  switch (random() % 12) {
    case 0: {  // a chunk twice
      const Chunk copy = chunk;
      file.chunks.insert(file.chunks.begin() + static_cast<std::ptrdiff_t>(random() % (file.chunks.size() + 1)), copy);
      renumber(file);
      break;
    }
    case 1:
      file.chunks.erase(file.chunks.begin() + (&chunk - file.chunks.data()));
      renumber(file);
      break;
    case 2:
      std::swap(chunk, file.chunks[random() % file.chunks.size()]);
      renumber(file);
      break;
    case 3:
      file.version = static_cast<std::uint32_t>(random() % 4);
      break;
    case 4:
      file.flags ^= 1;
      break;
    case 5:
      chunk.codec = static_cast<std::uint32_t>(random() % 4);
      break;
    case 6:
    case 7:
    case 8:
      set_number(chunk.stored, random);
      break;
    default: {
      const std::size_t size = chunk.stored.size();
      chunk.stored.resize(size + 16);
      chunk.stored.resize(LLVMFuzzerMutate(chunk.stored.data(), size, chunk.stored.size()));
    }
  }
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most,
                                               unsigned int seed) {
  std::minstd_rand random(seed + 1);
  if (random() % 16 == 0) return LLVMFuzzerMutate(data, size, most);  // the frame of the file itself
  File file = parse({data, size});
  for (unsigned long count = 1 + random() % 3; count > 0; --count) mutate(file, random);
  const std::vector<std::uint8_t> out = written(file);
  if (file.chunks.empty() || out.size() > most) return LLVMFuzzerMutate(data, size, most);
  std::copy(out.begin(), out.end(), data);
  return out.size();
}
