#include "cli/story_verbs.hpp"

#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>

#include "base/json_text.hpp"
#include "cli/option_values.hpp"
#include "process/confinement.hpp"
#include "replay/story.hpp"

namespace subpixel::cli {
namespace {

struct StoryFlags {
  replay::StoryJob job;
  std::string file, techniques, at, size, device;
  bool as_json = false;
};

int tell(const StoryFlags& flags) {
  replay::StoryJob job = flags.job;
  job.capture = flags.file;
  job.techniques = replay::parse_technique_list(flags.techniques);
  std::tie(job.x, job.y) = parse_pixel(flags.at);
  if (!flags.size.empty()) std::tie(job.width, job.height) = replay::parse_size(flags.size, "--size");
  forbid_programs();  // the service runs this for captures of others
  const nlohmann::json story = replay::tell_pixel(job, flags.device);
  std::cout << (flags.as_json ? json_text(story, 1) + "\n" : replay::story_text(story));
  return 0;
}

}  // namespace

void add_story_verbs(CLI::App& app, std::function<int()>& action) {
  CLI::App* const verb = app.add_subcommand("pixel", "Tell what techniques and the reference make of one pixel");
  const auto flags = std::make_shared<StoryFlags>();
  verb->add_option("file", flags->file, "The capture (.spcap)")->required();
  verb->add_option("--technique", flags->techniques, "a,b:param=v,...; msaa is told beside them")->required();
  verb->add_option("--at", flags->at, "The pixel, X,Y from the top left corner, from 0")->required();
  verb->add_option("--frame", flags->job.frame, "Its frame, from 0")->capture_default_str();
  verb->add_option("--size", flags->size, "WIDTHxHEIGHT of the image; as recorded when absent");
  verb->add_option("--samples", flags->job.samples, "Samples per pixel of techniques that don't name theirs")
      ->transform(within(replay::kSamplesLimit))
      ->capture_default_str();
  verb->add_option("--reference-samples", flags->job.reference_samples, "Visibility samples of the reference; 0: none")
      ->transform(within(replay::kReferenceSamplesLimit))
      ->capture_default_str();
  verb->add_option("--lights", flags->job.point_lights, "Point lights: this many; as recorded when absent")
      ->transform(within(replay::kPointLightsLimit));
  verb->add_option("--device", flags->device, "As of replay");
  verb->add_flag("--json", flags->as_json, "Print the story as one JSON document");
  verb->callback([&action, flags] { action = [flags] { return tell(*flags); }; });
}

}  // namespace subpixel::cli
