// The errors a caller can act on; base/failure.hpp has the exit code of each.
#pragma once

#include <stdexcept>
#include <string>

namespace subpixel {

// Every message reads "what: why: where"; `where` names an offset, chunk, field, parameter or path.
class Error : public std::runtime_error {
 public:
  Error(const std::string& what, const std::string& why, const std::string& where)
      : std::runtime_error(where.empty() ? what + ": " + why : what + ": " + why + ": " + where) {}
};

class UsageError : public Error {  // the request itself is wrong
  using Error::Error;
};
class InputError : public Error {  // a file or its content is wrong
  using Error::Error;
};
class DeviceError : public Error {  // the device can't do it
  using Error::Error;
};

// A mistake of ours that another process of ours reports; what is thrown in this one is of the standard's types.
class InternalError : public Error {
  using Error::Error;
};

}  // namespace subpixel
