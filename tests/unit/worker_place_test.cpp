// What is said of a worker that died: the signal, what it was at, the driver, what to try.
#include "server/engine/worker_place.hpp"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>

namespace subpixel::server {
namespace {

ChildOutcome died(int signal) {
  return {ChildOutcome::Kind::signalled, signal, "first\nlast\n", "ended by signal"};
}

TEST(WorkerPlace, ACrashNamesPlaceDriverAndWhatToTry) {
  ::unsetenv("LP_NATIVE_VECTOR_WIDTH");
  ::unsetenv("GALLIUM_OVERRIDE_CPU_CAPS");
  WorkerPlace place;
  EXPECT_EQ(place.end_in_words(died(SIGILL)),
            "ended by signal; try other techniques, another version of the driver, another machine; its last words: "
            "last")
      << "before it said anything";
  place.progress("device", "llvmpipe, Mesa 25.0.7");
  EXPECT_NE(place.end_in_words(died(SIGBUS)).find("signal on llvmpipe, Mesa 25.0.7; try"), std::string::npos);
  place.progress("load", "grass");
  place.progress("replay", "frame 0 streaming");
  ::setenv("LP_NATIVE_VECTOR_WIDTH", "512", 1);
  const std::string words = place.end_in_words(died(SIGBUS));
  ::unsetenv("LP_NATIVE_VECTOR_WIDTH");
  EXPECT_EQ(words,
            "ended by signal; it was at \"replay: frame 0 streaming\" on llvmpipe, Mesa 25.0.7; try without "
            "LP_NATIVE_VECTOR_WIDTH=512, other techniques, another version of the driver, another machine; its last "
            "words: last");
}

TEST(WorkerPlace, OtherEndsSayLess) {
  WorkerPlace place;
  place.progress("replay", "frame 0 noaa\n\x1b[2J");
  EXPECT_EQ(place.end_in_words({ChildOutcome::Kind::signalled, SIGKILL, "", "killed"}).find("; try"), std::string::npos)
      << "nobody's code did that";
  EXPECT_EQ(place.end_in_words({ChildOutcome::Kind::signalled, SIGKILL, "", "killed"}).find('\x1b'), std::string::npos)
      << "what a worker says is printed as text";
  EXPECT_EQ(place.end_in_words({ChildOutcome::Kind::exited, 4, "no device\n", "exit code 4"}),
            "exit code 4; its last words: no device");
  EXPECT_EQ(place.end_in_words({ChildOutcome::Kind::exited, 0, "a warning\n", ""}), "");
}

}  // namespace
}  // namespace subpixel::server
