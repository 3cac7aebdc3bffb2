#include "capture_format/chunk.hpp"

#include <xxhash.h>

#include <memory>

namespace subpixel::capture {

std::uint64_t xxh3_64_of(std::span<const std::byte> first, std::span<const std::byte> second) {
  const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(), &XXH3_freeState);
  XXH3_64bits_reset(state.get());
  XXH3_64bits_update(state.get(), first.data(), first.size());
  XXH3_64bits_update(state.get(), second.data(), second.size());
  return XXH3_64bits_digest(state.get());
}

}  // namespace subpixel::capture
