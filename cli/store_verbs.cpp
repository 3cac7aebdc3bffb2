#include "cli/store_verbs.hpp"

#include <fmt/format.h>

#include <memory>
#include <string>

#include "base/json_text.hpp"
#include "base/printable.hpp"
#include "replay/reference/reference_cache.hpp"
#include "server/store/upkeep.hpp"

namespace subpixel::cli {
namespace {

using server::DataFolder;

struct StoreArguments {
  std::string data = "subpixel-data", target;
  server::Retention retention;
  bool as_json = false, dry = false, compact = false;
  std::optional<std::uint64_t> outside;  // blobs from this size on; 0: none
};

bool cache_is_whole(const std::filesystem::path& file) {
  return replay::ReferenceCache(file.parent_path()).load(file.stem().string()).has_value();
}

int check(const StoreArguments& arguments) {
  const DataFolder folder(arguments.data, DataFolder::Claim::reader);
  const server::CheckReport report = server::check_data(folder, &cache_is_whole);
  if (arguments.as_json) {
    fmt::print("{}\n", json_text({{"whole", report.damage.empty()},
                                  {"damage", report.damage},
                                  {"leftover", report.leftover},
                                  {"captures", report.captures},
                                  {"runs", report.runs},
                                  {"nights", report.nights},
                                  {"blobs", report.blobs},
                                  {"outside", report.outside},
                                  {"cached", report.cached}},
                                 1));
  } else {
    for (const std::string& line : report.damage) fmt::print("damage: {}\n", printable(line));
    for (const std::string& line : report.leftover) fmt::print("leftover: {}\n", printable(line));
    fmt::print("{} captures, {} runs, {} nights, {} blobs, {} of them in files, {} cached references: {}\n",
               report.captures, report.runs, report.nights, report.blobs, report.outside, report.cached,
               report.damage.empty() ? "whole" : fmt::format("{} damaged", report.damage.size()));
  }
  return report.damage.empty() ? 0 : 1;
}

int backup(const StoreArguments& arguments) {
  const DataFolder folder(arguments.data, DataFolder::Claim::reader);
  const server::BackupReport report = server::back_up(folder, arguments.target);
  fmt::print("{} captures, {} bytes: {}\n", report.captures, report.bytes, printable(arguments.target));
  return 0;
}

int collect_garbage(const StoreArguments& arguments) {
  const DataFolder folder(arguments.data, arguments.compact ? DataFolder::Claim::upkeep : DataFolder::Claim::reader);
  server::Freed freed;
  {
    server::Store store(folder.store());
    freed = server::collect_garbage(folder, store, arguments.retention, arguments.dry, &cache_is_whole);
  }
  const std::uint64_t compacted = arguments.compact && !arguments.dry ? server::compact(folder) : 0;
  if (arguments.as_json) {
    fmt::print("{}\n", json_text({{"dry_run", arguments.dry},
                                  {"runs", freed.runs},
                                  {"nights", freed.nights},
                                  {"captures", freed.captures},
                                  {"blobs", freed.blobs},
                                  {"files", freed.files},
                                  {"store_bytes", freed.store_bytes},
                                  {"file_bytes", freed.file_bytes},
                                  {"compacted_bytes", compacted}},
                                 1));
    return 0;
  }
  fmt::print("{}{} runs, {} nights, {} captures, {} blobs, {} files; {} bytes of the store, {} of files\n",
             arguments.dry ? "would delete " : "deleted ", freed.runs, freed.nights, freed.captures, freed.blobs,
             freed.files, freed.store_bytes, freed.file_bytes);
  if (arguments.compact && !arguments.dry) fmt::print("the store's file is {} bytes shorter\n", compacted);
  return 0;
}

int migrate(const StoreArguments& arguments) {
  const DataFolder folder(arguments.data, DataFolder::Claim::upkeep);
  const server::MigrationReport report = server::migrate_data(folder);
  if (report.kept.empty()) {
    fmt::print("version {}: nothing to do\n", report.to);
  } else {
    fmt::print("version {} to {}; as it was: {}\n", report.from, report.to, printable(report.kept.string()));
  }
  if (arguments.outside) {
    const server::Moved moved =
        server::place_blobs(folder, *arguments.outside > 0 ? std::optional(*arguments.outside) : std::nullopt);
    fmt::print("{} blobs moved to files, {} back, {} bytes; the store's file gets shorter by gc --compact\n", moved.out,
               moved.in, moved.bytes);
  }
  return 0;
}

}  // namespace

void add_store_verbs(CLI::App& app, std::function<int()>& action) {
  const auto arguments = std::make_shared<StoreArguments>();
  CLI::App* const verb = app.add_subcommand("store", "Check, back up, clean or migrate a data folder");
  verb->require_subcommand(1);
  const auto add = [&](const char* name, const char* description, int (*run)(const StoreArguments&)) {
    CLI::App* const part = verb->add_subcommand(name, description);
    part->add_option("--data", arguments->data, "Data folder")->capture_default_str();
    part->callback([arguments, run, &action] { action = [arguments, run] { return run(*arguments); }; });
    return part;
  };
  add("check", "Read all of it and compare; exit code 1 when something is damaged, also beside a service", &check)
      ->add_flag("--json", arguments->as_json, "Print one JSON document");
  add("backup", "Copy store and captures to a new folder, also beside a service", &backup)
      ->add_option("target", arguments->target, "Folder to make; a data folder then")
      ->required();
  CLI::App* const gc = add("gc", "Delete what need not stay, also beside a service; never nights that a baseline names",
                           &collect_garbage);
  gc->add_option("--keep-days", arguments->retention.days, "Keep runs and nights that ended in the last N days");
  gc->add_option("--keep-count", arguments->retention.count,
                 "Keep the newest N runs of each capture and N nights of each name; with --keep-days either will do");
  gc->add_flag("--captures", arguments->retention.captures,
               "Also delete captures older than --keep-days without a tag, a run or a night");
  gc->add_option("--cache-days", arguments->retention.cache_days,
                 "Delete references that were computed more than N days ago");
  gc->add_flag("--dry-run", arguments->dry, "Only say what would be deleted");
  gc->add_flag("--compact", arguments->compact, "Also make the store's file shorter; no service may run");
  gc->add_flag("--json", arguments->as_json, "Print one JSON document");
  add("migrate", "Take the store to this program's version and keep it as it was beside it; no service may run",
      &migrate)
      ->add_option("--blobs-outside", arguments->outside,
                   "Keep blobs of so many bytes and more in files of their own, those that are stored too; 0: none");
}

}  // namespace subpixel::cli
