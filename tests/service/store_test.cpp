// The store by itself: versions, content-addressed blobs, and text from outside.
#include "server/store/store.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "base/error.hpp"
#include "server/store/schema.hpp"
#include "tests/service/service_fixture.hpp"
#include "tests/service/store_workload.hpp"

namespace subpixel::tests {
namespace {

using server::Blob;
using server::Connection;
using server::RunKind;
using server::RunStatus;
using server::Store;

class StoreTest : public testing::Test {
 protected:
  std::filesystem::path file() const { return folder_.path() / "store.sqlite"; }

 private:
  TemporaryFolder folder_;
};

std::int64_t count(const Connection& connection, const std::string& table) {
  server::Statement select(connection, "SELECT count(*) FROM " + table);
  select.step();
  return select.integer();
}

TEST_F(StoreTest, NewerVersionIsRefused) {
  { const Store store(file()); }
  Connection(file()).execute("PRAGMA user_version = 999");
  EXPECT_THROW(Store{file()}, InputError);
}

TEST_F(StoreTest, ForeignFileIsRefused) {
  std::ofstream(file()) << "this is no database, but it is longer than a header of one, which has a hundred bytes, as "
                           "everybody knows who has read the file format";
  EXPECT_THROW(Store{file()}, std::exception);
}

TEST_F(StoreTest, MigrationsRunInOrderAndAllOrNothing) {
  const Connection connection(file());
  const std::vector<std::string_view> first{"CREATE TABLE one (a INTEGER)"};
  server::migrate(connection, first, file());
  connection.execute("INSERT INTO one VALUES (7)");
  const std::vector<std::string_view> broken{first[0], "ALTER TABLE one ADD COLUMN b INTEGER; CREATE TABLE oops ("};
  EXPECT_THROW(server::migrate(connection, broken, file()), server::SqliteError);
  const std::vector<std::string_view> good{first[0], "ALTER TABLE one ADD COLUMN b INTEGER", "CREATE TABLE three (c)"};
  server::migrate(connection, good, file());
  EXPECT_EQ(count(connection, "one"), 1);
  EXPECT_EQ(count(connection, "three"), 0);
  EXPECT_THROW(server::migrate(connection, first, file()), InputError);
}

// Foreign keys without an index make every deletion a scan; lists without one sort the table.
TEST_F(StoreTest, EveryForeignKeyHasAnIndex) {
  { const Store store(file()); }
  const Connection connection(file());
  server::Statement keys(connection,
                         "SELECT m.name, f.\"from\" FROM sqlite_master m, pragma_foreign_key_list(m.name) f "
                         "WHERE m.type = 'table' AND f.seq = 0");
  int checked = 0;
  while (keys.step()) {
    const std::string table = keys.text(), column = keys.text();
    server::Statement index(connection,
                            "SELECT 1 FROM pragma_index_list(?) l, pragma_index_info(l.name) i WHERE i.seqno "
                            "= 0 AND i.name = ?");
    EXPECT_TRUE(index.bind(table).bind(column).step()) << table << "." << column;
    ++checked;
  }
  EXPECT_GE(checked, 6);
}

TEST_F(StoreTest, ResultIsStoredOnceWithPassesAndImages) {
  Store store(file());
  ASSERT_TRUE(store.add_capture(stored_capture('a')));
  EXPECT_FALSE(store.add_capture(stored_capture('a')));
  const std::int64_t run = store.add_run(RunKind::run, stored_capture('a').hash, stored_options(), 4).value();
  const std::map<std::string, Blob> images{{"image", {"image/png", "pixels"}}, {"error", {"image/png", "pixels"}}};
  EXPECT_TRUE(store.add_result(run, 1, stored_result(0, "msaa"), images));
  EXPECT_FALSE(store.add_result(run, 1, stored_result(0, "msaa"), images));
  EXPECT_TRUE(store.add_result(run, 0, stored_result(0, "noaa"), images));

  const std::vector<server::StoredResult> results = store.results(run);
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0].document.at("technique"), "noaa") << "by frame, then in the request's order";
  EXPECT_EQ(results[0].sequence, 2);
  EXPECT_EQ(results[0].document.at("images").at("image"), results[1].document.at("images").at("error"));
  EXPECT_EQ(store.blob(results[0].document.at("images").at("image").get<std::string>()).value().bytes, "pixels");
  EXPECT_EQ(store.stored_pairs(run), (std::vector<std::pair<std::uint32_t, std::uint32_t>>{{0, 0}, {0, 1}}));
  EXPECT_EQ(store.results_after(run, 1, 10).size(), 1u);
  const Connection connection(file());
  EXPECT_EQ(count(connection, "blobs"), 1);
  EXPECT_EQ(count(connection, "pass_times"), 4);
}

TEST_F(StoreTest, DeletionTakesAllThatBelongsToIt) {
  Store store(file());
  store.add_capture(stored_capture('a'));
  const std::int64_t run = store.add_run(RunKind::run, stored_capture('a').hash, stored_options(), 4).value();
  store.add_result(run, 0, stored_result(0, "noaa"), {{"image", {"image/png", "pixels"}}});
  EXPECT_EQ(store.delete_run(run), Store::Deletion::in_use);
  EXPECT_TRUE(store.finish_run(run, RunStatus::done, ""));
  EXPECT_FALSE(store.finish_run(run, RunStatus::failed, "too late"));
  EXPECT_EQ(store.delete_capture(stored_capture('a').hash), Store::Deletion::deleted);
  const Connection connection(file());
  for (const char* table : {"captures", "runs", "run_techniques", "frame_results", "pass_times", "images", "blobs"}) {
    EXPECT_EQ(count(connection, table), 0) << table;
  }
  EXPECT_FALSE(store.add_run(RunKind::run, stored_capture('a').hash, stored_options(), 4));
}

TEST_F(StoreTest, ThumbnailsGoFirstAndEachRunGoesToOne) {
  Store store(file());
  store.add_capture(stored_capture('a'));
  const std::int64_t run = store.add_run(RunKind::run, stored_capture('a').hash, stored_options(), 4).value();
  const std::int64_t thumbnail =
      store.add_run(RunKind::thumbnail, stored_capture('a').hash, stored_options(), 1).value();
  EXPECT_EQ(store.start_next_run().value().id, thumbnail);
  EXPECT_EQ(store.start_next_run().value().id, run);
  EXPECT_FALSE(store.start_next_run());
  store.requeue_running(false);
  EXPECT_EQ(store.start_next_run().value().starts_without_result, 2u);
}

}  // namespace
}  // namespace subpixel::tests
