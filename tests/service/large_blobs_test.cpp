// Blobs whose bytes are outside the store's file: there before their row and as long as it, whatever goes wrong.
#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "base/error.hpp"
#include "server/store/store_access.hpp"
#include "server/store/upkeep.hpp"
#include "tests/service/disk_calls.hpp"
#include "tests/service/store_workload.hpp"

namespace subpixel::tests {
namespace {

namespace fs = std::filesystem;
using server::DataFolder;
using server::SqliteError;
using server::Store;

constexpr std::uint64_t kLarge = 1000;

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

class LargeBlobs : public testing::Test {
 protected:
  LargeBlobs() {
    const DataFolder made(data());
    Store store(made.store());
    place(kLarge);
  }
  fs::path data() const { return folder_.path() / "data"; }
  fs::path file() const { return data() / "subpixel.sqlite"; }
  server::Moved place(std::optional<std::uint64_t> large) const {
    return server::place_blobs(DataFolder(data(), DataFolder::Claim::reader), large);
  }
  server::CheckReport check() const { return check_in(data()); }
  // But for captures: those of these tests have no files, or others' bytes.
  static server::CheckReport check_in(const fs::path& where) {
    server::CheckReport report =
        server::check_data(DataFolder(where, DataFolder::Claim::reader), [](const fs::path&) { return true; });
    std::erase_if(report.damage, [](const std::string& line) { return line.starts_with("a capture: its file"); });
    return report;
  }
  server::Freed collect(bool dry = false) const {
    const DataFolder claimed(data(), DataFolder::Claim::reader);
    Store store(claimed.store());
    return server::collect_garbage(claimed, store, {}, dry, [](const fs::path&) { return true; });
  }
  std::string relative(const std::string& path) const {
    return fs::path(path).lexically_relative(fs::canonical(data())).string();
  }
  std::vector<fs::path> blob_files() const {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(data() / "blobs")) {
      if (entry.is_regular_file() && entry.path().filename() != "lock") files.push_back(entry.path());
    }
    std::ranges::sort(files);
    return files;
  }
  // A capture, a run, and one result with a large image and a small one. Returns the large one's hash.
  std::string store_one(Store& store, int number = 0) const {
    store.add_capture(stored_capture('a'));
    const std::int64_t run = store.add_run(server::RunKind::run, std::string(32, 'a'), stored_options(), 4).value();
    store.add_result(run, 0, stored_result(0, "noaa"),
                     {{"image", stored_image(5000, number)}, {"error", {"image/png", "small"}}});
    return store.results(run).at(0).document.at("images").at("image");
  }
  TemporaryFolder folder_;
};

TEST_F(LargeBlobs, AreReadLikeOthersWholeAndInParts) {
  Store store(file());
  const std::string hash = store_one(store);
  const server::Blob image = stored_image(5000, 0);
  ASSERT_EQ(blob_files().size(), 1u);
  EXPECT_EQ(blob_files()[0], data() / "blobs" / hash.substr(0, 2) / hash);
  EXPECT_EQ(store.blob(hash).value().bytes, image.bytes);
  EXPECT_EQ(store.blob(hash).value().media_type, "image/png");
  EXPECT_EQ(store.blob_info(hash).value().size_bytes, image.bytes.size());
  std::string part;
  EXPECT_TRUE(store.read_blob(hash, 4000, 1001, [&](std::string_view bytes) {
    part.append(bytes);
    return true;
  }));
  EXPECT_EQ(part, image.bytes.substr(4000));
  // The same image once more is the same file.
  store_one(store);
  EXPECT_EQ(blob_files().size(), 1u);
  const auto report = check();
  EXPECT_TRUE(report.damage.empty() && report.leftover.empty()) << json(report.damage) << json(report.leftover);
  EXPECT_EQ(report.outside, 1u);
}

// Bytes, name, row: a power failure after any of them leaves no row without its bytes.
TEST_F(LargeBlobs, AreOnTheDiskBeforeTheirRowAndGoAfterIt) {
  Store store(file());
  store_one(store, 1);  // folders are there from now on
  std::vector<std::string> calls;
  on_disk_call = [&](const std::string& call, const std::string& path) {
    calls.push_back(call + " " + relative(path));
    return 0;
  };
  const std::string hash = store_one(store, 0);
  on_disk_call = nullptr;
  const std::string in = "blobs/" + hash.substr(0, 2);
  const auto at = [&](const std::string& begin) {
    return std::ranges::find_if(calls, [&](const std::string& call) { return call.starts_with(begin); }) -
           calls.begin();
  };
  const auto named = at("rename " + in + "/" + hash), lasting = std::ranges::find(calls, "sync " + in) - calls.begin();
  EXPECT_LT(at("sync " + in + "/.subpixel-"), named) << json(calls);
  EXPECT_LT(named, lasting) << json(calls);
  EXPECT_LT(lasting, static_cast<std::ptrdiff_t>(calls.size()) - 1) << json(calls);
  EXPECT_EQ(calls.back(), "sync subpixel.sqlite-wal") << json(calls);

  // The other way round: the row's deletion is on the disk while the file is still there.
  const std::int64_t newest = store.runs(1, 0, "").at(0).id;
  store.cancel_queued(newest);
  bool was_there = false;
  on_disk_call = [&](const std::string& call, const std::string& path) {
    if (call == "sync" && relative(path) == "subpixel.sqlite-wal") was_there = fs::exists(data() / in / hash);
    return 0;
  };
  EXPECT_EQ(store.delete_run(newest), Store::Deletion::deleted);
  on_disk_call = nullptr;
  EXPECT_TRUE(was_there);
  EXPECT_FALSE(fs::exists(data() / in / hash));
  EXPECT_EQ(joined(check().damage), "");
}

// Each call to the disk fails in its turn: who asked is told why, nothing is torn, and it works when the disk does.
TEST_F(LargeBlobs, FailureAtEveryDiskCallIsToldAndTearsNothing) {
  const auto steps = store_workload(20'000);
  const fs::path fresh = folder_.path() / "fresh", well = folder_.path() / "well";
  fs::copy(data(), fresh, fs::copy_options::recursive);
  {
    Store store(file());
    for (const auto& step : steps) step(store);
  }
  const std::string expected = contents(file());
  int strikes = 0, told = 0;
  for (const int error : {EIO, ENOSPC, EROFS}) {
    for (int nth = 1; nth <= 400; ++nth) {
      SCOPED_TRACE(std::string(std::strerror(error)) + " at call " + std::to_string(nth));
      fs::remove_all(data());
      fs::copy(fresh, data(), fs::copy_options::recursive);
      Store store(file());
      int left = nth;
      bool struck = false;
      for (const auto& step : steps) {
        on_disk_call = [&](const std::string&, const std::string& path) {
          if (relative(path).starts_with("blobs") && --left == 0) {
            struck = true;
            return error;
          }
          return 0;
        };
        try {
          step(store);
          on_disk_call = nullptr;
        } catch (const SqliteError& failure) {
          on_disk_call = nullptr;
          ++told;
          EXPECT_EQ(failure.disk_full(), error == ENOSPC) << failure.what();
          EXPECT_FALSE(failure.is_ours());
          EXPECT_EQ(joined(check().damage), "");
          step(store);
        }
      }
      EXPECT_EQ(contents(file()), expected);
      EXPECT_EQ(joined(check().damage), "");
      collect();
      EXPECT_EQ(joined(check().leftover), "");
      if (HasFailure()) return;
      if (!struck) break;
      ++strikes;
    }
  }
  EXPECT_GT(strikes, 30);
  EXPECT_EQ(told, strikes);
}

TEST_F(LargeBlobs, CheckNamesDamageAndLeftoversGo) {
  std::string hash;
  {
    Store store(file());
    hash = store_one(store);
  }
  const fs::path blob = data() / "blobs" / hash.substr(0, 2) / hash;
  const fs::path healthy = folder_.path() / "healthy";
  fs::copy(data(), healthy, fs::copy_options::recursive);
  const auto damage_after = [&](const std::function<void()>& harm) {
    harm_a_copy(healthy, data(), harm);
    return joined(check().damage);
  };
  EXPECT_EQ(damage_after([] {}), "");
  EXPECT_NE(damage_after([&] { fs::remove(blob); }).find("its file is not there"), std::string::npos);
  EXPECT_NE(damage_after([&] { fs::resize_file(blob, 4999); }).find("another size"), std::string::npos);
  EXPECT_NE(damage_after([&] {
              std::fstream(blob, std::ios::in | std::ios::out | std::ios::binary).seekp(70) << 'X';
            }).find("another hash"),
            std::string::npos);
  // What a writer left that died before its row, and half of a file.
  damage_after([] {});
  const fs::path orphan = data() / "blobs" / "cc" / std::string(32, 'c'), half = data() / "blobs" / ".subpixel-1.tmp";
  fs::create_directories(orphan.parent_path());
  for (const fs::path& file : {orphan, half}) std::ofstream(file) << "12345";
  fs::last_write_time(half, fs::file_time_type::clock::now() - std::chrono::hours(2));
  EXPECT_EQ(check().leftover.size(), 1u) << joined(check().leftover);
  EXPECT_EQ(collect(true).files, 1u);
  EXPECT_TRUE(fs::exists(orphan));
  EXPECT_EQ(collect().file_bytes, 5u);
  EXPECT_FALSE(fs::exists(orphan) || fs::exists(half));
  EXPECT_EQ(blob_files().size(), 1u);
}

TEST_F(LargeBlobs, BackupHasThemAndNoneGoesWhileItRuns) {
  Store store(file());
  const std::string hash = store_one(store);
  std::ofstream(DataFolder(data(), DataFolder::Claim::reader).capture(std::string(32, 'a'))) << "a capture's bytes";
  const auto report = server::back_up(DataFolder(data(), DataFolder::Claim::reader), folder_.path() / "copy");
  EXPECT_EQ(report.outside, 1u);
  EXPECT_EQ(joined(check_in(folder_.path() / "copy").damage), "");
  EXPECT_EQ(Store(folder_.path() / "copy" / "subpixel.sqlite").blob(hash).value().bytes, stored_image(5000, 0).bytes);
  const fs::path blob = data() / "blobs" / hash.substr(0, 2) / hash;
  {
    const std::shared_ptr<void> held = store.large_blobs().hold();
    store.large_blobs().remove(hash);
    EXPECT_TRUE(fs::exists(blob)) << "a backup would miss it";
  }
  store.large_blobs().remove(hash);
  EXPECT_FALSE(fs::exists(blob));
  EXPECT_THROW(server::back_up(DataFolder(data(), DataFolder::Claim::reader), folder_.path() / "other"), InputError);
  EXPECT_FALSE(fs::exists(folder_.path() / "other"));
}

// From rows to files and back, broken off at every call and gone on with.
TEST_F(LargeBlobs, AreMovedBothWaysAndItCanBeBrokenOff) {
  EXPECT_EQ(place(std::nullopt).out, 0u);
  {
    Store store(file());
    store.add_capture(stored_capture('a'));
    const std::int64_t run = store.add_run(server::RunKind::run, std::string(32, 'a'), stored_options(), 4).value();
    for (std::uint32_t i = 0; i < 4; ++i) {
      store.add_result(run, i % 2, stored_result(i / 2, i % 2 == 0 ? "noaa" : "msaa"),
                       {{"image", stored_image(5000 + i, static_cast<int>(i))}, {"error", stored_image(10, 5)}});
    }
  }
  const std::string expected = contents(file());
  EXPECT_TRUE(blob_files().empty());
  for (const bool out : {true, false}) {
    int broken = 0;
    for (int nth = 1; nth < 200; ++nth) {
      int left = nth;
      on_disk_call = [&](const std::string&, const std::string&) { return --left == 0 ? EIO : 0; };
      bool done = false;
      try {
        place(out ? std::optional(kLarge) : std::nullopt);
        done = true;
      } catch (const SqliteError&) {
        ++broken;
      }
      on_disk_call = nullptr;
      EXPECT_EQ(contents(file()), expected);
      ASSERT_EQ(joined(check().damage), "") << nth;
      if (done && left > 0) break;
    }
    EXPECT_GT(broken, out ? 3 : 0);
    EXPECT_EQ(check().outside, out ? 4u : 0u);
    collect();
    EXPECT_EQ(blob_files().size(), out ? 4u : 0u);
  }
  // A threshold that some of them are below.
  const server::Moved moved = place(5003);
  EXPECT_EQ(moved.out, 2u);
  EXPECT_EQ(place(5004).in, 1u);
}

}  // namespace
}  // namespace subpixel::tests
