#include <gtest/gtest.h>

#include "server/routes.hpp"

namespace subpixel::server {
namespace {

using Parts = std::vector<std::string>;

const std::string kHash = "0123456789abcdef0123456789abcdef";

TEST(RoutePaths, PartsAreThoseOfTheirNames) {
  EXPECT_EQ(path_parts("/api/runs", "/api/runs"), Parts{});
  EXPECT_EQ(path_parts("/api/runs/{run}", "/api/runs/17"), Parts{"17"});
  EXPECT_EQ(path_parts("/api/runs/{run}/results.csv", "/api/runs/0/results.csv"), Parts{"0"});
  EXPECT_EQ(path_parts("/api/captures/{hash}/file", "/api/captures/" + kHash + "/file"), Parts{kHash});
  EXPECT_EQ(path_parts("/api/nights/{night}/cells/{cell}", "/api/nights/3/cells/999999999999999999"),
            (Parts{"3", "999999999999999999"}));
}

TEST(RoutePaths, OthersAreNone) {
  const std::string run = "/api/runs/{run}", hash = "/api/captures/{hash}";
  for (const std::string path : {"", "/", "/api/runs", "/api/runs/", "/api/runs/17/", "/api/runs/17/x", "/api/runs/1a",
                                 "/api/runs/-1", "/api/runs/+1", "/api/runs/ 1", "/api/runs/1.5", "/api/runs/17.",
                                 "/api/runs/1234567890123456789", "/api/runs/{run}", "x/api/runs/17", "/API/runs/17"})
    EXPECT_FALSE(path_parts(run, path)) << path;
  EXPECT_FALSE(path_parts(run, std::string("/api/runs/1\0", 12)));
  EXPECT_FALSE(path_parts(run, "/api/runs/1\n"));
  for (const char* wrong : {"0123456789abcdef0123456789abcde", "0123456789abcdef0123456789abcdef0",
                            "A123456789abcdef0123456789abcdef", "g123456789abcdef0123456789abcdef"})
    EXPECT_FALSE(path_parts(hash, std::string("/api/captures/") + wrong)) << wrong;
  EXPECT_FALSE(path_parts("/api/runs/{run}/results.csv", "/api/runs/1/resultsxcsv"));
  EXPECT_FALSE(path_parts("/api/runs", "/api/runs/1"));
}

TEST(RoutePaths, HeadIsFoundAsGet) {
  Routes routes;
  const auto nothing = [](const httplib::Request&, httplib::Response&) {};
  routes.add({.method = "GET", .path = "/api/runs/{run}", .id = "get_run"}, nothing);
  routes.add({.method = "DELETE", .path = "/api/runs/{run}", .id = "delete_run"}, nothing);
  EXPECT_EQ(routes.find("HEAD", "/api/runs/1").route, routes.all().data());
  const Routes::Found found = routes.find("DELETE", "/api/runs/21");
  EXPECT_EQ(found.route, &routes.all()[1]);
  EXPECT_EQ(found.parts, Parts{"21"});
  EXPECT_EQ(routes.find("POST", "/api/runs/1").route, nullptr);
  EXPECT_EQ(routes.find("POST", "/api/runs/1").handler, nullptr);
}

}  // namespace
}  // namespace subpixel::server
