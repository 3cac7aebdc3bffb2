// libFuzzer target of the model readers that are ours: glTF, GLB, and OBJ with its MTL. The first byte of an input says
// which; of OBJ the rest is the model and, after a byte of 30, its material library. A model is refused with an
// InputError or holds to what Model promises. JSON is mutated as JSON.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "base/fuzz/json_mutator.hpp"
#include "scenes/import/asset_source.hpp"
#include "scenes/import/gltf.hpp"
#include "scenes/import/obj.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace {

class MemorySource final : public subpixel::capture::AssetSource {
 public:
  std::map<std::string, std::vector<std::byte>> files;

  std::optional<std::vector<std::byte>> read(const std::string& name) const override {
    const auto found = files.find(name);
    return found == files.end() ? std::nullopt : std::optional(found->second);
  }
  bool contains(const std::string& name) const override { return files.count(name) != 0; }
  std::optional<std::string> find(const std::string& name) const override {
    return contains(name) ? std::optional(name) : std::nullopt;
  }
  std::string describe(const std::string& name) const override { return name; }
};

constexpr std::array<std::string_view, 8> kWords{"", "SCALAR", "VEC2", "VEC3", "VEC4", "MAT4", "MASK", "BLEND"};

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most,
                                               unsigned int seed) {
  std::minstd_rand random(seed + 1);
  const bool is_gltf = size > 1 && data[0] % 3 == 0;
  const bool is_glb = size > 21 && data[0] % 3 == 1;
  if (random() % 4 == 0 || !(is_gltf || is_glb)) return LLVMFuzzerMutate(data, size, most);
  std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  std::string rest;
  if (is_glb) {  // header of 12 bytes, length and kind of the JSON, the JSON, the binary chunk
    std::uint32_t length = 0;
    std::memcpy(&length, data + 13, 4);
    if (length > size - 21) return LLVMFuzzerMutate(data, size, most);
    rest = text.substr(20 + length);
    text = text.substr(20, length);
  }
  std::string made = subpixel::mutated_json(text, kWords, random);
  if (made.empty()) return LLVMFuzzerMutate(data, size, most);
  if (is_glb) {
    made.resize((made.size() + 3) / 4 * 4, ' ');
    std::string head(reinterpret_cast<const char*>(data) + 1, 20);
    const auto length = static_cast<std::uint32_t>(made.size());
    const auto total = static_cast<std::uint32_t>(20 + made.size() + rest.size());
    std::memcpy(head.data() + 8, &total, 4);
    std::memcpy(head.data() + 12, &length, 4);
    made = head + made + rest;
  }
  if (made.size() + 1 > most) return LLVMFuzzerMutate(data, size, most);
  std::memcpy(data + 1, made.data(), made.size());
  return made.size() + 1;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace subpixel::capture;
  if (size == 0) return 0;
  const auto bytes = std::as_bytes(std::span(data, size)).subspan(1);
  MemorySource source;
  try {
    Model model;
    if (data[0] % 3 == 2) {
      const auto cut = std::find(bytes.begin(), bytes.end(), std::byte{30});
      source.files["m.obj"] = {bytes.begin(), cut};
      if (cut != bytes.end()) source.files["m.mtl"] = {cut + 1, bytes.end()};
      model = load_obj(source, "m.obj");
    } else {
      const std::string name = data[0] % 3 == 0 ? "m.gltf" : "m.glb";
      source.files[name] = {bytes.begin(), bytes.end()};
      model = load_gltf(source, name);
    }
    for (const ModelPart& part : model.parts) {
      for (const std::uint32_t index : part.mesh.indices) {
        if (index >= part.mesh.positions.size()) std::abort();
      }
    }
  } catch (const subpixel::InputError&) {
  }
  return 0;
}
