#include "base/turns.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

namespace subpixel {
namespace {

TEST(Turns, ThereAreNeverMoreAtATimeAndAllComeThrough) {
  constexpr int kThreads = 8, kRounds = 2000;
  Turns turns(2);
  std::atomic<int> inside{0}, most{0}, done{0};
  std::vector<std::jthread> threads;
  for (int i = 0; i < kThreads; ++i) {
    threads.emplace_back([&] {
      for (int round = 0; round < kRounds; ++round) {
        const Turns::Turn turn(turns);
        const int now = ++inside;
        int before = most;
        while (before < now && !most.compare_exchange_weak(before, now)) {
        }
        ++done;
        --inside;
      }
    });
  }
  threads.clear();
  EXPECT_EQ(done, kThreads * kRounds);
  EXPECT_LE(most, 2);
  EXPECT_GE(most, 1);
}

TEST(Turns, EndsWithItsScope) {
  Turns turns(1);
  try {
    const Turns::Turn turn(turns);
    throw std::runtime_error("while it has one");
  } catch (const std::runtime_error&) {
  }
  const Turns::Turn again(turns);
  SUCCEED();
}

}  // namespace
}  // namespace subpixel
