// What workers must not do, tried by one: refused when it is confined and, so that a refusal means something, possible
// when it is not.
#include <fcntl.h>
#include <unistd.h>

#include <fstream>

#include "process/child_process.hpp"
#include "process/confinement.hpp"
#include "tests/service/service_fixture.hpp"

namespace subpixel::tests {
namespace {

namespace fs = std::filesystem;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

class Confined : public testing::Test {
 protected:
  Confined() {
    for (const fs::path& folder : {inside(), outside()}) {
      fs::create_directories(folder);
      std::ofstream(folder / "file") << "some bytes";
    }
    limits_.confinement.emplace();
    limits_.confinement->writable = {inside().string()};
  }

  fs::path inside() const { return folder_.path() / "inside"; }
  fs::path outside() const { return folder_.path() / "outside"; }

  ChildOutcome run(const std::string& what, const std::string& path, std::string& said) const {
    return run_child({SUBPIXEL_FAKE_WORKER, "probe", what, path}, limits_, {}, [&](std::string_view line) {
      said += line;
      return true;
    });
  }
  std::string confined(const std::string& what, const std::string& path = "") const {
    std::string said;
    const ChildOutcome outcome = run(what, path, said);
    return said.empty() ? "nothing said: " + outcome.reason : said;
  }
  std::string free(const std::string& what, const std::string& path = "") {
    ChildLimits confined_limits;
    std::swap(limits_, confined_limits);
    std::string said = confined(what, path);
    std::swap(limits_, confined_limits);
    return said;
  }

