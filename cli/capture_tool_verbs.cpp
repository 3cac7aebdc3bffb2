#include "cli/capture_tool_verbs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include "base/error.hpp"
#include "base/json_text.hpp"
#include "base/printable.hpp"
#include "capture_format/limits.hpp"
#include "capture_format/reading/capture_file.hpp"
#include "capture_format/streams.hpp"
#include "capture_format/tools/difference.hpp"
#include "capture_format/tools/trim.hpp"
#include "capture_format/writer.hpp"
#include "cli/option_values.hpp"
#include "cli/written_summary.hpp"

namespace subpixel::cli {
namespace {

using Frames = std::pair<std::uint32_t, std::uint32_t>;

// What --frames says of the file, or all of its frames.
Frames frames_of(const capture::CaptureFile& file, const std::string& text, const std::string& path) {
  if (file.frame_count() == 0) throw InputError(path, "it has no frames", "");
  const auto last = static_cast<std::uint32_t>(file.frame_count() - 1);
  if (text.empty()) return {0, last};
  const Frames frames = parse_frames(text);
  if (frames.first > frames.second || frames.second > last) {
    throw UsageError("frames", fmt::format("{}-{} is not within 0-{} of {}", frames.first, frames.second, last, path),
                     "--frames");
  }
  return frames;
}

struct TrimArguments {
  std::string in, out, frames, keep, drop;
};

int trim(const TrimArguments& arguments) {
  const capture::CaptureFile file(arguments.in);
  capture::TrimOptions options;
  const Frames frames = frames_of(file, arguments.frames, arguments.in);
  if (!arguments.frames.empty()) options.frames = frames;
  if (!arguments.keep.empty()) options.keep = arguments.keep;
  if (!arguments.drop.empty()) options.drop = arguments.drop;
  capture::Capture trimmed =
      capture::trim(file.load(frames.first, frames.second, capture::CaptureFile::Triangles::as_stored), options);
  const std::uint64_t bytes_before = std::filesystem::file_size(arguments.in);
  capture::write_capture(trimmed, arguments.out);
  capture::make_triangle_lists(trimmed, capture::ReadLimits{}.decoded_bytes);  // to count what is drawn
  fmt::print("{}: {}\n{}; before: {} frames, {:.1f} MB\n", printable(arguments.out),
             written_summary(trimmed, arguments.out), printable(trimmed.metadata.notices.back()), file.frame_count(),
             static_cast<double>(bytes_before) * 1e-6);
  if (!std::filesystem::is_regular_file(arguments.out)) return 0;
  const std::uint64_t bytes_after = std::filesystem::file_size(arguments.out);
  if (bytes_after >= bytes_before) {
    fmt::print("no smaller than before: {} bytes, {} before\n", bytes_after, bytes_before);
  }
  return 0;
}

void add_trim(CLI::App& app, std::function<int()>& action) {
  const auto arguments = std::make_shared<TrimArguments>();
  CLI::App* const verb = app.add_subcommand("trim", "Write some frames and draws of a capture as one of its own");
  verb->add_option("in", arguments->in, "Capture")->required();
  verb->add_option("out", arguments->out, "Capture to write")->required();
  verb->add_option("--frames", arguments->frames, "FIRST-LAST or one frame; default: all");
  const char* const kList = "numbers (12, 3-7) and names (* and ? stand for anything), separated by commas";
  CLI::Option* const keep =
      verb->add_option("--draws", arguments->keep, fmt::format("Draws to keep: {}; default: all", kList));
  verb->add_option("--without", arguments->drop, "Draws to leave out, as --draws")->excludes(keep);
  verb->callback([arguments, &action] { action = [arguments] { return trim(*arguments); }; });
}

struct DiffArguments {
  std::string a, b, frames;
  bool json = false;
};

int diff(const DiffArguments& arguments) {
  const capture::CaptureFile a(arguments.a), b(arguments.b);
  nlohmann::json found;
  if (arguments.frames.empty()) {
    // Captures without frames are compared, too.
    const auto load = [](const capture::CaptureFile& file) {
      return file.load(0, std::max<std::size_t>(file.frame_count(), 1) - 1);
    };
    found = capture::difference(load(a), load(b));
  } else {
    const Frames frames = frames_of(a, arguments.frames, arguments.a);
    frames_of(b, arguments.frames, arguments.b);
    found = capture::difference(a.load(frames.first, frames.second), b.load(frames.first, frames.second), frames);
  }
  if (arguments.json) {
    fmt::print("{}\n", json_text(found, 2));
  } else {
    fmt::print("{}", capture::difference_text(found));
  }
  return found["same"].get<bool>() ? 0 : 1;
}

void add_diff(CLI::App& app, std::function<int()>& action) {
  const auto arguments = std::make_shared<DiffArguments>();
  CLI::App* const verb = app.add_subcommand(
      "diff", "Say what differs between two captures, draw by draw; exit code 1 when something does");
  verb->add_option("a", arguments->a, "Capture")->required();
  verb->add_option("b", arguments->b, "Capture it is compared with")->required();
  verb->add_option("--frames", arguments->frames, "FIRST-LAST or one frame, of both; default: all");
  verb->add_flag("--json", arguments->json, "Print one JSON document");
  verb->callback([arguments, &action] { action = [arguments] { return diff(*arguments); }; });
}

}  // namespace

void add_capture_tool_verbs(CLI::App& app, std::function<int()>& action) {
  add_trim(app, action);
  add_diff(app, action);
}

}  // namespace subpixel::cli
