// `subpixel store`: what it finds, copies, deletes and migrates.
#include <sys/wait.h>

#include <atomic>
#include <cstdio>
#include <fstream>
#include <functional>

#include "base/error.hpp"
#include "server/nightly/night_store.hpp"
#include "server/store/store_access.hpp"
#include "server/store/upkeep.hpp"
#include "tests/service/store_workload.hpp"

namespace subpixel::tests {
namespace {

namespace fs = std::filesystem;
using server::CheckReport;
using server::DataFolder;
using server::Retention;
using server::Store;

bool any_cached(const fs::path& file) {
  return file.extension() != ".damaged";
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

class Upkeep : public ServiceTest {
 protected:
  fs::path data() const { return folder() / "data"; }
  fs::path store_file() const { return data() / "subpixel.sqlite"; }

  CheckReport check() const { return check_in(data()); }
  static CheckReport check_in(const fs::path& where) {
    return server::check_data(DataFolder(where, DataFolder::Claim::reader), &any_cached);
  }
  server::Freed collect(const Retention& retention, bool dry = false) const {
    const DataFolder claimed(data(), DataFolder::Claim::reader);
    Store store(claimed.store());
    return server::collect_garbage(claimed, store, retention, dry, &any_cached);
  }
  void change(const std::string& sql) const {
    const server::Connection connection(store_file());
    connection.execute("PRAGMA foreign_keys = OFF");
    connection.execute(sql);
  }
  std::int64_t number(const std::string& sql) const {
    const server::Connection connection(store_file());
    server::Statement select(connection, sql);
    return select.step() ? select.integer() : -1;
  }
  // Makes a file old enough not to belong to something that is under way.
  static void age(const fs::path& file, int days) {
    fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::days(days) - std::chrono::hours(2));
  }

  // Exit code and what was printed, standard error included.
  static std::pair<int, std::string> subpixel(const std::string& arguments) {
    FILE* const pipe = ::popen((std::string(SUBPIXEL_BINARY) + " " + arguments + " 2>&1").c_str(), "r");
    std::string text;
    for (int c; (c = std::fgetc(pipe)) != EOF;) text += static_cast<char>(c);
    const int status = ::pclose(pipe);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text};
  }

