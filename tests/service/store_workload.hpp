// What a service does to its store, step by step, each of which is one commit; and what a store holds, as one text.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "server/store/store.hpp"
#include "tests/service/service_fixture.hpp"

namespace subpixel::tests {

inline server::CaptureRecord stored_capture(char digit) {
  server::CaptureRecord capture;
  capture.hash = std::string(32, digit);
  capture.name = "a'); DROP TABLE captures; --";
  capture.uploaded_utc = "2025-01-31T12:00:00.000Z";
  capture.frame_count = 2;
  capture.summary = json::object();
  return capture;
}

inline replay::ReplayOptions stored_options() {
  replay::ReplayOptions options;
  options.techniques = {{"noaa", {}}, {"msaa", {{"samples", 8}}}};
  options.frames = {0, 1};
  return options;
}

inline replay::FrameResult stored_result(std::uint32_t frame, const std::string& technique) {
  replay::FrameResult result;
  result.frame = frame;
  result.technique = technique;
  result.ms.passes = {{"set-up", 1.5}, {"shade", 2.5}};
  result.ms.total_ms = 4;
  return result;
}

// `folder` as `healthy` is, and then harmed.
inline void harm_a_copy(const std::filesystem::path& healthy, const std::filesystem::path& folder,
                        const std::function<void()>& harm) {
  std::filesystem::remove_all(folder);
  std::filesystem::copy(healthy, folder, std::filesystem::copy_options::recursive);
  harm();
}

// An image of so many bytes that no two numbers share.
inline server::Blob stored_image(std::size_t size, int number) {
  return {"image/png", std::to_string(number) + std::string(size, static_cast<char>('a' + number))};
}

// The numbers of runs are 1 and 2: the first in the store.
inline std::vector<std::function<void(server::Store&)>> store_workload(std::size_t image_bytes) {
  using server::Store;
  const auto result = [image_bytes](std::uint32_t frame, std::uint32_t ordinal, int number) {
    return [=](Store& store) {
      store.add_result(
          1, ordinal, stored_result(frame, ordinal == 0 ? "noaa" : "msaa"),
          {{"image", stored_image(image_bytes, number)}, {"error", stored_image(image_bytes, number + 1)}});
    };
  };
  return {[](Store& store) { store.add_capture(stored_capture('a')); },
          [](Store& store) { store.add_capture(stored_capture('b')); },
          [](Store& store) {
            store.set_tags(std::string(32, 'a'), {"nightly", "second"});
          },
          [](Store& store) { store.add_run(server::RunKind::run, std::string(32, 'a'), stored_options(), 4); },
          [](Store& store) { store.start_next_run(); },
          result(0, 0, 0),
          result(0, 1, 2),
          result(1, 0, 4),
          result(1, 1, 6),
          [](Store& store) {
            store.set_head(1, {{"driver", "none"}});
          },
          [](Store& store) { store.finish_run(1, server::RunStatus::done, ""); },
          [](Store& store) { store.add_run(server::RunKind::run, std::string(32, 'b'), stored_options(), 4); },
          [](Store& store) { store.cancel_queued(2); },
          [](Store& store) { store.delete_run(1); },
          [](Store& store) { store.delete_capture(std::string(32, 'b')); }};
}

// All of it that is not a time.
inline std::string contents(const std::filesystem::path& file) {
  const server::Connection connection(file);
  std::string text;
  for (const char* const sql :
       {"SELECT hash || (thumbnail IS NULL) FROM captures ORDER BY hash",
        "SELECT capture || tag FROM capture_tags ORDER BY capture, tag",
        "SELECT id || status || starts_without_result || coalesce(head, '') FROM runs ORDER BY id",
        "SELECT run || '/' || ordinal || technique || parameters FROM run_techniques ORDER BY run, ordinal",
        "SELECT run || '/' || sequence || document FROM frame_results ORDER BY run, sequence",
        "SELECT result || name || median_ms FROM pass_times ORDER BY result, ordinal",
        "SELECT result || role || blob FROM images ORDER BY result, role",
        "SELECT hash || coalesce(outside, length(bytes)) FROM blobs ORDER BY hash"}) {
    server::Statement select(connection, sql);
    while (select.step()) text += select.text() + "\n";
    text += "--\n";
  }
  return text;
}

}  // namespace subpixel::tests