  TemporaryFolder folder_;
  ChildLimits limits_;
};

TEST_F(Confined, ThisKernelHoldsAllOfIt) {
  EXPECT_EQ(confinement_gaps(), std::vector<std::string>()) << "the tests below need a kernel with Landlock 6";
}

TEST_F(Confined, FilesOutsideAreNeitherReadNorChanged) {
  const std::string file = outside() / "file", there = outside() / "new";
  for (const auto& [what, path] : std::vector<std::pair<std::string, std::string>>{{"read", file},
                                                                                   {"list", outside()},
                                                                                   {"write", file},
                                                                                   {"create", there},
                                                                                   {"make_folder", there},
                                                                                   {"make_link", there},
                                                                                   {"make_pipe", there},
                                                                                   {"rename", file},
                                                                                   {"shorten", file},
                                                                                   {"change_mode", file},
                                                                                   {"change_owner", file},
                                                                                   {"change_times", file},
                                                                                   {"remove", file}}) {
    EXPECT_TRUE(confined(what, path).starts_with("refused: ")) << what;
    EXPECT_EQ(free(what, path), "done") << what;
    // As it was before.
    fs::remove_all(outside());
    fs::create_directories(outside());
    std::ofstream(file) << "some bytes";
  }
}

TEST_F(Confined, ItsOwnFolderIsToRead_Write_AndClear) {
  for (const std::string what : {"read", "write", "large_file"}) EXPECT_EQ(confined(what, inside() / "file"), "done");
  EXPECT_EQ(confined("list", inside()), "done");
  EXPECT_EQ(confined("create", inside() / "new"), "done");
  EXPECT_EQ(confined("rename", inside() / "new"), "done");
  EXPECT_EQ(confined("make_folder", inside() / "folder"), "done");
  EXPECT_EQ(confined("remove", inside() / "file"), "done");
  // What is left there is read by the service, which takes files alone.
  for (const std::string what : {"make_link", "make_pipe"}) {
    EXPECT_TRUE(confined(what, inside() / "other").starts_with("refused: ")) << what;
  }
  limits_.confinement->writable.clear();
  limits_.confinement->readable = {inside().string()};
  std::ofstream(inside() / "file") << "some bytes";
  EXPECT_EQ(confined("read", inside() / "file"), "done");
  for (const std::string what : {"write", "remove"}) {
    EXPECT_TRUE(confined(what, inside() / "file").starts_with("refused: ")) << what;
  }
}

TEST_F(Confined, NothingLeadsToTheNetworkOrToOtherProcesses) {
  for (const std::string what : {"internet_socket", "internet6_socket", "local_socket", "netlink_socket", "socket_pair",
                                 "signal", "signal_thread", "priority"}) {
    EXPECT_TRUE(confined(what).starts_with("refused: ")) << what;
    EXPECT_EQ(free(what), "done") << what;
  }
  EXPECT_EQ(confined("signal_itself"), "done") << "abort needs it";
  if (!kSanitized) {
    EXPECT_TRUE(confined("trace").starts_with("refused: "));
  }
}

TEST_F(Confined, NoFurtherProcessOrProgram) {
  if (kSanitized) GTEST_SKIP() << "sanitizers start processes";
  for (const std::string what : {"fork", "run_in_child"}) {
    EXPECT_TRUE(confined(what).starts_with("refused: ")) << what;
    EXPECT_EQ(free(what), "done") << what;
  }
  EXPECT_TRUE(confined("run").starts_with("refused: "));
  EXPECT_TRUE(free("run").starts_with("nothing said")) << "it is another program now";
  // Its own program may be executed, or it would not have started; what it decodes is decoded after this.
  EXPECT_TRUE(confined("run_itself", SUBPIXEL_FAKE_WORKER).starts_with("nothing said: ")) << "usage, exit code 2";
  EXPECT_TRUE(confined("run_itself_forbidden", SUBPIXEL_FAKE_WORKER).starts_with("refused: "));
}

TEST_F(Confined, NoMountsNamespacesOrWaysRoundTheFilter) {
  for (const std::string what : {"mount", "namespace", "namespace_by_clone", "change_root", "io_uring"}) {
    EXPECT_TRUE(confined(what, inside()).starts_with("refused: Operation not permitted")) << what;
  }
}

TEST_F(Confined, WhatCompilersAndThreadsNeedIsThere) {
  for (const std::string what : {"code", "thread"}) EXPECT_EQ(confined(what), "done") << what;
  EXPECT_EQ(confined("read", "/proc/cpuinfo"), "done");
  EXPECT_EQ(confined("read", "/dev/urandom"), "done");
}

TEST_F(Confined, MemoryFilesAndProcessorTimeHaveLimits) {
  limits_.file_bytes = 1 << 20;
  EXPECT_EQ(confined("large_file", inside() / "large"), "refused: File too large");
  if (!kSanitized) {
    EXPECT_EQ(confined("memory"), "done");
    limits_.address_space_bytes = std::uint64_t{8} << 30;
    EXPECT_EQ(confined("memory"), "refused: Cannot allocate memory");
  }
  limits_.processor_s = 1;
  std::string said;
  EXPECT_EQ(run("burn", "", said).reason, "the worker process used more than 1 s of processor time and was ended");
}

TEST_F(Confined, DescriptorsOfTheServiceStayWithIt) {
  const int file = ::open((outside() / "file").c_str(), O_RDONLY);  // without O_CLOEXEC
  ASSERT_GE(file, 0);
  const int high = ::fcntl(file, F_DUPFD, 50);
  EXPECT_EQ(confined("inherited", std::to_string(high)), "refused: Bad file descriptor");
  ::close(file);
  ::close(high);
}

TEST_F(Confined, WhoRunsProgramsHasProcessesAndNothingElseMore) {
  limits_.confinement->interpreter = "/usr/bin/python3";
  for (const std::string what : {"fork", "run_in_child"}) EXPECT_EQ(confined(what), "done") << what;
  for (const std::string what : {"internet_socket", "local_socket", "socket_pair", "signal", "namespace"}) {
    EXPECT_TRUE(confined(what).starts_with("refused: ")) << what;
  }
  for (const std::string what : {"make_link", "make_pipe", "change_mode"}) {
    EXPECT_TRUE(confined(what, inside() / (what == "change_mode" ? "file" : "new")).starts_with("refused: ")) << what;
  }
  EXPECT_TRUE(confined("write", outside() / "file").starts_with("refused: "));
  EXPECT_TRUE(confined("read", outside() / "file").starts_with("refused: "));
  const std::string elsewhere = outside() / "interpreter";
  fs::copy_file("/bin/true", elsewhere);
  EXPECT_TRUE(confined("run_in_child", elsewhere).starts_with("refused: ")) << "another was named";
  limits_.confinement->interpreter = elsewhere;
  EXPECT_EQ(confined("run_in_child", elsewhere), "done");
}

using ConfinedService = ServiceTest;

TEST_F(ConfinedService, WorkersAndInspectionsDoNotReachItsStore) {
  start(options());
  const std::string store = (folder() / "data" / "subpixel.sqlite").string();
  const std::string hash = client().upload_fake({{"frames", 1}, {"fail_at", 0}, {"how", "reach"}, {"reach", store}});
  const json run = client().wait_for_end(client().start_run(hash));
  EXPECT_EQ(run.at("reason"), "reach: Permission denied") << run;
  const httplib::Result inspected =
      client().upload(fake_capture({{"frames", 1}, {"how", "info_reach"}, {"reach", store}}));
  ASSERT_TRUE(inspected);
  EXPECT_EQ(json::parse(inspected->body).value("title", ""), "reach: Permission denied") << inspected->body;
}

}  // namespace
}  // namespace subpixel::tests
