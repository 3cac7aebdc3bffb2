// `subpixel <verb>`: parses the command line, calls the library, turns its errors into exit codes.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <functional>
#include <new>
#include <string_view>

#include "capture_format/error.hpp"
#include "capture_format/printable.hpp"
#include "cli/capture_verbs.hpp"
#include "cli/import_verbs.hpp"
#include "cli/measure_verbs.hpp"
#include "cli/nightly_verbs.hpp"
#include "cli/replay_verbs.hpp"
#include "cli/service_verbs.hpp"

namespace {

// Names in messages are others': nothing of them may reach the terminal raw.
int report(std::string_view message, int code) {
  fmt::print(stderr, "subpixel: {}\n", subpixel::printable(message));
  return code;
}

int report(const std::exception& error, int code) {
  return report(std::string_view(error.what()), code);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Replays recorded frames through anti-aliased G-buffer techniques and measures them", "subpixel"};
  app.set_version_flag("--version", SUBPIXEL_VERSION);
  app.require_subcommand(1);
  std::function<int()> action;
  subpixel::cli::add_capture_verbs(app, action);
  subpixel::cli::add_import_verbs(app, action);
  subpixel::cli::add_replay_verbs(app, action);
  subpixel::cli::add_measure_verbs(app, action);
  subpixel::cli::add_service_verbs(app, action);
  subpixel::cli::add_nightly_verbs(app, action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    const bool unknown_verb = argc > 1 && app.get_subcommands().empty() && argv[1][0] != '-';
    return report(unknown_verb ? fmt::format("command line: '{}' is not a verb; --help lists them", argv[1])
                               : fmt::format("command line: {}", subpixel::joined_lines(error.what())),
                  2);
  }
  try {
    return action();
  } catch (const subpixel::UsageError& error) {
    return report(error, 2);
  } catch (const subpixel::InputError& error) {
    return report(error, 3);
  } catch (const subpixel::DeviceError& error) {
    return report(error, 4);
  } catch (const std::bad_alloc&) {
    return report("memory: there is not enough", 4);
  } catch (const std::exception& error) {
    return report(error, 3);
  }
}
