#include "base/failure.hpp"

#include <filesystem>
#include <new>
#include <string_view>
#include <system_error>

#include "base/error.hpp"
#include "base/printable.hpp"

namespace subpixel {
namespace {

Failure internal(std::string_view why) {
  return {kInternalExit, "internal error: " + joined_lines(why) + ": please report it"};
}

}  // namespace

Failure failure_of(const std::exception_ptr& exception) {
  try {
    std::rethrow_exception(exception);
  } catch (const UsageError& error) {
    return {kUsageExit, error.what()};
  } catch (const InputError& error) {
    return {kInputExit, error.what()};
  } catch (const DeviceError& error) {
    return {kDeviceExit, error.what()};
  } catch (const InternalError& error) {
    return {kInternalExit, error.what()};
  } catch (const std::bad_alloc&) {
    return {kDeviceExit, "memory: there is not enough"};
  } catch (const std::filesystem::filesystem_error& error) {
    return {kInputExit, InputError("file system", error.code().message(), error.path1().string()).what()};
  } catch (const std::system_error& error) {
    return {kInputExit, InputError("system", error.code().message(), "").what()};
  } catch (const std::exception& error) {
    return internal(error.what());
  } catch (...) {
    return internal("an exception without a description");
  }
}

}  // namespace subpixel
