// What shaders declare is held against what passes supply: a wrong constant, slot, size or a forgotten address is
// named.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <stdexcept>

#include "replay/gpu/pass_recorder.hpp"
#include "replay/gpu/shader_interface.hpp"
#include "shaders/embedded.hpp"

namespace subpixel::gpu {
namespace {

Device& checking_device() {
  static Device device([] {
    DeviceOptions options;
    options.check_interfaces = true;
    return options;
  }());
  return device;
}

const ShaderInterface& interface_named(const std::string& name) {
  return checking_device().pipelines().interface(name);
}

// front-end's scan: one push constant, one buffer.
constexpr const char* kScan = "frontend/scan.comp";

std::string refusal(const std::function<void(PassRecorder&, ComputePass&)>& change) {
  PassRecorder recorder(checking_device());
  Buffer& values = recorder.buffer("values", 1024);
  ComputePass pass;
  pass.name = "scan";
  pass.shader = kScan;
  pass.bindings = {writes(0, values)};
  pass.push = PushConstants(std::uint32_t{4});
  change(recorder, pass);
  try {
    recorder.compute(pass);
  } catch (const std::logic_error& error) {
    return error.what();
  }
  return "";
}

TEST(ShaderInterface, NamesAndSizesAreThoseOfTheSource) {
  const ShaderInterface& scan = interface_named(kScan);
  EXPECT_EQ(scan.push_bytes, 4u);
  ASSERT_EQ(scan.slots.size(), 1u);
  EXPECT_EQ(scan.slots[0].binding, kStorageBinding);
  EXPECT_FALSE(scan.slots[0].name.empty());
  const ShaderInterface& gbuffer = interface_named("techniques/linked_list/gbuffer.frag");
  const auto allocation = std::ranges::find(gbuffer.constants, "ALLOCATION", &ShaderInterface::Constant::name);
  ASSERT_NE(allocation, gbuffer.constants.end());
  EXPECT_EQ(allocation->id, 10u);
  const auto material = std::ranges::find(gbuffer.slots, 1u, &ShaderInterface::Slot::set);
  ASSERT_NE(material, gbuffer.slots.end());
  EXPECT_EQ(material->name, "base_colour_texture");
}

TEST(ShaderInterface, EveryShaderOfTheBuildIsWalked) {
  for (const auto& embedded : shaders::all()) {
    SCOPED_TRACE(std::string(embedded.name));
    const ShaderInterface interface = interface_of(embedded.words);
    EXPECT_LE(interface.push_bytes, kPushConstantBytes);
    for (const auto& slot : interface.slots) EXPECT_LT(slot.binding, slot.set == 0 ? kBindings : kMaterialTextures);
    for (const auto& constant : interface.constants) EXPECT_FALSE(constant.name.empty());
  }
}

TEST(ShaderInterface, WhatIsNoModuleIsRefused) {
  const auto& words = shaders::all().front().words;
  EXPECT_THROW(interface_of({}), std::logic_error);
  EXPECT_THROW(interface_of(words.subspan(1)), std::logic_error);
  EXPECT_THROW(interface_of(words.first(6)), std::logic_error) << "within the first instruction";
}

TEST(ShaderInterface, APassThatSuppliesAllIsTaken) {
  EXPECT_EQ(refusal([](PassRecorder&, ComputePass&) {}), "");
}

TEST(ShaderInterface, AConstantThatNobodyDeclaresIsNamed) {
  const std::string said = refusal([](PassRecorder&, ComputePass& pass) { pass.constants = {{31, 1}}; });
  EXPECT_NE(said.find("id 31"), std::string::npos) << said;
  EXPECT_NE(said.find(kScan), std::string::npos) << said;
}

TEST(ShaderInterface, AConstantThatIsMissingIsNamed) {
  const ShaderInterface& gbuffer = interface_named("techniques/linked_list/gbuffer.frag");
  SuppliedInterface supplied;
  for (const auto& constant : gbuffer.constants)
    if (constant.name != "FIRST_BLOCK") supplied.constants.push_back(constant.id);
  for (const auto& slot : gbuffer.slots) supplied.bindings.push_back(slot.binding);
  supplied.material = true;
  supplied.push_bytes = gbuffer.push_bytes;
  const ShaderStage stage{"gbuffer.frag", &gbuffer};
  const std::string said = mismatch(std::span(&stage, 1), supplied);
  EXPECT_NE(said.find("FIRST_BLOCK"), std::string::npos) << said;
  supplied.constants.push_back(11);
  EXPECT_EQ(mismatch(std::span(&stage, 1), supplied), "");
  supplied.material = false;
  EXPECT_NE(mismatch(std::span(&stage, 1), supplied).find("base_colour_texture"), std::string::npos);
}

TEST(ShaderInterface, AWrongSlotIsNamed) {
  const std::string said = refusal([](PassRecorder&, ComputePass& pass) { pass.bindings[0].slot = 1; });
  EXPECT_NE(said.find("binding 1 of set 0"), std::string::npos) << said;
  EXPECT_NE(said.find("leaves empty"), std::string::npos) << said;
}

TEST(ShaderInterface, AWrongSizeIsNamed) {
  const std::string said =
      refusal([](PassRecorder&, ComputePass& pass) { pass.push = PushConstants(std::array<std::uint32_t, 4>{}); });
  EXPECT_NE(said.find("4 bytes of push constants, the pass supplies 16"), std::string::npos) << said;
  EXPECT_NE(refusal([](PassRecorder&, ComputePass& pass) { pass.push = {}; }), "");
}

TEST(ShaderInterface, AForgottenAddressIsNamed) {
  PassRecorder recorder(checking_device());
  Buffer& forgotten = recorder.buffer("forgotten", 64);
  Buffer& table = recorder.buffer("addresses", 8);
  const std::string pushed =
      refusal([&](PassRecorder&, ComputePass& pass) { pass.push = PushConstants(forgotten.address()); });
  EXPECT_NE(pushed.find("forgotten"), std::string::npos) << pushed;
  // In a small buffer that the pass binds.
  table.as<VkDeviceAddress>()[0] = forgotten.address() + 16;
  const auto bound = [&](bool declared) {
    return refusal([&](PassRecorder&, ComputePass& pass) {
      pass.bindings = {writes(0, table)};
      if (declared) pass.by_address = {&forgotten};
    });
  };
  EXPECT_NE(bound(false).find("forgotten"), std::string::npos) << bound(false);
  EXPECT_EQ(bound(true), "");
}

}  // namespace
}  // namespace subpixel::gpu
