#include "replay/frame/technique.hpp"

namespace subpixel::replay {

TechniqueSetting Technique::with(const ParameterValues& given) const {
  TechniqueSetting setting{this, check_parameters(name, parameters, given), nullptr};
  setting.parameters = read(setting.values);
  return setting;
}

}  // namespace subpixel::replay
