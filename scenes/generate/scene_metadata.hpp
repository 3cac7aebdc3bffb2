// What every generated capture says of itself.
#pragma once

#include <string>

#include "capture_format/capture.hpp"
#include "scenes/generate/generate.hpp"

namespace subpixel::capture {

inline Metadata generated_metadata(const std::string& scene, const GenerateOptions& options) {
  Metadata metadata;
  metadata.title = scene;
  metadata.application = "subpixel generate " + scene + ", seed " + std::to_string(options.seed);
  metadata.tool = "subpixel generator 1";  // counts up when a scene's content changes
  metadata.licence = "CC0-1.0";
  return metadata;
}

}  // namespace subpixel::capture
