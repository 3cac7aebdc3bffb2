#include "server/byte_range.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "base/numbers.hpp"
#include "server/http_error.hpp"

namespace subpixel::server {
namespace {

// Bytes `first` to `last`, to the end without `last`, or without `first` the last `last` bytes.
struct Wanted {
  std::optional<std::uint64_t> first, last;
};

// A single range of bytes; nothing for what is to be ignored.
std::optional<Wanted> parse_range(std::string_view text) {
  constexpr std::string_view kUnit = "bytes=";
  if (!text.starts_with(kUnit)) return std::nullopt;
  text.remove_prefix(kUnit.size());
  const std::size_t dash = text.find('-');
  if (dash == std::string_view::npos) return std::nullopt;
  const std::string_view before = text.substr(0, dash), after = text.substr(dash + 1);
  const Wanted wanted{parse_number<std::uint64_t>(before), parse_number<std::uint64_t>(after)};
  if ((!before.empty() && !wanted.first) || (!after.empty() && !wanted.last)) return std::nullopt;
  if (!wanted.first && !wanted.last) return std::nullopt;
  if (wanted.first && wanted.last && *wanted.first > *wanted.last) return std::nullopt;
  return wanted;
}

}  // namespace

std::optional<BytePart> choose_bytes(const httplib::Request& request, httplib::Response& response, std::uint64_t size,
                                     const std::string& tag) {
  response.headers.erase("Accept-Ranges");  // the default says none
  response.set_header("Accept-Ranges", "bytes");
  response.set_header("ETag", tag);
  if (request.get_header_value("If-None-Match").find(tag) != std::string::npos) {
    response.status = 304;
    return std::nullopt;
  }
  const BytePart whole{0, size};
  const bool changed = request.has_header("If-Range") && request.get_header_value("If-Range") != tag;
  if (request.method != "GET" || changed || request.get_header_value_count("Range") != 1) return whole;
  const std::optional<Wanted> wanted = parse_range(request.get_header_value("Range"));
  if (!wanted) return whole;
  const std::uint64_t first = wanted->first ? *wanted->first : size - std::min(size, *wanted->last);
  if (first >= size) {
    response.set_header("Content-Range", fmt::format("bytes */{}", size));
    write_error(response,
                HttpError(416, "the range is refused", fmt::format("there are {} bytes", size), "header Range"));
    return std::nullopt;
  }
  const std::uint64_t last = wanted->first && wanted->last ? std::min(*wanted->last, size - 1) : size - 1;
  response.status = 206;
  response.set_header("Content-Range", fmt::format("bytes {}-{}/{}", first, last, size));
  return BytePart{first, last - first + 1};
}

}  // namespace subpixel::server
