// How a program ends for what it threw: the exit code scripts rely on, and one line for people.
#pragma once

#include <exception>
#include <string>

namespace subpixel {

// 0 is success and 1 a gate that failed (nightly, validate, advise, diff); neither is an exception.
enum ExitCode : int {
  kUsageExit = 2,      // the request itself is wrong
  kInputExit = 3,      // a file, its content or the room for it is wrong
  kDeviceExit = 4,     // the device, or the memory, can't do it
  kInternalExit = 70,  // a mistake of ours; EX_SOFTWARE of sysexits.h
};

struct Failure {
  ExitCode exit_code;
  std::string message;  // "what: why: where" in one line, without the program's name
};

// What UsageError, InputError and DeviceError say with their codes; the system's errors as InputError, a lack of memory
// as DeviceError. Everything else was not meant to get out and is ours: "internal error: ...: please report it".
Failure failure_of(const std::exception_ptr& exception);

}  // namespace subpixel
