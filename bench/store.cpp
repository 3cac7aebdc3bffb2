// The store at the size of a studio's year: inserts, a night's page, a cell over all nights, and gc, of a store with so
// many results and blobs. docs/scaling.md has the figures.
//
//   subpixel_bench_store FOLDER [--results 10000000] [--blobs 1000000] [--night 10000] [--outside BYTES]
//
// The store is filled by SQL without syncing, one night copied again and again, and kept in FOLDER: a second call
// measures it as it is. Ten million results take about 25 GB.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <functional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/hash.hpp"
#include "base/numbers.hpp"
#include "server/nightly/night_store.hpp"
#include "server/store/store_access.hpp"
#include "server/store/upkeep.hpp"

namespace {

using namespace subpixel;
using namespace subpixel::server;
namespace fs = std::filesystem;

constexpr std::uint32_t kTechniques = 25, kFrames = 2, kRoles = 4;

struct Sizes {
  std::int64_t results = 10'000'000, blobs = 1'000'000, night = 10'000;
  std::optional<std::uint64_t> outside;
};

double seconds_of(const std::function<void()>& what) {
  const auto begin = std::chrono::steady_clock::now();
  what();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double median_of(int times, const std::function<void()>& what) {
  std::vector<double> all;
  all.reserve(static_cast<std::size_t>(times));
  for (int i = 0; i < times; ++i) all.push_back(seconds_of(what));
  std::ranges::sort(all);
  return all[all.size() / 2];
}

// As large as those of real replays, 2.2 KB as JSON.
replay::FrameResult some_result(std::uint32_t frame, const std::string& technique) {
  replay::FrameResult result;
  result.frame = frame;
  result.technique = technique;
  result.samples = 8;
  result.width = 1280;
  result.height = 720;
  result.ms.total_ms = 123.456789;
  for (int i = 0; i < 12; ++i) result.ms.passes.push_back({fmt::format("pass number {}", i), 10.123456789 * i});
  for (int i = 0; i < 9; ++i) result.shading.histogram.push_back(static_cast<std::uint64_t>(i) * 12345);
  for (int i = 0; i < 8; ++i) result.shading.fragments[fmt::format("fragments of pass {}", i)] = 1234567;
  for (int i = 0; i < 8; ++i) result.counters[fmt::format("some_counter_{}", i)] = 7654321;
  result.error.mse = 1.23456789e-5;
  return result;
}

void fill(const fs::path& file, const Sizes& sizes) {
  Store store(file);
  NightStore nights(store);
  const auto captures = static_cast<std::uint32_t>(sizes.night / (kTechniques * kFrames));
  NightRecord record;
  record.name = "large";
  record.config = nlohmann::json::object();
  const std::int64_t first = nights.add(record);
  const Store::WriteLease writer = store.write();
  const Connection& c = writer.connection();
  c.execute("PRAGMA synchronous = OFF; PRAGMA cache_size = -1000000; PRAGMA wal_autocheckpoint = 100000");
  c.execute("BEGIN");
  // Images of 2 KB: what blobs cost a store is their number here; docs/scaling.md reckons with their real sizes.
  {
    std::mt19937_64 random(1);
    std::vector<std::uint64_t> words(250);
    for (std::int64_t i = 0; i < sizes.blobs; ++i) {
      std::ranges::generate(words, std::ref(random));
      const auto bytes = std::as_bytes(std::span(words));
      const std::string hash = content_hash_hex(bytes);
      Statement(c, "INSERT INTO blobs (hash, media_type, bytes) VALUES (?, 'image/png', ?)")
          .bind(hash)
          .bind(bytes)
          .run();
    }
  }
  c.execute(
      "CREATE TEMP TABLE some (i INTEGER PRIMARY KEY, hash TEXT); INSERT INTO some SELECT row_number() OVER () - 1, "
      "hash FROM blobs");
  for (std::uint32_t capture = 0; capture < captures; ++capture) {
    replay::ResultsHead head;
    head.cpu_model = "bench";
    Statement(
        c,
        "INSERT INTO night_captures (night, ordinal, name, source, hash, problem, head) VALUES (?, ?, ?, '', ?, '', ?)")
        .bind(first)
        .bind(std::int64_t{capture})
        .bind(fmt::format("capture {}", capture))
        .bind(fmt::format("{:032x}", capture))
        .bind(replay::to_json(head).dump())
        .run();
    for (std::uint32_t technique = 0; technique < kTechniques; ++technique) {
      const std::string name = fmt::format("technique{}", technique);
      Statement(
          c,
          "INSERT INTO night_cells (night, capture, technique, status, gates, time) VALUES (?, ?, ?, 'passed', ?, ?)")
          .bind(first)
          .bind(std::int64_t{capture})
          .bind(name)
          .bind(std::string(
              R"([{"gate":"memory","outcome":"passed","detail":""},{"gate":"images","outcome":"passed","detail":""}])"))
          .bind(std::string(R"({"ms":12.5,"spread":0.5,"references":{"msaa":{"ms":50.5,"spread":1}}})"))
          .run();
      const std::int64_t cell = c.last_insert_id();
      for (std::uint32_t frame = 0; frame < kFrames; ++frame) {
        Statement(c, "INSERT INTO night_frames (cell, frame, document) VALUES (?, ?, ?)")
            .bind(cell)
            .bind(std::int64_t{frame})
            .bind(replay::to_json(some_result(frame, name)).dump())
            .run();
      }
    }
  }
  c.execute("COMMIT");
  const std::int64_t cells = sizes.night / kFrames;
  const std::int64_t count = sizes.results / sizes.night;
  const auto images = [&](std::int64_t night_number, std::int64_t low, std::int64_t high) {
    c.execute(
        fmt::format("INSERT INTO night_images (frame, role, blob) SELECT f.id, 'role' || r.value, (SELECT hash FROM "
                    "some WHERE i = ((f.id * {} + r.value + {}) % {})) FROM night_frames f, json_each('[0,1,2,3]') r "
                    "WHERE f.id BETWEEN {} AND {}",
                    kRoles, night_number * 97, sizes.blobs, low, high));
  };
  images(0, 1, sizes.night);
  for (std::int64_t night = 1; night < count; ++night) {
    c.execute("BEGIN");
    c.execute(fmt::format(
        "INSERT INTO nights (name, status, started_utc, finished_utc, build, config, baseline_night) SELECT "
        "'large', 'passed', '2025-01-01T00:00:00.000Z', '2025-01-01T01:00:00.000Z', 'bench', '{{}}', {}",
        first));
    const std::int64_t id = c.last_insert_id();
    c.execute(fmt::format(
        "INSERT INTO night_captures (night, ordinal, name, source, hash, problem, head) SELECT {}, ordinal, name, "
        "source, hash, problem, head FROM night_captures WHERE night = {}",
        id, first));
    c.execute(fmt::format(
        "INSERT INTO night_cells (id, night, capture, technique, status, gates, time) SELECT id + {}, {}, capture, "
        "technique, status, gates, time FROM night_cells WHERE night = {}",
        night * cells, id, first));
    c.execute(fmt::format(
        "INSERT INTO night_frames (id, cell, frame, document) SELECT id + {}, cell + {}, frame, document FROM "
        "night_frames WHERE id <= {}",
        night * sizes.night, night * cells, sizes.night));
    images(night, night * sizes.night + 1, (night + 1) * sizes.night);
    c.execute("COMMIT");
    if (night % 50 == 0) fmt::print(stderr, "{} of {} nights\r", night, count);
  }
  c.execute(fmt::format("UPDATE nights SET status = 'passed', finished_utc = started_utc WHERE id = {}", first));
  c.execute("PRAGMA wal_checkpoint(TRUNCATE)");
}

void line(const char* what, double seconds, const std::string& note, double goal) {
  fmt::print("| {} | {:.3f} | {:.2f} | {} | {} |\n", what, seconds, goal, seconds <= goal ? "yes" : "no", note);
}

void measure(const fs::path& root, const Sizes& sizes) {
  const DataFolder folder(root, DataFolder::Claim::night);
  const std::uint64_t bytes = fs::file_size(folder.store());
  Store store(folder.store());
  NightStore nights(store);
  std::int64_t rows = 0, blobs = 0, newest = 0;
  {
    const Store::ReadLease reader = store.read();
    Statement count(
        reader.connection(),
        "SELECT (SELECT max(id) FROM night_frames), (SELECT count(*) FROM blobs), (SELECT max(id) FROM nights)");
    count.step();
    rows = count.integer();
    blobs = count.integer();
    newest = count.integer();
  }
  fmt::print("{} results, {} blobs, {:.1f} GB\n\n| what | s | goal | met | |\n| --- | --- | --- | --- | --- |\n", rows,
             blobs, static_cast<double>(bytes) / 1e9);

  std::mt19937 random(1);
  const auto some_bytes = [&](std::size_t size) {
    std::string text(size, '\0');
    for (char& each : text) each = static_cast<char>(random());
    return text;
  };
  NightRecord record;
  record.name = "new";
  record.config = nlohmann::json::object();
  const std::int64_t night = nights.add(record);
  nights.add_capture(night, 0, {.name = "one", .source = "", .hash = std::string(32, 'e'), .problem = ""});
  NightCell cell;
  cell.technique = "noaa";
  const std::int64_t cell_id = nights.add_cell(night, cell);
  std::uint32_t frame = 0;
  for (const std::size_t size : {std::size_t{20'000}, std::size_t{2'000'000}}) {
    std::vector<std::map<std::string, Blob>> images(100);
    for (auto& each : images) {
      for (std::uint32_t role = 0; role < kRoles; ++role)
        each[fmt::format("role{}", role)] = {"image/png", some_bytes(size)};
    }
    const double took = seconds_of([&] {
      for (const auto& each : images) nights.add_frame(cell_id, some_result(frame++, "noaa"), each);
    });
    line("insert of a result", took / 100,
         fmt::format("with {} images of {} KB, durable: {:.0f}/s, {:.0f} MB/s", kRoles, size / 1000, 100 / took,
                     static_cast<double>(size * kRoles * 100) / took / 1e6),
         size > 100'000 ? 0.2 : 0.05);
  }
  nights.finish(night, NightStatus::passed, "");
  line("list of 20 nights", median_of(3, [&] { nights.nights(20, 0, "large"); }), "", 2.0);
  line("a night's page", median_of(5, [&] { nights.night(newest - 7, false); }),
       fmt::format("{} cells", sizes.night / kFrames), 0.5);
  line("a night with all frames", median_of(3, [&] { nights.night(newest - 9, true); }), "as judging needs it", 5);
  {
    const Store::ReadLease reader = store.read();
    const std::int64_t some_cell = 1234;
    line("a cell", median_of(5, [&] { nights.cell(some_cell); }), "", 0.1);
    std::int64_t points = 0;
    line("a cell over all nights",
         median_of(3,
                   [&] {
                     points = 0;
                     Statement trend(reader.connection(),
                                     "SELECT n.id, c.time, f.document FROM nights n JOIN night_captures k ON k.night = "
                                     "n.id AND k.name = ? "
                                     "JOIN night_cells c ON c.night = n.id AND c.capture = k.ordinal AND c.technique = "
                                     "? JOIN night_frames f "
                                     "ON f.cell = c.id WHERE n.name = 'large' ORDER BY n.id");
                     trend.bind("capture 17").bind("technique3");
                     while (trend.step()) ++points;
                   }),
         fmt::format("points: {}", rows / sizes.night * kFrames), 2);
  }
  line("/metrics", median_of(3, [&] { store.gauges(); }), "", 1);
  Retention retention;
  retention.count = static_cast<std::uint32_t>(rows / sizes.night - 10);
  const CacheCheck any = [](const fs::path&) { return true; };
  Freed freed;
  line("gc, dry run", seconds_of([&] { freed = collect_garbage(folder, store, retention, true, any); }),
       fmt::format("{} nights, {} blobs would go", freed.nights, freed.blobs), 120);
  line("gc", seconds_of([&] { freed = collect_garbage(folder, store, retention, false, any); }),
       fmt::format("{} nights, {} blobs gone", freed.nights, freed.blobs), 240);
  line("the end of a night with `keep`", seconds_of([&] { nights.drop_old("large", retention.count.value() - 1); }),
       "one night and its blobs go", 30);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    Sizes sizes;
    if (argc < 2) throw UsageError("bench", "expected a folder", "command line");
    for (int i = 2; i + 1 < argc; i += 2) {
      const auto value = parse_number<std::int64_t>(argv[i + 1]);
      if (!value || *value < 1) throw UsageError("bench", "expected a number", argv[i]);
      if (std::strcmp(argv[i], "--results") == 0) sizes.results = *value;
      if (std::strcmp(argv[i], "--blobs") == 0) sizes.blobs = *value;
      if (std::strcmp(argv[i], "--night") == 0) sizes.night = *value;
      if (std::strcmp(argv[i], "--outside") == 0) sizes.outside = static_cast<std::uint64_t>(*value);
    }
    const fs::path root = argv[1];
    const fs::path file = root / "subpixel.sqlite";
    if (!fs::exists(file)) {
      { const DataFolder folder(root, DataFolder::Claim::service); }
      fmt::print(stderr, "filled in {:.0f} s\n", seconds_of([&] { fill(file, sizes); }));
    }
    const Moved moved = place_blobs(DataFolder(root, DataFolder::Claim::upkeep), sizes.outside);
    if (moved.out + moved.in > 0) fmt::print(stderr, "moved {} blobs out, {} in\n", moved.out, moved.in);
    measure(root, sizes);
  } catch (const std::exception& error) {
    fmt::print(stderr, "subpixel_bench_store: {}\n", error.what());
    return 3;
  }
  return 0;
}
