#include "replay/gpu/shader_interface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>

#include "shaders/include/interface.h"

namespace subpixel::gpu {
namespace {

// SPIR-V 1.6, section 3: the enumerants that the walk meets.
enum Op : std::uint32_t {
  kName = 5,
  kMemberName = 6,
  kTypeBool = 20,
  kTypeInt = 21,
  kTypeFloat = 22,
  kTypeVector = 23,
  kTypeMatrix = 24,
  kTypeArray = 28,
  kTypeRuntimeArray = 29,
  kTypeStruct = 30,
  kTypePointer = 32,
  kConstant = 43,
  kFunction = 54,
  kVariable = 59,
  kDecorate = 71,
  kMemberDecorate = 72,
};
constexpr std::uint32_t kMagic = 0x07230203, kHeaderWords = 5;
constexpr std::uint32_t kSpecId = 1, kArrayStride = 6, kBinding = 33, kDescriptorSet = 34, kOffset = 35;
constexpr std::uint32_t kStoragePushConstant = 9;

using Words = std::span<const std::uint32_t>;

// A literal string of 4 characters a word, ended by a zero.
std::string text_of(Words words) {
  std::string text;
  for (const std::uint32_t word : words) {
    for (std::uint32_t shift = 0; shift < 32; shift += 8) {
      const char c = static_cast<char>(word >> shift & 0xff);
      if (c == '\0') return text;
      text += c;
    }
  }
  return text;
}

class Module {
 public:
  explicit Module(Words words) {
    if (words.size() < kHeaderWords || words[0] != kMagic) throw std::logic_error("a shader that is no SPIR-V module");
    for (std::size_t at = kHeaderWords; at < words.size();) {
      const std::uint32_t count = words[at] >> 16;
      if (count == 0 || count > words.size() - at)
        throw std::logic_error("a SPIR-V module that ends within an instruction");
      if ((words[at] & 0xffff) == kFunction) break;  // declarations come before
      read(words[at] & 0xffff, words.subspan(at + 1, count - 1));
      at += count;
    }
  }

  ShaderInterface interface() const {
    ShaderInterface result;
    for (const auto& [id, number] : all_of(kSpecId)) result.constants.push_back({number, name_of(id)});
    for (const auto& [id, binding] : all_of(kBinding)) {
      const auto set = all_of(kDescriptorSet).find(id);
      result.slots.push_back(
          {set == all_of(kDescriptorSet).end() ? 0 : set->second, binding, name_of(id), holds_addresses(id)});
    }
    for (const std::uint32_t pointer : push_pointers_) {
      result.push_bytes = size_of(pointee_.at(pointer));
      find_addresses(pointee_.at(pointer), 0, "", result.push_addresses);
    }
    std::ranges::sort(result.constants, {}, &ShaderInterface::Constant::id);
    std::ranges::sort(result.slots, {}, [](const ShaderInterface::Slot& s) { return std::pair(s.set, s.binding); });
    return result;
  }

 private:
  struct Type {
    std::uint32_t op = 0;
    std::vector<std::uint32_t> operands;
  };

  void read(std::uint32_t op, Words operands) {
    switch (op) {
      case kName:
        names_[operands[0]] = text_of(operands.subspan(1));
        break;
      case kMemberName:
        member_names_[{operands[0], operands[1]}] = text_of(operands.subspan(2));
        break;
      case kDecorate:
        if (operands.size() >= 3) decorated_[operands[1]][operands[0]] = operands[2];
        break;
      case kMemberDecorate:
        if (operands.size() >= 4) member_decorated_[{operands[0], operands[1], operands[2]}] = operands[3];
        break;
      case kTypePointer:
        pointee_[operands[0]] = operands[2];
        types_[operands[0]] = {op, {}};
        break;
      case kTypeBool:
      case kTypeInt:
      case kTypeFloat:
      case kTypeVector:
      case kTypeMatrix:
      case kTypeArray:
      case kTypeRuntimeArray:
      case kTypeStruct:
        types_[operands[0]] = {op, {operands.begin() + 1, operands.end()}};
        break;
      case kConstant:
        constants_[operands[1]] = operands[2];
        break;
      case kVariable:
        type_of_variable_[operands[1]] = operands[0];
        if (operands[2] == kStoragePushConstant) push_pointers_.push_back(operands[0]);
        break;
      default:
        break;
    }
  }

  const std::map<std::uint32_t, std::uint32_t>& all_of(std::uint32_t decoration) const {
    static const std::map<std::uint32_t, std::uint32_t> kNone;
    const auto found = decorated_.find(decoration);
    return found == decorated_.end() ? kNone : found->second;
  }

  // A name of a block without one of its own is that of its type.
  std::string name_of(std::uint32_t id) const {
    const auto found = names_.find(id);
    if (found != names_.end() && !found->second.empty()) return found->second;
    const auto type = type_of_variable_.find(id);
    if (type == type_of_variable_.end()) return "";
    const auto pointee = pointee_.find(type->second);
    const auto block = pointee == pointee_.end() ? names_.end() : names_.find(pointee->second);
    return block == names_.end() ? "" : block->second;
  }

