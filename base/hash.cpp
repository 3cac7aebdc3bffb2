#include "base/hash.hpp"

#include <xxhash.h>

#include <cstdio>
#include <memory>
#include <vector>

#include "base/error.hpp"

namespace subpixel {
namespace {

std::string hex(XXH128_hash_t hash) {
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, hash);
  std::string text;
  for (const unsigned char byte : canonical.digest) {
    constexpr char kDigits[] = "0123456789abcdef";
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

}  // namespace

std::string content_hash_hex(std::span<const std::byte> bytes) {
  return hex(XXH3_128bits(bytes.data(), bytes.size()));
}

std::string content_hash_hex(const std::filesystem::path& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(), &XXH3_freeState);
  if (!file) throw InputError("can't hash the file", "it can't be opened", path.string());
  XXH3_128bits_reset(state.get());
  std::vector<char> block(std::size_t{1} << 20);
  std::size_t got = 0;
  while ((got = std::fread(block.data(), 1, block.size(), file.get())) > 0) {
    XXH3_128bits_update(state.get(), block.data(), got);
  }
  if (std::ferror(file.get()) != 0) throw InputError("can't hash the file", "it can't be read", path.string());
  return hex(XXH3_128bits_digest(state.get()));
}

}  // namespace subpixel
