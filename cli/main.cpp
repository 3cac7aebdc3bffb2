// `subpixel <verb>`: parses the command line, calls the library, turns its errors into exit codes.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <functional>
#include <string_view>

#include "base/failure.hpp"
#include "base/printable.hpp"
#include "cli/capture_tool_verbs.hpp"
#include "cli/capture_verbs.hpp"
#include "cli/import_verbs.hpp"
#include "cli/measure_verbs.hpp"
#include "cli/nightly_verbs.hpp"
#include "cli/replay_verbs.hpp"
#include "cli/service_verbs.hpp"
#include "cli/store_verbs.hpp"
#include "cli/story_verbs.hpp"
#include "cli/token_verbs.hpp"
#include "server/store/sqlite.hpp"

namespace {

// The store's own exception is not known where failure_of() lives.
subpixel::Failure failure(const std::exception_ptr& exception) {
  try {
    std::rethrow_exception(exception);
  } catch (const subpixel::server::SqliteError& error) {
    if (!error.is_ours()) return {subpixel::kInputExit, fmt::format("store: {}", error.what())};
  } catch (...) {
    // Falls through.
  }
  return subpixel::failure_of(exception);
}

// Names in messages are others': nothing of them may reach the terminal raw.
int report(std::string_view message, subpixel::ExitCode code) {
  fmt::print(stderr, "subpixel: {}\n", subpixel::printable(message));
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  // A write beyond a file-size limit is an error to report, as a full disk is.
  std::signal(SIGXFSZ, SIG_IGN);
  CLI::App app{"Replays recorded frames through anti-aliased G-buffer techniques and measures them", "subpixel"};
  app.set_version_flag("--version", SUBPIXEL_VERSION);
  app.require_subcommand(1);
  std::function<int()> action;
  subpixel::cli::add_capture_verbs(app, action);
  subpixel::cli::add_capture_tool_verbs(app, action);
  subpixel::cli::add_import_verbs(app, action);
  subpixel::cli::add_replay_verbs(app, action);
  subpixel::cli::add_story_verbs(app, action);
  subpixel::cli::add_measure_verbs(app, action);
  subpixel::cli::add_service_verbs(app, action);
  subpixel::cli::add_nightly_verbs(app, action);
  subpixel::cli::add_store_verbs(app, action);
  subpixel::cli::add_token_verbs(app, action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    const bool unknown_verb = argc > 1 && app.get_subcommands().empty() && argv[1][0] != '-';
    return report(unknown_verb ? fmt::format("command line: '{}' is not a verb; --help lists them", argv[1])
                               : fmt::format("command line: {}", subpixel::joined_lines(error.what())),
                  subpixel::kUsageExit);
  }
  try {
    return action();
  } catch (...) {
    const subpixel::Failure end = failure(std::current_exception());
    return report(end.message, end.exit_code);
  }
}
