#include "capture_format/chunk.hpp"

#include <xxhash.h>
#include <zlib.h>

#include <memory>

namespace subpixel::capture {
namespace {

std::uint64_t crc32_of(std::span<const std::byte> first, std::span<const std::byte> second) {
  const auto* a = reinterpret_cast<const Bytef*>(first.data());
  const auto* b = reinterpret_cast<const Bytef*>(second.data());
  // A null pointer asks zlib for the initial value, which is that of no bytes.
  const uLong of_first = ::crc32_z(0, first.empty() ? nullptr : a, first.size());
  return second.empty() ? of_first : ::crc32_z(of_first, b, second.size());
}

}  // namespace

std::uint64_t checksum_of(std::span<const std::byte> first, std::span<const std::byte> second, Checksum kind) {
  if (kind == Checksum::crc32) return crc32_of(first, second);
  const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(), &XXH3_freeState);
  XXH3_64bits_reset(state.get());
  XXH3_64bits_update(state.get(), first.data(), first.size());
  XXH3_64bits_update(state.get(), second.data(), second.size());
  return XXH3_64bits_digest(state.get());
}

}  // namespace subpixel::capture