  // A finished run of a capture, and that capture.
  std::pair<std::string, std::int64_t> measured(int frames) {
    const std::string hash = client().upload_fake({{"frames", frames}});
    const std::int64_t run = client().start_run(hash);
    EXPECT_EQ(client().wait_for_end(run).at("status"), "done");
    wait_for_thumbnails();
    return {hash, run};
  }
  void wait_for_thumbnails() {
    for (int i = 0; i < 500; ++i) {
      const json health = client().get("/api/health");
      if (health.at("queued") == 0 && health.at("running") == 0) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  std::int64_t night(Store& store, const std::string& name, int day, std::optional<std::int64_t> baseline) const {
    server::NightStore nights(store);
    server::NightRecord record;
    record.name = name;
    record.config = json::object();
    record.baseline_night = baseline;
    const std::int64_t id = nights.add(record);
    nights.add_capture(id, 0, {.name = "one", .source = "path", .hash = std::string(32, 'e'), .problem = ""});
    server::NightCell cell;
    cell.technique = "noaa";
    const std::int64_t cell_id = nights.add_cell(id, cell);
    nights.add_frame(cell_id, stored_result(0, "noaa"), {{"image", stored_image(1000, static_cast<int>(id))}});
    nights.finish(id, server::NightStatus::passed, "");
    change("UPDATE nights SET finished_utc = '2025-01-0" + std::to_string(day) +
           "T00:00:00.000Z' WHERE id = " + std::to_string(id));
    return id;
  }
};

TEST_F(Upkeep, CheckOfAServiceThatRunsFindsNothing) {
  measured(2);
  const CheckReport report = check();
  EXPECT_EQ(joined(report.damage), "");
  EXPECT_EQ(joined(report.leftover), "");
  EXPECT_EQ(report.captures, 1u);
  EXPECT_EQ(report.runs, 2u) << "with the thumbnail's";
  EXPECT_GT(report.blobs, 4u);
  const auto [code, text] = subpixel("store check --json --data " + data().string());
  EXPECT_EQ(code, 0) << text;
  EXPECT_EQ(json::parse(text).at("whole"), true);
}

TEST_F(Upkeep, CheckNamesWhatIsDamaged) {
  const std::string hash = measured(1).first;
  const std::string capture = (data() / "captures" / (hash + ".spcap")).string();
  stop();
  const fs::path healthy = folder() / "healthy";
  fs::copy(data(), healthy, fs::copy_options::recursive);
  const auto damage_after = [&](const std::function<void()>& harm) {
    harm_a_copy(healthy, data(), harm);
    return joined(check().damage);
  };
  EXPECT_EQ(damage_after([] {}), "");
  const auto expect = [&](const std::string& words, const std::function<void()>& harm) {
    const std::string found = damage_after(harm);
    EXPECT_NE(found.find(words), std::string::npos) << words << " is not in: " << found;
  };
  const auto sql = [&](const std::string& text) { return [this, text] { change(text); }; };
  expect("its bytes have another hash",
         sql("UPDATE blobs SET bytes = zeroblob(length(bytes)) WHERE rowid = (SELECT max(rowid) FROM blobs)"));
  expect("names a row that is not there", sql("DELETE FROM blobs WHERE rowid = (SELECT max(rowid) FROM blobs)"));
  expect("names an image that is not stored with it", sql("DELETE FROM images WHERE role = 'image'"));
  expect("that does not name it",
         sql("UPDATE frame_results SET document = json_remove(document, '$.images.image') WHERE sequence = 1"));
  expect("is no JSON", sql("UPDATE frame_results SET document = substr(document, 2)"));
  expect("not as many", sql("UPDATE runs SET expected_results = 5"));
  expect("another size: " + capture, [&] { std::ofstream(capture, std::ios::app) << "more"; });
  expect("another hash: " + capture, [&] {
    std::fstream file(capture, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(2) << 'x';
  });
  expect("can't be read", [&] { fs::remove(capture); });
  expect("the store's pages", [&] {
    std::fstream file(store_file(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(3 * 4096) << std::string(4096, 'x');
  });
  const auto [code, text] = subpixel("store check --data " + data().string());
  EXPECT_EQ(code, 1) << text;
  EXPECT_NE(text.find("damage: "), std::string::npos) << text;
}

TEST_F(Upkeep, LeftoversAreNamedAndCollected) {
  measured(1);
  const server::Blob unnamed{"image/png", "nobody's"};
  {
    Store store(store_file());
    const Store::WriteLease writer = store.write();
    store.store_blob(writer.connection(), unnamed);
  }
  const fs::path orphan = data() / "captures" / (std::string(32, 'c') + ".spcap"), fresh = data() / "captures" / "new";
  const fs::path cached = data() / "cache" / "a.spref", damaged = data() / "cache" / "b.damaged";
  for (const fs::path& file : {orphan, fresh, cached, damaged}) {
    std::ofstream(file) << "12345";
    if (file != fresh) age(file, 3);
  }
  fs::create_directories(data() / "cache" / "mesa" / "shaders");  // the driver's
  age(data() / "cache" / "mesa", 3);
  EXPECT_EQ(check().leftover.size(), 4u) << joined(check().leftover);

  const server::Freed would = collect({}, true);
  EXPECT_EQ(would.files, 2u);
  EXPECT_EQ(would.blobs, 1u);
  EXPECT_TRUE(fs::exists(orphan));
  const server::Freed freed = collect({});
  EXPECT_EQ(freed.runs + freed.nights + freed.captures, 0u) << "without a rule all of them stay";
  EXPECT_EQ(freed.files, 2u);
  EXPECT_EQ(freed.file_bytes, 10u);
  EXPECT_EQ(freed.blobs, 1u);
  EXPECT_FALSE(fs::exists(orphan) || fs::exists(damaged));
  EXPECT_TRUE(fs::exists(fresh)) << "it may be an upload under way";
  EXPECT_TRUE(fs::exists(cached));
  EXPECT_EQ(joined(check().damage), "");
  EXPECT_EQ(collect({.cache_days = 5}).files, 0u);
  EXPECT_EQ(collect({.cache_days = 2}).files, 1u);
}

TEST_F(Upkeep, RunsStayByAgeOrCount) {
  const std::string hash = measured(1).first;
  for (int i = 0; i < 3; ++i) client().wait_for_end(client().start_run(hash));
  change("UPDATE runs SET finished_utc = '2025-01-01T00:00:00.000Z' WHERE kind = 'run' AND id <= 4");
  ASSERT_EQ(number("SELECT count(*) FROM runs WHERE kind = 'run'"), 4);
  EXPECT_EQ(collect({.days = 10, .count = 3}, true).runs, 1u);
  EXPECT_EQ(collect({.count = 1}, true).runs, 3u);
  EXPECT_EQ(collect({.days = 10}, true).runs, 3u);
  const std::int64_t bytes = number("SELECT sum(length(bytes)) FROM blobs");
  const server::Freed freed = collect({.days = 10, .count = 2});
  EXPECT_EQ(freed.runs, 2u);
  EXPECT_EQ(number("SELECT count(*) FROM runs WHERE kind = 'run'"), 2);
  EXPECT_EQ(number("SELECT coalesce(sum(length(bytes)), 0) FROM blobs"),
            bytes - static_cast<std::int64_t>(freed.store_bytes));
  EXPECT_EQ(joined(check().damage), "");
  EXPECT_EQ(joined(check().leftover), "");
  EXPECT_EQ(client().get("/api/captures").at("total"), 1);
}

TEST_F(Upkeep, RunsThatHaveNotEndedStay) {
  const std::string hash = client().upload_fake({{"frames", 1}, {"result_ms", 60'000}});
  const std::int64_t run = client().start_run(hash);
  client().start_run(hash);
  while (client().get("/api/runs/" + std::to_string(run)).at("status") != "running") {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  change("UPDATE runs SET created_utc = '2025-01-01', started_utc = '2025-01-01' WHERE kind = 'run'");
  change("UPDATE captures SET uploaded_utc = '2025-01-01'");
  const server::Freed freed = collect({.days = 1, .count = 0, .captures = true});
  EXPECT_EQ(number("SELECT count(*) FROM runs WHERE kind = 'run'"), 2);
  EXPECT_EQ(freed.captures, 0u);
}

TEST_F(Upkeep, BaselinesAndWhatNightsWereComparedWithStay) {
  client();
  Store store(store_file());
  const std::int64_t grandparent = night(store, "a", 1, std::nullopt);
  const std::int64_t parent = night(store, "a", 2, grandparent);
  const std::int64_t approved = night(store, "a", 3, std::nullopt);
  const std::int64_t forgotten = night(store, "a", 4, approved);
  const std::int64_t newest = night(store, "a", 5, parent);
  const std::int64_t other = night(store, "b", 1, std::nullopt);
  ASSERT_TRUE(server::NightStore(store).set_baseline("base", approved));
  const server::Freed freed = collect({.days = 1, .count = 1});
  EXPECT_EQ(freed.nights, 1u);
  EXPECT_EQ(freed.blobs, 1u);
  for (const std::int64_t kept : {grandparent, parent, approved, newest, other}) {
    EXPECT_TRUE(server::NightStore(store).night(kept, true)) << kept;
  }
  EXPECT_FALSE(server::NightStore(store).night(forgotten, false));
  EXPECT_EQ(collect({.days = 0, .count = 0}).nights, 4u);
  EXPECT_TRUE(server::NightStore(store).night(approved, true));
  EXPECT_EQ(joined(check().damage), "");
}

TEST_F(Upkeep, CapturesGoOnlyWhenNobodyNeedsThem) {
  const auto [with_run, run] = measured(1);
  const std::string tagged = client().upload_fake({{"frames", 2}}), free = client().upload_fake({{"frames", 3}});
  const std::string in_night = client().upload_fake({{"frames", 4}});
  wait_for_thumbnails();
  client().http().Post("/api/captures/" + tagged + "/tags", R"({"tags":["nightly"]})", "application/json");
  Store store(store_file());
  ASSERT_TRUE(server::NightStore(store).set_baseline("base", night(store, "a", 1, std::nullopt)));
  change("UPDATE night_captures SET hash = '" + in_night + "'");
  EXPECT_EQ(collect({.days = 5, .captures = true}, true).captures, 0u);
  change("UPDATE captures SET uploaded_utc = '2025-01-01T00:00:00.000Z'");
  EXPECT_THROW(collect({.captures = true}), UsageError);
  const server::Freed freed = collect({.days = 5, .captures = true});
  EXPECT_EQ(freed.captures, 1u);
  EXPECT_EQ(freed.files, 1u);
  EXPECT_FALSE(fs::exists(data() / "captures" / (free + ".spcap")));
  for (const std::string& hash : {with_run, tagged, in_night}) client().get("/api/captures/" + hash);
  EXPECT_EQ(client().upload_fake({{"frames", 3}}), free) << "it can be sent again";
  EXPECT_EQ(joined(check().damage), "");
}

TEST_F(Upkeep, CompactGivesRoomBackWhenNobodyElseIsThere) {
  measured(20);
  EXPECT_EQ(subpixel("store gc --compact --keep-count 0 --data " + data().string()).first, 3) << "a service runs";
  stop();
  const auto before = fs::file_size(store_file());
  const auto [code, text] = subpixel("store gc --compact --keep-count 0 --json --data " + data().string());
  ASSERT_EQ(code, 0) << text;
  const json freed = json::parse(text);
  EXPECT_GT(freed.at("store_bytes"), 10'000);
  EXPECT_EQ(before - fs::file_size(store_file()), freed.at("compacted_bytes"));
  EXPECT_GT(freed.at("compacted_bytes"), 10'000);
  EXPECT_EQ(joined(check().damage), "");
}

// While captures come and go and a run stores its results.
TEST_F(Upkeep, BackupOfARunningServiceIsRestored) {
  const auto [hash, run] = measured(2);
  const std::int64_t running =
      client().start_run(client().upload_fake({{"frames", 100}, {"result_ms", 5}, {"title", "busy"}}));
  std::atomic<bool> stop_it{false};
  std::thread changes([&] {
    Client mine(port());
    for (int i = 10; !stop_it; ++i) {
      const std::string each = mine.upload_fake({{"frames", 0}, {"title", std::to_string(i)}});
      if (i % 2 == 0) mine.http().Delete("/api/captures/" + each);
    }
  });
  std::vector<fs::path> backups;
  for (int i = 0; i < 5; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(60));
    backups.push_back(folder() / ("backup" + std::to_string(i)));
    const auto [code, text] = subpixel("store backup --data " + data().string() + " " + backups.back().string());
    EXPECT_EQ(code, 0) << text;
  }
  stop_it = true;
  changes.join();
  EXPECT_EQ(subpixel("store backup --data " + data().string() + " " + backups[0].string()).first, 3)
      << "nothing is overwritten";
  const json results = client().get("/api/runs/" + std::to_string(run) + "/results.json");
  const json capture = client().get("/api/captures/" + hash);
  client().wait_for_end(running);
  for (const fs::path& backup : backups) {
    SCOPED_TRACE(backup.filename());
    const CheckReport report = check_in(backup);
    EXPECT_EQ(joined(report.damage), "");
    EXPECT_EQ(joined(report.leftover), "");
    EXPECT_GE(report.captures, 2u);
    server::ServiceOptions restored = options();
    restored.data = backup;
    start(restored);
    EXPECT_EQ(client().get("/api/runs/" + std::to_string(run) + "/results.json"), results);
    EXPECT_EQ(client().get("/api/captures/" + hash), capture);
    EXPECT_EQ(client().http().Get("/api/captures/" + hash + "/file")->body.size(), capture.at("size_bytes"));
    EXPECT_EQ(client().wait_for_end(running).at("status"), "done") << "it goes on where the backup was made";
  }
}

TEST_F(Upkeep, BackupWithoutRoomLeavesNothing) {
  measured(1);
  const auto [code, text] = subpixel("store backup --data " + data().string() + " /proc/no-such-place/backup");
  EXPECT_EQ(code, 3) << text;
  fs::remove(data() / "captures" /
             (client().get("/api/captures").at("captures").at(0).at("hash").get<std::string>() + ".spcap"));
  const auto [code_2, text_2] = subpixel("store backup --data " + data().string() + " " + (folder() / "b").string());
  EXPECT_EQ(code_2, 3) << text_2;
  EXPECT_NE(text_2.find("a capture's file is missing"), std::string::npos) << text_2;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder())) EXPECT_EQ(entry.path(), data());
}

// tests/service/stores has a store of each version there has been, made when it was the newest, with a capture, a run
// and its results, and from version 2 on a night that a baseline names.
TEST_F(Upkeep, EveryVersionIsMigrated) {
  for (std::int64_t version = 1; version <= server::newest_schema_version(); ++version) {
    SCOPED_TRACE(version);
    const fs::path original =
        fs::path(SUBPIXEL_SOURCE_DIR) / "tests/service/stores" / ("version" + std::to_string(version) + ".sqlite");
    ASSERT_TRUE(fs::exists(original)) << "a new version needs its store: see make_store.py beside them";
    EXPECT_LT(fs::file_size(original), 100'000u);
    const fs::path where = folder() / std::to_string(version), file = where / "subpixel.sqlite";
    fs::create_directories(where / "captures");
    fs::copy_file(original, file);
    const std::string capture = "FAKE {}\n";
    std::ofstream(where / "captures" / "415a9540535a3216e67f43fa093e37bd.spcap") << capture;
    const bool old = version < server::newest_schema_version();
    if (old) {
      EXPECT_THROW(check_in(where), InputError) << "a check changes nothing";
    }
    const auto [code, text] = subpixel("store migrate --data " + where.string());
    EXPECT_EQ(code, 0) << text;
    const fs::path kept = where / ("subpixel.version" + std::to_string(version) + ".sqlite");
    EXPECT_EQ(fs::exists(kept), old);
    if (old) {
      EXPECT_EQ(server::schema_version(server::Connection(kept)), version);
    }
    EXPECT_EQ(subpixel("store migrate --data " + where.string()).second.find("nothing to do") != std::string::npos,
              true);
    EXPECT_EQ(joined(check_in(where).damage), "");
    Store store(file);
    EXPECT_EQ(server::schema_version(server::Connection(file)), server::newest_schema_version());
    ASSERT_EQ(store.captures(10, 0).size(), 1u);
    EXPECT_EQ(store.captures(10, 0)[0].title, "Kept");
    const std::optional<server::RunRecord> run = store.run(1);
    ASSERT_TRUE(run);
    EXPECT_EQ(run->status, server::RunStatus::done);
    ASSERT_EQ(store.results(1).size(), 1u);
    const std::string image = store.results(1)[0].document.at("images").at("image");
    EXPECT_EQ(store.blob(image).value().bytes, "pixels");
    const server::NightStore nights(store);
    EXPECT_EQ(nights.baselines().size(), version >= 2 ? 1u : 0u);
    if (version >= 2) {
      EXPECT_EQ(nights.night(nights.baselines()[0].night, true).value().cells.size(), 1u);
      EXPECT_EQ(store.captures_with_tag("nightly").size(), 1u);
    }
  }
}

TEST_F(Upkeep, NewerVersionIsRefusedByItsNumber) {
  { const DataFolder made(data()); }
  { const Store store(store_file()); }
  change("PRAGMA user_version = 999");
  for (const char* const verb : {"check", "migrate", "gc"}) {
    const auto [code, text] = subpixel("store " + std::string(verb) + " --data " + data().string());
    EXPECT_EQ(code, 3) << text;
    EXPECT_NE(text.find("its version is 999, this program knows up to"), std::string::npos) << text;
  }
}

TEST_F(Upkeep, MigrationNeedsTheFolderForItself) {
  client();
  const auto [code, text] = subpixel("store migrate --data " + data().string());
  EXPECT_EQ(code, 3) << text;
  EXPECT_NE(text.find("a service holds it"), std::string::npos) << text;
}

}  // namespace
}  // namespace subpixel::tests
