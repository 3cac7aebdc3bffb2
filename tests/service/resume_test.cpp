// The service as a process of its own, ended in the middle of a run by SIGKILL and by SIGTERM.
#include <signal.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <random>
#include <set>

#include "tests/service/service_fixture.hpp"

namespace subpixel::tests {
namespace {

std::vector<std::string> lines_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// "frame/technique" of every stored result, the fake worker's form. Techniques are those of Client::start_run.
std::set<std::string> stored_results(Client& client, std::int64_t run) {
  std::set<std::string> stored;
  const json document = client.get("/api/runs/" + std::to_string(run) + "/results.json");
  for (const json& result : document.at("results")) {
    stored.insert(std::to_string(result.at("frame").get<int>()) + (result.at("technique") == "noaa" ? "/0" : "/1"));
  }
  return stored;
}

TEST(Resume, KilledServiceRepeatsNothingStoredAndLosesNothing) {
  const TemporaryFolder folder;
  const std::filesystem::path log = folder.path() / "data" / "cache" / "measured";
  std::int64_t run = 0;
  std::set<std::string> stored;
  {
    ServiceProcess service(folder.path() / "data");
    Client client(service.port());
    run = client.start_run(client.upload_fake({{"frames", 20}, {"result_ms", 15}, {"log", log.string()}}));
    while (stored.size() < 3) stored = stored_results(client, run);
    service.end(SIGKILL);
  }
  for (int kill = 0; kill < 5; ++kill) {
    const std::size_t measured_before = lines_of(log).size();
    ServiceProcess service(folder.path() / "data");
    Client client(service.port());
    const std::set<std::string> survived = stored_results(client, run);
    EXPECT_TRUE(std::ranges::includes(survived, stored)) << "a result that was read was lost";
    stored = survived;
    // At different moments of a result's way into the store.
    std::this_thread::sleep_for(std::chrono::milliseconds(60 + 7 * kill));
    stored.merge(stored_results(client, run));
    // A busy machine has no result yet by then, and three starts in a row without one end the run.
    while (kill == 2 && stored.size() <= survived.size()) stored.merge(stored_results(client, run));
    service.end(SIGKILL);
    const std::vector<std::string> measured = lines_of(log);
    for (std::size_t i = measured_before; i < measured.size(); ++i) {
      EXPECT_FALSE(survived.contains(measured[i])) << measured[i] << " was stored and measured again";
    }
  }
  ServiceProcess service(folder.path() / "data");
  Client client(service.port());
  const json ended = client.wait_for_end(run);
  EXPECT_EQ(ended.at("status"), "done") << ended;
  EXPECT_EQ(stored_results(client, run).size(), 40u);
  const std::vector<std::string> measured = lines_of(log);
  EXPECT_EQ(std::set<std::string>(measured.begin(), measured.end()).size(), 40u);
  EXPECT_LE(measured.size(), 40u + 6u) << "at most the result under way at each kill is measured again";
}

TEST(Resume, WorkersDieWithTheirService) {
  const TemporaryFolder folder;
  const std::filesystem::path log = folder.path() / "data" / "cache" / "measured";
  ServiceProcess service(folder.path() / "data");
  Client client(service.port());
  client.start_run(client.upload_fake({{"frames", 200}, {"result_ms", 15}, {"log", log.string()}}));
  while (lines_of(log).empty()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  service.end(SIGKILL);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const std::size_t measured = lines_of(log).size();
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(lines_of(log).size(), measured) << "the worker goes on without its service";
}

TEST(Resume, GracefulEndIsQuickAndResumed) {
  const TemporaryFolder folder;
  std::int64_t run = 0;
  {
    ServiceProcess service(folder.path() / "data");
    Client client(service.port());
    run = client.start_run(client.upload_fake({{"frames", 4}, {"result_ms", 100}}));
    while (client.get("/api/runs/" + std::to_string(run)).at("stored_results") < 1) {
    }
    std::thread follower([port = service.port(), run] {
      Client mine(port);
      mine.http().Get("/api/runs/" + std::to_string(run) + "/events", [](const char*, std::size_t) { return true; });
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(service.end(SIGTERM), 0);
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(4));
    follower.join();
  }
  ServiceProcess service(folder.path() / "data");
  Client client(service.port());
  EXPECT_EQ(client.wait_for_end(run).at("status"), "done");
}

TEST(Resume, GracefulEndWaitsForNobody) {
  const TemporaryFolder folder;
  std::int64_t run = 0;
  {
    ServiceProcess service(folder.path() / "data");
    Client client(service.port());
    run = client.start_run(client.upload_fake({{"frames", 1}, {"fail_at", 0}, {"how", "hang"}, {"times", 1}}));
    while (client.get("/api/runs/" + std::to_string(run)).at("progress").is_null()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    const int port = service.port();
    std::thread inspected([port] { Client(port).upload(fake_capture({{"how", "info_hang"}})); });
    std::thread uploading([port] {
      raw_exchange(port,
                   "POST /api/captures HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100000\r\n\r\nFAKE half of it");
    });
    std::thread follower([port, run] {
      Client mine(port);
      mine.http().Get("/api/runs/" + std::to_string(run) + "/events", [](const char*, std::size_t) { return true; });
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(service.end(SIGTERM), 0);
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
    for (std::thread* const thread : {&inspected, &uploading, &follower}) thread->join();
  }
  ServiceProcess service(folder.path() / "data");
  Client client(service.port());
  EXPECT_EQ(client.wait_for_end(run).at("status"), "done");
}

// The short form of scripts/kill_campaign.py.
TEST(Resume, KilledAtRandomMomentsARunEndsWithTheSameBits) {
  const TemporaryFolder folder;
  const json behaviour = {{"frames", 40}, {"result_ms", 4}};
  const auto images = [](const json& results) {
    std::map<std::string, std::string> by_result;
    for (const json& result : results.at("results")) {
      const std::string name =
          std::to_string(result.at("frame").get<int>()) + result.at("technique").get<std::string>();
      EXPECT_TRUE(by_result.emplace(name, result.at("images").dump()).second) << name << " is there twice";
    }
    return by_result;
  };
  std::mt19937 random(7);
  auto service = std::make_unique<ServiceProcess>(folder.path() / "data");
  auto client = std::make_unique<Client>(service->port());
  const std::string hash = client->upload_fake(behaviour);
  const json request = {{"capture", hash}, {"techniques", {"noaa", "msaa"}}, {"width", 32},
                        {"height", 18},    {"reference_samples", 64},        {"retries", 1000}};
  const auto start_run = [&] {
    const httplib::Result started = client->post_run(request);
    EXPECT_TRUE(started && started->status == 201);
    return json::parse(started->body).at("id").get<std::int64_t>();
  };
  const auto results_of = [&](std::int64_t run) {
    return client->get("/api/runs/" + std::to_string(run) + "/results.json");
  };
  const std::int64_t undisturbed = start_run();
  EXPECT_EQ(client->wait_for_end(undisturbed).at("status"), "done");
  const std::int64_t killed = start_run();
  int workers = 0, services = 0;
  for (int kill = 0; kill < 40; ++kill) {
    std::this_thread::sleep_for(std::chrono::milliseconds(random() % 30));
    if (random() % 3 != 0) {
      workers += service->kill_children();
      continue;
    }
    service->end(SIGKILL);
    ++services;
    service = std::make_unique<ServiceProcess>(folder.path() / "data");
    client = std::make_unique<Client>(service->port());
  }
  EXPECT_GT(workers, 5);
  EXPECT_GT(services, 5);
  const json ended = client->wait_for_end(killed);
  EXPECT_EQ(ended.at("status"), "done") << ended;
  EXPECT_EQ(ended.at("reason"), "");
  const auto expected = images(results_of(undisturbed));
  EXPECT_EQ(expected.size(), 80u);
  EXPECT_EQ(images(results_of(killed)), expected);
}

TEST(Resume, RunThatTakesTheServiceDownIsGivenUp) {
  const TemporaryFolder folder;
  std::int64_t run = 0;
  for (int start = 0; start < 3; ++start) {
    ServiceProcess service(folder.path() / "data");
    Client client(service.port());
    if (start == 0) run = client.start_run(client.upload_fake({{"frames", 1}, {"fail_at", 0}, {"how", "hang"}}));
    while (client.get("/api/runs/" + std::to_string(run)).at("status") != "running") {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    service.end(SIGKILL);
  }
  ServiceProcess service(folder.path() / "data");
  Client client(service.port());
  const json ended = client.wait_for_end(run);
  EXPECT_EQ(ended.at("status"), "failed");
  EXPECT_NE(ended.at("reason").get<std::string>().find("given up"), std::string::npos) << ended;
}

TEST(Resume, UnfinishedUploadsAndJobsAreRemovedAtTheStart) {
  const TemporaryFolder folder;
  const std::filesystem::path data = folder.path() / "data";
  std::filesystem::create_directories(data / "uploads");
  std::filesystem::create_directories(data / "jobs" / "7" / "out");
  std::ofstream(data / "uploads" / "upload-abc") << "half of it";
  const RunningService service(test_options(data));
  EXPECT_TRUE(std::filesystem::is_empty(data / "uploads"));
  EXPECT_TRUE(std::filesystem::is_empty(data / "jobs"));
}

}  // namespace
}  // namespace subpixel::tests
