// What a compiled shader asks of the host: specialization constants, descriptor slots, the size of its push constants.
// Vulkan ignores an unknown constant, takes GLSL's default for a missing one and reads an empty slot as it likes, all
// in silence; held against what a pass supplies, each is an error that names shader and member.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace subpixel::gpu {

struct ShaderInterface {
  struct Constant {
    std::uint32_t id = 0;
    std::string name;
  };
  struct Slot {
    std::uint32_t set = 0, binding = 0;
    std::string name;
    bool holds_addresses = false;  // of other buffers
  };
  struct PushAddress {
    std::uint32_t offset = 0;
    std::string name;
  };
  std::vector<Constant> constants;  // by id
  std::vector<Slot> slots;          // by set and binding
  std::uint32_t push_bytes = 0;     // to the end of the last member; 0: no push constants
  std::vector<PushAddress> push_addresses;
};

// Walks the module's declarations (SPIR-V 1.6, sections 2.3 and 3.42). What is declared counts, whether or not it is
// used. Throws std::logic_error for words that are no module, since modules are the build's own.
ShaderInterface interface_of(std::span<const std::uint32_t> words);

// A stage of a pipeline.
struct ShaderStage {
  std::string name;
  const ShaderInterface* interface = nullptr;
};

// What a pass supplies to its stages. It may supply more than one of them has use for: a technique gives all its passes
// its constants.
struct SuppliedInterface {
  std::vector<std::uint32_t> constants;        // ids
  std::vector<std::uint32_t> known_constants;  // ids that shaders of the same folders declare
  std::vector<std::uint32_t> bindings;         // of set 0
  std::vector<std::uint32_t> address_tables;   // those of them whose addresses' uses are declared
  std::uint32_t push_bytes = 0;
  bool material = false;  // set 1
};

// Ids below PASS_CONSTANTS are the frame's and may be supplied to any shader.
// One line for the first thing that a stage declares and the pass lacks, for push constants of another size, and for a
// constant that neither a stage nor another shader of its folder declares; empty when all is there.
std::string mismatch(std::span<const ShaderStage> stages, const SuppliedInterface& supplied);

}  // namespace subpixel::gpu
