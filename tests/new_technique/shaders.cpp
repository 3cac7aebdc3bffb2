// The shader of the technique that the script makes.
#include "shaders/embedded.hpp"

extern "C" const std::uint32_t made_by_script_resolve[], made_by_script_resolve_end[];

std::span<const subpixel::shaders::Embedded> subpixel::shaders::test_shaders() {
  static const Embedded kTable[] = {
      {"techniques/made_by_script/resolve.frag", {made_by_script_resolve, made_by_script_resolve_end}}};
  return kTable;
}
