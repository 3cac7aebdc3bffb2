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
#include "shaders/include/shared_types.h"
#include "shaders/techniques/linked_list/linked_list_interface.h"

namespace subpixel::gpu {
namespace {

Device& checking_device() {
  static Device device;
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
  pass.bindings = {writes(FRONTEND_SLOT_SUMS, values)};
  pass.push = PushConstants(gpu_types::ScanPush{4});
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
  EXPECT_EQ(scan.slots[0].binding, kStorageBinding + FRONTEND_SLOT_SUMS);
  EXPECT_FALSE(scan.slots[0].name.empty());
  const ShaderInterface& gbuffer = interface_named("techniques/linked_list/gbuffer.comp");
  const auto allocation = std::ranges::find(gbuffer.constants, "ALLOCATION", &ShaderInterface::Constant::name);
  ASSERT_NE(allocation, gbuffer.constants.end());
  EXPECT_EQ(allocation->id, std::uint32_t{LINK_CONSTANT_ALLOCATION});
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
  const ShaderInterface& gbuffer = interface_named("techniques/linked_list/gbuffer.comp");
  SuppliedInterface supplied;
  for (const auto& constant : gbuffer.constants)
    if (constant.name != "FIRST_BLOCK") supplied.constants.push_back(constant.id);
  for (const auto& slot : gbuffer.slots) supplied.bindings.push_back(slot.binding);
  supplied.address_tables = {STORAGE(LINK_SLOT_POOL), STORAGE(FRONTEND_SLOT_LISTS)};
  supplied.material = true;
  supplied.push_bytes = gbuffer.push_bytes;
  const ShaderStage stage{"gbuffer.comp", &gbuffer};
  const std::string said = mismatch(std::span(&stage, 1), supplied);
  EXPECT_NE(said.find("FIRST_BLOCK"), std::string::npos) << said;
  supplied.constants.push_back(LINK_CONSTANT_FIRST_BLOCK);
  EXPECT_EQ(mismatch(std::span(&stage, 1), supplied), "");
  supplied.material = false;
  EXPECT_NE(mismatch(std::span(&stage, 1), supplied).find("base_colour_texture"), std::string::npos);
}

TEST(ShaderInterface, AWrongSlotIsNamed) {
  const std::string said = refusal([](PassRecorder&, ComputePass& pass) { ++pass.bindings[0].slot; });
  EXPECT_NE(said.find("binding 3 of set 0"), std::string::npos) << said;
  EXPECT_NE(said.find("leaves empty"), std::string::npos) << said;
}

TEST(ShaderInterface, AWrongSizeIsNamed) {
  const std::string said =
      refusal([](PassRecorder&, ComputePass& pass) { pass.push = PushConstants(std::array<std::uint32_t, 4>{}); });
  EXPECT_NE(said.find("4 bytes of push constants, the pass supplies 16"), std::string::npos) << said;
  EXPECT_NE(refusal([](PassRecorder&, ComputePass& pass) { pass.push = {}; }), "");
}

TEST(ShaderInterface, AForgottenAddressIsNamed) {
  const auto list_small = [](bool declared) {
    return refusal([&](PassRecorder& recorder, ComputePass& pass) {
      pass.shader = "frontend/list_small.comp:COUNT";
      Buffer& lists = recorder.buffer("lists", 64);
      pass.bindings = {reads(FRONTEND_SLOT_SMALL_RECORDS, lists), writes(FRONTEND_SLOT_SMALL_TRIANGLES, lists),
                       writes(FRONTEND_SLOT_BLOCK_ENDS, lists)};
      Buffer& records = recorder.buffer("records", 96);
      AddressUses elsewhere;
      gpu_types::ListSmallPush push{};
      push.records = declared ? pass.reads(records) : elsewhere.reads(records);
      pass.push = PushConstants(push);
    });
  };
  EXPECT_NE(list_small(false).find("address records of its push constants"), std::string::npos) << list_small(false);
  EXPECT_NE(list_small(false).find("the buffer records"), std::string::npos) << list_small(false);
  EXPECT_EQ(list_small(true), "");
}

TEST(ShaderInterface, AnotherPipelineOfThePassIsHeldToItToo) {
  PassRecorder recorder(checking_device());
  Image& image = recorder.image({"states", VK_FORMAT_R32G32B32A32_UINT, 4, 4, 1, 1, VK_SAMPLE_COUNT_1_BIT,
                                 VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT, false});
  RasterPass pass;
  pass.name = "litmus";
  pass.pipeline.vertex = "frontend/litmus.vert";
  pass.pipeline.fragment = "frontend/litmus.frag:ATTACHMENT";
  pass.pipeline.targets.ordered_read = pass.pipeline.targets.clear = true;
  pass.colours = {{image}};
  pass.clear_colours = {{}};
  EXPECT_NO_THROW(recorder.raster(pass));
  pass.alternatives = {pass.pipeline};
  pass.alternatives[0].fragment = "frontend/litmus.frag:BUFFER";
  try {
    recorder.raster(pass);
    ADD_FAILURE() << "taken";
  } catch (const std::logic_error& error) {
    EXPECT_NE(std::string(error.what()).find("the constant WIDTH"), std::string::npos) << error.what();
  }
}

// A buffer of addresses says what they lead to.
TEST(ShaderInterface, ATableWithoutUsesIsNamed) {
  const auto groups = [](bool as_table) {
    return refusal([&](PassRecorder& recorder, ComputePass& pass) {
      Image& visibility = recorder.image({"visibility", VK_FORMAT_R32G32B32A32_UINT, 4, 4, 1, 1, VK_SAMPLE_COUNT_1_BIT,
                                          VK_IMAGE_USAGE_SAMPLED_BIT, true});
      AddressTable& table = recorder.address_table("pool", sizeof(gpu_types::LinkPool));
      pass.shader = "techniques/linked_list/groups.comp";
      pass.constants = {{CONSTANT_SAMPLES, 8},
                        {CONSTANT_FEATURES, 0},
                        {LINK_CONSTANT_ALLOCATION, 0},
                        {LINK_CONSTANT_FIRST_BLOCK, 0},
                        {LINK_CONSTANT_LIGHTING, 0}};
      pass.bindings = {uniform(recorder.buffer("frame", sizeof(gpu_types::FrameConstants))),
                       samples(FRAME_SLOT_VISIBILITY, visibility),
                       as_table ? writes(LINK_SLOT_POOL, table) : writes(LINK_SLOT_POOL, table.buffer()),
                       writes(LINK_SLOT_GROUPS, recorder.buffer("groups", 12))};
      pass.push = {};
    });
  };
  EXPECT_NE(groups(false).find("reads at addresses that Pool"), std::string::npos) << groups(false);
  EXPECT_EQ(groups(true), "");
}

}  // namespace
}  // namespace subpixel::gpu
