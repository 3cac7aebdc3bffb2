// What leaves a program gets the exit code and the words that its kind calls for.
#include "base/failure.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "base/error.hpp"
#include "server/http_error.hpp"
#include "server/store/sqlite.hpp"

namespace subpixel {
namespace {

template <typename Thrower>
Failure failure_when(Thrower&& thrower) {
  try {
    thrower();
  } catch (...) {
    return failure_of(std::current_exception());
  }
  return {ExitCode{}, "nothing was thrown"};
}

TEST(FailureOf, OurErrorsSayWhatTheySay) {
  const Failure usage = failure_when([] { throw UsageError("samples", "5 is not one of 4, 8", "--samples"); });
  EXPECT_EQ(usage.exit_code, 2);
  EXPECT_EQ(usage.message, "samples: 5 is not one of 4, 8: --samples");
  EXPECT_EQ(failure_when([] { throw InputError("capture", "it is cut", "byte 7"); }).exit_code, 3);
  EXPECT_EQ(failure_when([] { throw DeviceError("device", "there is none", ""); }).exit_code, 4);
}

TEST(FailureOf, TheSystemsErrorsAreNotOurMistakes) {
  const Failure memory = failure_when([] { throw std::bad_alloc(); });
  EXPECT_EQ(memory.exit_code, 4);
  EXPECT_EQ(memory.message, "memory: there is not enough");
  const Failure file = failure_when([] { (void)std::filesystem::file_size("/nonexistent/x"); });
  EXPECT_EQ(file.exit_code, 3);
  EXPECT_EQ(file.message, "file system: No such file or directory: /nonexistent/x");
  const Failure thread =
      failure_when([] { throw std::system_error(EAGAIN, std::generic_category(), "thread constructor"); });
  EXPECT_EQ(thread.exit_code, 3);
  EXPECT_EQ(thread.message, "system: Resource temporarily unavailable");
}

TEST(FailureOf, EverythingElseIsOursAndAsksForAReport) {
  const std::vector<Failure> failures{
      failure_when([] { throw std::logic_error("no such shader: x.comp"); }),
      failure_when([] { throw std::runtime_error("unforeseen"); }),
      failure_when([] { (void)std::vector<int>().at(3); }),
      failure_when([] { (void)nlohmann::json::parse("{}").at("missing"); }),
      failure_when([] { throw 7; }),
  };
  for (const Failure& failure : failures) {
    EXPECT_EQ(failure.exit_code, 70) << failure.message;
    EXPECT_TRUE(failure.message.starts_with("internal error: ")) << failure.message;
    EXPECT_TRUE(failure.message.ends_with(": please report it")) << failure.message;
  }
  EXPECT_EQ(failures[0].message, "internal error: no such shader: x.comp: please report it");
  EXPECT_EQ(failure_when([] { throw std::logic_error("two\nlines"); }).message.find('\n'), std::string::npos);
}

TEST(FailureOf, StoreKnowsItsOwnMistakesFromTheFiles) {
  const server::Connection connection(":memory:");
  const auto error_of = [&](const char* sql) {
    try {
      connection.execute(sql);
    } catch (const server::SqliteError& error) {
      return error.is_ours();
    }
    ADD_FAILURE() << sql;
    return false;
  };
  EXPECT_TRUE(error_of("SELECT * FROM nothing"));
  EXPECT_TRUE(error_of("CREATE TABLE t (a NOT NULL); INSERT INTO t VALUES (NULL)"));
  EXPECT_FALSE(server::SqliteError(nullptr, SQLITE_NOTADB).is_ours());
  EXPECT_FALSE(server::SqliteError(nullptr, SQLITE_FULL).is_ours());
  EXPECT_FALSE(server::SqliteError(nullptr, SQLITE_BUSY).is_ours());
}

TEST(HttpErrorOf, OnlyTheRequestsFaultsAre400) {
  const auto status = [](auto error) { return server::http_error_from(std::make_exception_ptr(error)); };
  EXPECT_EQ(status(UsageError("a", "b", "c")).status(), 400);
  EXPECT_EQ(status(InputError("a", "b", "c")).status(), 400);
  for (const server::HttpError& error :
       {status(std::logic_error("wrong")), status(std::runtime_error("wrong")), status(7)}) {
    EXPECT_EQ(error.status(), 500);
    EXPECT_NE(error.json().dump().find("please report it"), std::string::npos) << error.json();
    EXPECT_EQ(error.json().dump().find("wrong"), std::string::npos) << "details are for the log";
  }
}

}  // namespace
}  // namespace subpixel
