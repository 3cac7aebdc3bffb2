// Nights over a store of the test's own, replayed by the fake worker.
#pragma once

#include <algorithm>
#include <fstream>

#include "server/nightly/config.hpp"
#include "server/nightly/night_store.hpp"
#include "server/nightly/run_night.hpp"
#include "server/store/store.hpp"
#include "tests/service/service_fixture.hpp"

namespace subpixel::tests {

class Nights : public ServiceTest {
 protected:
  std::filesystem::path data() const { return folder() / "data"; }
  std::filesystem::path tweak_file() const { return data() / "cache" / "tweak.json"; }  // where workers may read
  void tweak(const json& change) const { std::ofstream(tweak_file()) << change; }

  std::filesystem::path a_capture(json behaviour = json::object(), const std::filesystem::path& tweaked = {}) const {
    behaviour["tweak"] = tweaked.empty() ? tweak_file().string() : tweaked.string();
    behaviour["frames"] = 2;
    std::filesystem::path path = folder() / "one.spcap";
    std::ofstream(path, std::ios::binary) << fake_capture(behaviour);
    return path;
  }

  static json config(const json& captures) {
    return {{"name", "test"},
            {"techniques", "noaa,msaa:samples=4|8"},
            {"size", {32, 18}},
            {"frames", {0, 1}},
            {"reference_samples", 64},
            {"captures", captures},
            {"gates", {{"error", {{"mse", {{"relative", 0.01}}}}}}}};
  }

  server::NightRecord night(const json& document, const std::string& commit = "") const {
    const server::DataFolder claimed(data(), server::DataFolder::Claim::night);
    server::Store store(claimed.store());
    server::NightOptions options;
    options.worker = SUBPIXEL_FAKE_WORKER;
    options.commit = commit;
    options.progress = [this](const std::string& line) { progress_.push_back(line); };
    return run_night(server::parse_nightly_config(document.dump(), folder()), claimed, store, options);
  }
  server::NightRecord one_capture_night() const { return night(config({{{"path", "one.spcap"}}})); }

  bool approve(std::int64_t id) const {
    server::Store store(data() / "subpixel.sqlite");
    return server::NightStore(store).set_baseline("test", id);
  }

  static const server::NightCell& cell(const server::NightRecord& night, const std::string& technique) {
    for (const server::NightCell& cell : night.cells) {
      if (cell.technique == technique) return cell;
    }
    throw std::runtime_error("no cell " + technique);
  }
  static std::vector<std::string> failed_gates(const server::NightCell& cell) {
    std::vector<std::string> failed;
    for (const server::GateResult& gate : cell.gates) {
      if (gate.outcome == server::GateOutcome::failed) failed.push_back(gate.gate);
    }
    return failed;
  }

  mutable std::vector<std::string> progress_;
};

}  // namespace subpixel::tests
