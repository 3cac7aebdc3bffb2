// What a technique is: one constant per file of replay/techniques, listed in its registry.cpp.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "replay/frame/frame_setup.hpp"

namespace subpixel::replay {

// One named part of a memory layout and its size. Bits, since published formats have fields of 1 to 26 bits.
struct LayoutEntry {
  std::string name;
  double bits_per_pixel = 0;
};

// The publication's format. What our own passes keep is measured (Memory).
using MemoryLayout = std::vector<LayoutEntry>;

// One map a technique can produce, with what its values mean.
struct MapDescription {
  std::string_view name, title, unit;
  double maximum = 0;  // value shown in the last colour; 0: the samples of the run
};

struct Technique;

// A technique with all of its parameters.
struct TechniqueSetting {
  const Technique* technique = nullptr;
  ParameterValues values;                              // as results and requests have them
  std::shared_ptr<const CommonParameters> parameters;  // the same, of the technique's own type
};

struct Technique {
  std::string_view name;   // registry name, "msaa"
  std::string_view title;  // for people
  std::string_view paper;  // citation, empty for baselines without one
  Parameters parameters;
  std::vector<MapDescription> maps;
  std::function<std::shared_ptr<const CommonParameters>(const ParameterValues& checked)> read;
  std::function<MemoryLayout(const FrameSetup&)> layout;
  std::function<void(gpu::PassRecorder&, const FrameSetup&)> record;
  // Whose passes go through lists of fragments: always, of what is visible, or where their order (OrderedParameters) is
  // by lists, with these masks.
  std::optional<ListedMasks> lists;
  // For frames drawn in bands of rows, nothing where they take no more than others: rows beside a pixel's own that its
  // values depend on; and why bands would leave or have left (counters) what the whole frame does not, empty if they
  // don't. `whole`: the frame's height, lists summed up.
  std::function<std::uint32_t(const CommonParameters&)> neighbour_rows;
  std::function<std::string(const FrameSetup& whole)> whole_only;

  // `given` (text or JSON scalars by name) and the defaults for the rest. Throws UsageError naming the valid
  // parameters, the range or the choices.
  TechniqueSetting with(const ParameterValues& given = {}) const;
};

// A technique as its file declares it: with parameters of type `P`.
template <typename P>
struct TechniqueOf {
  std::string_view name, title, paper;
  Fields<P> fields;
  std::vector<MapDescription> maps;
  std::function<MemoryLayout(const SetupFor<P>&)> layout;
  std::function<void(gpu::PassRecorder&, const SetupFor<P>&)> record;
  std::optional<ListedMasks> lists = {};
  std::function<std::uint32_t(const P&)> neighbour_rows = {};
  std::function<std::string(const SetupFor<P>& whole)> whole_only = {};

  operator Technique() const {
    return {name,
            title,
            paper,
            fields.description(),
            maps,
            [fields = fields](const ParameterValues& checked) -> std::shared_ptr<const CommonParameters> {
              return std::make_shared<P>(fields.read(checked));
            },
            [layout = layout](const FrameSetup& setup) { return layout(SetupFor<P>(setup)); },
            [record = record](gpu::PassRecorder& recorder, const FrameSetup& setup) {
              record(recorder, SetupFor<P>(setup));
            },
            lists,
            [rows = neighbour_rows](const CommonParameters& parameters) {
              return rows ? rows(dynamic_cast<const P&>(parameters)) : 0u;
            },
            [why = whole_only](const FrameSetup& whole) { return why ? why(SetupFor<P>(whole)) : std::string(); }};
  }
};

}  // namespace subpixel::replay