  std::uint32_t size_of(std::uint32_t id) const {
    const Type& type = types_.at(id);
    switch (type.op) {
      case kTypeInt:
      case kTypeFloat:
        return type.operands[0] / 8;
      case kTypeBool:
        return 4;
      case kTypePointer:
        return 8;  // the address of a buffer
      case kTypeVector:
        return type.operands[1] * size_of(type.operands[0]);
      case kTypeMatrix:
        return type.operands[1] * size_of(type.operands[0]);
      case kTypeArray: {
        const auto stride = all_of(kArrayStride).find(id);
        const std::uint32_t each = stride == all_of(kArrayStride).end() ? size_of(type.operands[0]) : stride->second;
        return constants_.at(type.operands[1]) * each;
      }
      default: {
        std::uint32_t end = 0;
        for (std::uint32_t member = 0; member < type.operands.size(); ++member) {
          const auto offset = member_decorated_.find({id, member, kOffset});
          const std::uint32_t begin = offset == member_decorated_.end() ? end : offset->second;
          end = std::max(end, begin + size_of(type.operands[member]));
        }
        return end;
      }
    }
  }

  // Pointers in a block are addresses. Arrays of them are not looked into: there are none.
  void find_addresses(std::uint32_t id, std::uint32_t begin, const std::string& name,
                      std::vector<ShaderInterface::PushAddress>& found) const {
    const auto type = types_.find(id);
    if (type == types_.end()) return;
    if (type->second.op == kTypePointer) found.push_back({begin, name});
    if (type->second.op != kTypeStruct) return;
    for (std::uint32_t member = 0; member < type->second.operands.size(); ++member) {
      const auto offset = member_decorated_.find({id, member, kOffset});
      const auto called = member_names_.find({id, member});
      find_addresses(type->second.operands[member], begin + (offset == member_decorated_.end() ? 0 : offset->second),
                     called == member_names_.end() ? "" : called->second, found);
    }
  }

  bool holds_addresses(std::uint32_t variable) const {
    const auto type = type_of_variable_.find(variable);
    const auto block = type == type_of_variable_.end() ? pointee_.end() : pointee_.find(type->second);
    if (block == pointee_.end()) return false;
    std::vector<ShaderInterface::PushAddress> found;
    find_addresses(block->second, 0, "", found);
    return !found.empty();
  }

  std::map<std::uint32_t, std::string> names_;
  std::map<std::array<std::uint32_t, 2>, std::string> member_names_;
  std::map<std::uint32_t, std::map<std::uint32_t, std::uint32_t>> decorated_;  // by decoration, then by id
  std::map<std::array<std::uint32_t, 3>, std::uint32_t> member_decorated_;     // type, member, decoration
  std::map<std::uint32_t, Type> types_;
  std::map<std::uint32_t, std::uint32_t> pointee_, constants_, type_of_variable_;
  std::vector<std::uint32_t> push_pointers_;
};

}  // namespace

ShaderInterface interface_of(Words words) {
  return Module(words).interface();
}

std::string mismatch(std::span<const ShaderStage> stages, const SuppliedInterface& supplied) {
  const auto has = [](const std::vector<std::uint32_t>& list, std::uint32_t value) {
    return std::ranges::find(list, value) != list.end();
  };
  std::string names;
  for (const ShaderStage& stage : stages) {
    names += (names.empty() ? "" : " and ") + stage.name;
    for (const ShaderInterface::Constant& constant : stage.interface->constants) {
      if (!has(supplied.constants, constant.id)) {
        return fmt::format("{} declares the constant {} (id {}), which the pass does not supply", stage.name,
                           constant.name, constant.id);
      }
    }
    for (const ShaderInterface::Slot& slot : stage.interface->slots) {
      if (slot.set == 0 ? !has(supplied.bindings, slot.binding) : !supplied.material) {
        return fmt::format("{} declares {} at binding {} of set {}, which the pass leaves empty", stage.name, slot.name,
                           slot.binding, slot.set);
      }
      if (slot.holds_addresses && !has(supplied.address_tables, slot.binding)) {
        return fmt::format("{} reads at addresses that {} at binding {} holds, whose uses the pass does not declare",
                           stage.name, slot.name, slot.binding);
      }
    }
    // A host struct may end in padding of less than its largest member.
    const std::uint32_t declared = stage.interface->push_bytes;
    if (declared > 0 && (supplied.push_bytes < declared || supplied.push_bytes >= declared + 8)) {
      return fmt::format("{} declares {} bytes of push constants, the pass supplies {}", stage.name, declared,
                         supplied.push_bytes);
    }
  }
  for (const std::uint32_t id : supplied.constants) {
    const bool is_declared = std::ranges::any_of(stages, [&](const ShaderStage& stage) {
      const auto& constants = stage.interface->constants;
      return std::ranges::find(constants, id, &ShaderInterface::Constant::id) != constants.end();
    });
    if (id >= PASS_CONSTANTS && !is_declared && !has(supplied.known_constants, id)) {
      return fmt::format("the pass supplies the constant of id {}, which {} does not declare", id, names);
    }
  }
  return "";
}

}  // namespace subpixel::gpu
