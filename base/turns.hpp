// So many threads at a time.
#pragma once

#include <semaphore.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace subpixel {

// A semaphore of the system's. That of the C++ library will not do: in GCC 12's a thread that waits can miss the
// others' ends and sleep for ever (bug 104928 there), which shows once in thousands of runs.
class Turns {
 public:
  // Throws std::runtime_error where there can't be one of `count`.
  explicit Turns(unsigned count) {
    if (::sem_init(&free_, 0, count) != 0) throw std::runtime_error(std::strerror(errno));
  }
  ~Turns() { ::sem_destroy(&free_); }
  Turns(const Turns&) = delete;
  Turns& operator=(const Turns&) = delete;

  // While it lives, the thread that made it has one of them.
  class Turn {
   public:
    explicit Turn(Turns& turns) : turns_(turns) {
      while (::sem_wait(&turns_.free_) != 0) {
      }  // a signal came
    }
    ~Turn() { ::sem_post(&turns_.free_); }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    Turns& turns_;
  };

 private:
  sem_t free_{};
};

}  // namespace subpixel
