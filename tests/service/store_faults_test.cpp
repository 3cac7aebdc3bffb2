// Nothing that was committed is lost: power failures at any moment, and errors of the disk at every call.
#include <gtest/gtest.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "server/store/upkeep.hpp"
#include "tests/service/disk_calls.hpp"
#include "tests/service/faulty_vfs.hpp"
#include "tests/service/store_workload.hpp"

namespace subpixel::tests {
namespace {

namespace fs = std::filesystem;
using server::SqliteError;
using server::Store;

void expect_whole(const fs::path& file) {
  const server::Connection connection(file);
  for (const char* const check : {"PRAGMA integrity_check", "PRAGMA foreign_key_check"}) {
    server::Statement lines(connection, check);
    while (lines.step()) ASSERT_EQ(lines.text(), "ok") << check;
  }
}

// Cuts the power before every event of a whole life of a store that matters, and looks at what is left.
TEST(PowerFailure, LeavesAllThatWasCommittedAndNothingTorn) {
  const TemporaryFolder folder;
  const fs::path live = folder.path() / "subpixel.sqlite";
  std::vector<std::string> states;  // [i]: after i steps
  std::vector<FaultyVfs::Event> events;
  {
    FaultyVfs vfs;
    vfs.record();
    {
      Store store(live);
      vfs.mark(0);
      states.push_back(contents(live));
      // Large enough for checkpoints in between.
      for (const auto& step : store_workload(700'000)) {
        step(store);
        vfs.mark(static_cast<std::int64_t>(states.size()));
        states.push_back(contents(live));
      }
    }
    events = vfs.events();
  }
  const auto checkpoint_writes = std::ranges::count_if(events, [&](const FaultyVfs::Event& event) {
    return event.kind == FaultyVfs::Event::Kind::write && event.path == live.string();
  });
  EXPECT_GT(checkpoint_writes, 200) << "the log must have been written back";

  std::mt19937 random(7);
  Disk disk;
  std::int64_t committed = -1;
  int failures = 0, surviving = 0;
  bool cut_next = true;
  for (std::size_t i = 0; i <= events.size(); ++i) {
    using Kind = FaultyVfs::Event::Kind;
    const bool matters = i == events.size() || events[i].kind != Kind::write;
    if (matters || cut_next || random() % 40 == 0) {
      for (const bool strict : {true, false}) {
        const fs::path after = folder.path() / "after";
        fs::create_directories(after);
        for (const auto& [path, bytes] : disk.after_power_failure(strict ? nullptr : &random)) {
          std::ofstream(after / fs::path(path).filename(), std::ios::binary) << bytes;
        }
        const fs::path store = after / "subpixel.sqlite";
        { const Store reopened(store); }
        const std::string state = contents(store);
        const auto last = static_cast<std::size_t>(std::max<std::int64_t>(committed, 0));
        const bool may_be_next = last + 1 < states.size() && state == states[last + 1];
        ASSERT_TRUE(state == states[last] || may_be_next)
            << (strict ? "nothing unsynced" : "some of it") << " before event " << i << ", after step " << committed
            << ":\n"
            << state;
        surviving += state.size() > states[0].size() ? 1 : 0;
        ++failures;
        ASSERT_NO_FATAL_FAILURE(expect_whole(store));
        fs::remove_all(after);
      }
    }
    if (i == events.size()) break;
    cut_next = events[i].kind != Kind::write;
    if (events[i].kind == Kind::mark) committed = events[i].offset;
    disk.apply(events[i]);
  }
  EXPECT_GT(failures, 200);
  EXPECT_GT(surviving, 100);
  EXPECT_EQ(committed + 1, static_cast<std::int64_t>(states.size()));
}

struct Fault {
  const char* name;
  FaultyVfs::Call call;
  int code;
};

class StoreFaults : public testing::TestWithParam<Fault> {};

// One call after the other goes wrong, once or until it is put right. What was asked for has then happened or not, as a
// whole; who asked was told; and when the disk is well again the same store goes on.
TEST_P(StoreFaults, AtEveryCallAreToldAndTearNothing) {
  using Call = FaultyVfs::Call;
  const Fault fault = GetParam();
  const TemporaryFolder folder;
  FaultyVfs vfs;
  const fs::path fresh = folder.path() / "fresh.sqlite", file = folder.path() / "subpixel.sqlite";
  { const Store store(fresh); }
  const auto steps = store_workload(20'000);
  fs::copy_file(fresh, file);
  {
    Store store(file);
    for (const auto& step : steps) step(store);
  }
  const std::string expected = contents(file);
  int strikes = 0, errors = 0;
  for (const auto lasting : {FaultyVfs::Lasting::once, FaultyVfs::Lasting::until_healed}) {
    for (int nth = 1; nth <= 600; ++nth) {
      SCOPED_TRACE(std::string(fault.name) + " number " + std::to_string(nth) +
                   (lasting == FaultyVfs::Lasting::once ? "" : " and all after it"));
      for (const char* const suffix : {"", "-wal", "-shm"}) fs::remove(file.string() + suffix);
      fs::copy_file(fresh, file);
      vfs.fail(fault.call, nth, fault.code, lasting);
      std::unique_ptr<Store> store;
      const auto attempt = [&](const std::function<void()>& what) {
        try {
          what();
        } catch (const SqliteError& error) {
          ++errors;
          EXPECT_GT(std::string(error.what()).size(), 5u);
          EXPECT_FALSE(error.is_ours()) << error.what();
          return false;
        }
        return true;
      };
      if (!attempt([&] { store = std::make_unique<Store>(file); })) {
        vfs.heal();
        store = std::make_unique<Store>(file);
      }
      for (const auto& step : steps) {
        if (attempt([&] { step(*store); })) continue;
        vfs.heal();
        const std::string after = contents(file);
        step(*store);
        EXPECT_NE(contents(file), after) << "an error was told for what had been done";
      }
      const bool struck = vfs.struck();
      vfs.heal();
      // What steps without an error did, and those that were repeated, is all there is.
      EXPECT_EQ(contents(file), expected);
      store.reset();
      ASSERT_NO_FATAL_FAILURE(expect_whole(file));
      if (testing::Test::HasFailure()) return;
      if (!struck) break;
      ++strikes;
    }
  }
  EXPECT_GT(strikes, fault.call == Call::remove || fault.call == Call::truncate ? 0 : 1);
  RecordProperty("strikes", strikes);
  RecordProperty("errors", errors);
}

INSTANTIATE_TEST_SUITE_P(Calls, StoreFaults,
                         testing::Values(Fault{"read", FaultyVfs::Call::read, SQLITE_IOERR_READ},
                                         Fault{"write_full", FaultyVfs::Call::write, SQLITE_FULL},
                                         Fault{"write", FaultyVfs::Call::write, SQLITE_IOERR_WRITE},
                                         Fault{"write_read_only", FaultyVfs::Call::write, SQLITE_READONLY},
                                         Fault{"sync", FaultyVfs::Call::sync, SQLITE_IOERR_FSYNC},
                                         Fault{"size", FaultyVfs::Call::size, SQLITE_IOERR_FSTAT},
                                         Fault{"open", FaultyVfs::Call::open, SQLITE_CANTOPEN},
                                         Fault{"lock", FaultyVfs::Call::lock, SQLITE_BUSY},
                                         Fault{"shared_memory", FaultyVfs::Call::shm_map, SQLITE_IOERR_SHMMAP},
                                         Fault{"shared_lock", FaultyVfs::Call::shm_lock, SQLITE_BUSY}),
                         [](const auto& param) { return std::string(param.param.name); });

// The same as clients of the service see it.
using Faults = ServiceTest;

TEST_F(Faults, OfTheStoreAreAnsweredAndGoByWhenTheyAreOver) {
  FaultyVfs vfs;
  start(options());
  const std::string hash = client().upload_fake({{"frames", 1}});
  while (client().get("/api/captures/" + hash).at("thumbnail").is_null()) {  // a run of the service's own
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const json wanted = {{"capture", hash}, {"techniques", {"noaa,msaa"}}, {"width", 32}, {"height", 18}};
  const std::string other = fake_capture({{"frames", 2}});
  struct Case {
    FaultyVfs::Call call;
    int code, status;
    const char* why;
  };
  for (const Case& each : {Case{FaultyVfs::Call::write, SQLITE_FULL, 507, "full"},
                           Case{FaultyVfs::Call::write, SQLITE_READONLY, 507, "only be read"},
                           Case{FaultyVfs::Call::shm_lock, SQLITE_BUSY, 503, "try again"},
                           Case{FaultyVfs::Call::sync, SQLITE_IOERR_FSYNC, 500, "disk failed"}}) {
    SCOPED_TRACE(each.why);
    const std::size_t runs = client().get("/api/runs").at("runs").size();
    vfs.fail(each.call, 1, each.code, FaultyVfs::Lasting::until_healed);
    for (const httplib::Result& refused : {client().post_run(wanted), client().upload(other)}) {
      const json error = error_of(refused, each.status);
      EXPECT_NE(error.dump().find(each.why), std::string::npos) << error;
    }
    vfs.heal();
    EXPECT_EQ(client().get("/api/runs").at("runs").size(), runs);
    EXPECT_EQ(client().get("/api/captures").at("total"), 1);
    EXPECT_EQ(client().wait_for_end(client().start_run(hash)).at("status"), "done");
  }
  EXPECT_EQ(client().upload(other)->status, 201);
  stop();  // before the layer below it goes
}

// A row must not come to the disk before the file that it names: its bytes, its name, then the row.
TEST_F(Faults, CaptureIsOnTheDiskBeforeItsRow) {
  client();
  std::mutex mutex;
  std::vector<std::string> calls;
  on_disk_call = [&](const std::string& call, const std::string& path) {
    const std::lock_guard lock(mutex);
    calls.push_back(call + " " + fs::path(path).lexically_relative(fs::canonical(folder()) / "data").string());
    return 0;
  };
  const httplib::Result uploaded = client().upload(fake_capture({{"frames", 0}}));  // no frames, no thumbnail
  on_disk_call = nullptr;
  ASSERT_EQ(uploaded->status, 201) << uploaded->body;
  const std::string hash = json::parse(uploaded->body).at("hash");
  ASSERT_EQ(calls.size(), 4u) << json(calls);
  EXPECT_TRUE(calls[0].starts_with("sync uploads/upload-")) << calls[0];
  EXPECT_EQ(calls[1], "link captures/" + hash + ".spcap");
  EXPECT_EQ(calls[2], "sync captures");
  EXPECT_EQ(calls[3], "sync subpixel.sqlite-wal");
}

TEST_F(Faults, CaptureThatCantBeStoredIsToldAndLeavesNothing) {
  client();
  const auto files = [&](const char* name) {
    return std::distance(fs::directory_iterator(folder() / "data" / name), fs::directory_iterator());
  };
  const std::string bytes = fake_capture({{"frames", 0}});
  struct Case {
    const char *call, *path;
    int error, status;
  };
  for (const Case& each :
       {Case{"sync", "upload-", EIO, 500}, Case{"sync", "upload-", ENOSPC, 507}, Case{"link", "captures", EROFS, 500},
        Case{"link", "captures", ENOSPC, 507}, Case{"sync", "captures", EIO, 500}}) {
    SCOPED_TRACE(std::string(each.call) + " " + each.path + ": " + std::strerror(each.error));
    on_disk_call = [&](const std::string& call, const std::string& path) {
      return call == each.call && path.find(each.path) != std::string::npos ? each.error : 0;
    };
    const json error = error_of(client().upload(bytes), each.status);
    on_disk_call = nullptr;
    EXPECT_EQ(error.at("where"), "data folder");
    EXPECT_EQ(client().get("/api/captures").at("total"), 0);
    EXPECT_EQ(files("uploads"), 0);
  }
  EXPECT_EQ(client().upload(bytes)->status, 201);
  EXPECT_EQ(files("captures"), 1);
}

}  // namespace
}  // namespace subpixel::tests
