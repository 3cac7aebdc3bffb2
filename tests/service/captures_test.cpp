// Uploads: what is stored, what is refused, and that nothing is left behind.
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include <fstream>

#include "tests/service/service_fixture.hpp"
#include "tests/unit/capture_forgery.hpp"

namespace subpixel::tests {
namespace {

namespace fs = std::filesystem;

std::size_t files_in(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

using Captures = ServiceTest;

TEST_F(Captures, UploadIsStoredByContentAndListed) {
  const std::string bytes = fake_capture({{"title", "A meadow"}, {"frames", 7}});
  const httplib::Result result = client().upload(bytes, "meadow.spcap");
  ASSERT_TRUE(result);
  ASSERT_EQ(result->status, 201) << result->body;
  const json capture = json::parse(result->body);
  const std::string hash = capture.at("hash");
  EXPECT_EQ(result->get_header_value("Location"), "/api/captures/" + hash);
  EXPECT_EQ(capture.at("title"), "A meadow");
  EXPECT_EQ(capture.at("name"), "meadow.spcap");
  EXPECT_EQ(capture.at("frame_count"), 7);
  EXPECT_EQ(capture.at("size_bytes"), bytes.size());
  EXPECT_EQ(capture.at("features"), json({"textures", "alpha test"}));

  EXPECT_EQ(client().get("/api/captures").at("captures").size(), 1u);
  EXPECT_EQ(client().get("/api/captures/" + hash).at("summary").at("frame_count"), 7);
  const httplib::Result file = client().http().Get("/api/captures/" + hash + "/file");
  ASSERT_TRUE(file);
  EXPECT_EQ(file->body, bytes);
  EXPECT_EQ(files_in(folder() / "data" / "uploads"), 0u);
}

// What the reader left out is said by the real program, and goes through to who asks: chunks of kinds that a later
// program may have written among the notices of the recorder.
TEST_F(Captures, NoticesOfTheReaderAndTheRecorderAreInTheSummary) {
  server::ServiceOptions real = options();
  real.worker.program = SUBPIXEL_BINARY;
  start(real);
  capture::Capture recorded = capture::version_2_capture();
  recorded.metadata.notices = {"left out: <b>decals</b>"};
  recorded.frames[0].draws[1].index_count = 0;
  recorded.frames[0].draws[1].topology = capture::Topology::triangle_strip;  // a version that skips
  recorded.frames.push_back(recorded.frames[0]);
  capture::Forgery forgery(recorded);
  forgery.set_type(capture::ChunkType::frame, 2, capture::four_cc("ZXXX"));
  const auto* const bytes = reinterpret_cast<const char*>(forgery.bytes().data());
  const httplib::Result result = client().upload(std::string(bytes, forgery.bytes().size()));
  ASSERT_TRUE(result);
  ASSERT_EQ(result->status, 201) << result->body;
  const std::string hash = json::parse(result->body).at("hash");
  const json summary = client().get("/api/captures/" + hash).at("summary");
  EXPECT_EQ(summary.at("frame_count"), 2);
  EXPECT_EQ(summary.at("notices"), (json{"left out: <b>decals</b>",
                                         "skipped on reading, of kinds that this program does not know: chunks ZXXX"}));
}

TEST_F(Captures, SameFileTwiceIsOne) {
  const std::string bytes = fake_capture({{"frames", 1}});
  EXPECT_EQ(client().upload(bytes, "first")->status, 201);
  const httplib::Result again = client().upload(bytes, "second");
  EXPECT_EQ(again->status, 200);
  EXPECT_EQ(json::parse(again->body).at("name"), "first");
  EXPECT_EQ(client().get("/api/captures").at("total"), 1);
  EXPECT_EQ(files_in(folder() / "data" / "captures"), 1u);
}

TEST_F(Captures, SameFileFromManySidesAtOnceIsOne) {
  client();
  const std::string bytes = fake_capture({{"frames", 1}});
  std::vector<std::thread> senders;
  std::atomic<int> created{0}, known{0};
  senders.reserve(8);
  for (int i = 0; i < 8; ++i) {
    senders.emplace_back([&] {
      Client mine(port());
      const httplib::Result result = mine.upload(bytes);
      if (result && result->status == 201) ++created;
      if (result && result->status == 200) ++known;
    });
  }
  for (std::thread& sender : senders) sender.join();
  EXPECT_EQ(created, 1);
  EXPECT_EQ(known, 7);
  EXPECT_EQ(files_in(folder() / "data" / "captures"), 1u);
  EXPECT_EQ(files_in(folder() / "data" / "uploads"), 0u);
}

// A file that has the hash of another one is refused, not mixed up with it. The collision is made on the disk.
TEST_F(Captures, HashCollisionIsRefused) {
  const std::string bytes = fake_capture({{"frames", 1}});
  const std::string hash = json::parse(client().upload(bytes)->body).at("hash");
  std::ofstream(folder() / "data" / "captures" / (hash + ".spcap"), std::ios::binary) << "something else";
  EXPECT_EQ(error_of(client().upload(bytes), 409).at("where"), hash);
}

TEST_F(Captures, ThumbnailFollowsTheUpload) {
  const std::string hash = client().upload_fake({{"frames", 3}});
  json thumbnail;
  for (int i = 0; i < 500 && thumbnail.is_null(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    thumbnail = client().get("/api/captures/" + hash).at("thumbnail");
  }
  ASSERT_TRUE(thumbnail.is_string());
  const httplib::Result image = client().http().Get("/api/blobs/" + thumbnail.get<std::string>());
  EXPECT_EQ(image->get_header_value("Content-Type"), "image/png");
  EXPECT_TRUE(client().get("/api/runs").at("runs").empty()) << "the service's own runs are not the user's";
}

TEST_F(Captures, ForeignFileIsRefusedWithTheReadersReason) {
  const json error = error_of(client().upload("\x7f"
                                              "ELF, not a capture"),
                              422);
  EXPECT_NE(error.at("why").get<std::string>().find("does not begin as one"), std::string::npos) << error;
  EXPECT_EQ(error.dump().find(folder().string()), std::string::npos) << "the server's paths are its own business";
  EXPECT_EQ(files_in(folder() / "data" / "captures"), 0u);
  EXPECT_EQ(files_in(folder() / "data" / "uploads"), 0u);
}

TEST_F(Captures, FileThatCrashesTheReaderEndsOnlyTheReader) {
  const json error = error_of(client().upload(fake_capture({{"how", "info_kill"}})), 422);
  EXPECT_NE(error.at("why").get<std::string>().find("signal 9"), std::string::npos) << error;
  EXPECT_EQ(client().get("/api/health").at("status"), "ok");
}

TEST_F(Captures, MistakeOfTheReadersIsNotTheFiles) {
  const json error = error_of(client().upload(fake_capture({{"how", "info_internal"}})), 500);
  EXPECT_NE(error.dump().find("please report it"), std::string::npos) << error;
}

TEST_F(Captures, PixelsStoryIsToldByAProcessOfItsOwn) {
  const std::string hash = client().upload_fake({{"frames", 1}});
  const std::string path =
      "/api/captures/" + hash + "/pixel?technique=streaming:surfaces%3D2&x=1&y=2&frame=0&point_lights=3";
  const json story = client().get(path);
  const json& arguments = story.at("arguments");
  for (const char* wanted : {"--technique=streaming:surfaces=2", "--at=1,2", "--frame=0", "--lights=3"})
    EXPECT_NE(std::find(arguments.begin(), arguments.end(), wanted), arguments.end()) << wanted << arguments;
  const json refused =
      error_of(client().http().Get(("/api/captures/" + hash + "/pixel?technique=msaa&x=4001&y=2")), 400);
  EXPECT_NE(refused.at("why").get<std::string>().find("not within"), std::string::npos) << refused;
  error_of(client().http().Get("/api/captures/" + hash + "/pixel?technique=msaa&x=-1&y=2"), 400);
  error_of(client().http().Get("/api/captures/" + std::string(32, 'a') + "/pixel?technique=msaa&x=1&y=2"), 404);
  const std::string fatal = client().upload_fake({{"frames", 1}, {"how", "pixel_kill"}});
  const json ended = error_of(client().http().Get("/api/captures/" + fatal + "/pixel?technique=msaa&x=1&y=2"), 422);
  EXPECT_NE(ended.at("why").get<std::string>().find("signal 9"), std::string::npos) << ended;
  EXPECT_EQ(client().get("/api/health").at("status"), "ok");
}

TEST_F(Captures, FrameIsShownByAProcessOfItsOwn) {
  const std::string hash = client().upload_fake({{"frames", 2}});
  const std::string path = "/api/captures/" + hash + "/frame";
  const json view = client().get(path + "?frame=1&width=40&height=20");
  EXPECT_EQ(view.at("frame"), 1);
  EXPECT_EQ(view.at("size"), (json{40, 20}));
  EXPECT_EQ(view.at("draws").size(), 2u);
  std::uint64_t pixels = 0;
  for (std::size_t i = 1; i < view.at("seen").size(); i += 2) pixels += view["seen"][i].get<std::uint64_t>();
  EXPECT_EQ(pixels, 40u * 20u);
  EXPECT_FALSE(view.contains("title")) << "the summary is the capture's";
  EXPECT_EQ(client().get(path).at("size"), (json{640, 360}));
  EXPECT_EQ(client().http().Get(path)->get_header_value("Cache-Control"), "private, max-age=600");
  EXPECT_NE(error_of(client().http().Get(path + "?frame=4001"), 400).at("why").get<std::string>().find("not within"),
            std::string::npos);
  for (const char* refused : {"?width=0", "?height=0", "?width=2049", "?height=2049", "?frame=-1", "?frame=one"}) {
    error_of(client().http().Get(path + refused), 400);
  }
  error_of(client().http().Get("/api/captures/" + std::string(32, 'a') + "/frame"), 404);
  const std::string fatal = client().upload_fake({{"frames", 1}, {"how", "view_kill"}});
  const json ended = error_of(client().http().Get("/api/captures/" + fatal + "/frame"), 422);
  EXPECT_NE(ended.at("why").get<std::string>().find("signal 9"), std::string::npos) << ended;
  EXPECT_EQ(client().get("/api/health").at("status"), "ok");
}

TEST_F(Captures, AViewWithoutDrawsIsTheWorkersMistake) {
  const std::string hash = client().upload_fake({{"frames", 1}, {"how", "view_without_draws"}});
  EXPECT_EQ(error_of(client().http().Get("/api/captures/" + hash + "/frame"), 500).at("why"),
            "the worker's document has no draws");
}

// A document that deep ends whoever writes it by recursion.
TEST_F(Captures, NestedViewsAreTheWorkersMistakeAndNotTheServersEnd) {
  const std::string path = "/api/captures/" + client().upload_fake({{"frames", 1}, {"how", "view_nested"}}) + "/frame";
  EXPECT_EQ(error_of(client().http().Get(path), 500).at("what"), "the frame is not shown");
  EXPECT_EQ(client().get("/api/health").at("status"), "ok");
}

TEST_F(Captures, OneStoryOrViewAtATime) {
  const std::string hash = client().upload_fake({{"frames", 1}, {"story_ms", 1500}});
  const std::string path = "/api/captures/" + hash + "/pixel?technique=msaa&x=1&y=2";
  std::thread first([&] { EXPECT_EQ(Client(port()).http().Get(path)->status, 200); });
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  error_of(client().http().Get(path), 503);
  error_of(client().http().Get("/api/captures/" + hash + "/frame"), 503);
  first.join();
  EXPECT_EQ(client().http().Get("/api/captures/" + hash + "/frame")->status, 200);
  EXPECT_EQ(client().http().Get(path)->status, 200);
}

TEST_F(Captures, EmptyFileIsRefused) {
  error_of(client().upload(""), 422);
}

TEST_F(Captures, OversizedUploadIsRefusedBeforeItsBody) {
  client();
  const std::string head = "POST /api/captures HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 99999999999\r\n\r\n";
  const std::string answer = raw_exchange(port(), head);
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 413")) << answer;
  EXPECT_NE(answer.find("99999999999"), std::string::npos);
  EXPECT_EQ(files_in(folder() / "data" / "uploads"), 0u);
}

// The answer must arrive although the client is still sending.
TEST_F(Captures, OversizedUploadThatIsSentAnywayGetsItsAnswer) {
  client();
  std::string request = "POST /api/captures HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 8000000\r\n\r\n";
  request.resize(request.size() + 8'000'000, 'x');
  EXPECT_TRUE(raw_exchange(port(), request).starts_with("HTTP/1.1 413"));
}

TEST_F(Captures, TruncatedUploadLeavesNothing) {
  client();
  const std::string answer = raw_exchange(
      port(), "POST /api/captures HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 1000\r\n\r\nFAKE {}", true);
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 400")) << answer;
  EXPECT_NE(answer.find("7 of 1000 bytes"), std::string::npos) << answer;
  EXPECT_EQ(files_in(folder() / "data" / "uploads"), 0u);
  EXPECT_EQ(client().get("/api/captures").at("total"), 0);
}

TEST_F(Captures, FormUploadIsToldWhatToSend) {
  const httplib::MultipartFormDataItems form{{"file", "FAKE {}", "a.spcap", "application/octet-stream"}};
  error_of(client().http().Post("/api/captures", form), 415);
}

TEST_F(Captures, NamesAreMadePrintableAndLoseTheirFolders) {
  const auto name_of = [&](int frames, const std::string& given) {
    const httplib::Result result = client().upload(fake_capture({{"frames", frames}}), given);
    EXPECT_EQ(result->status, 201) << result->body;
    return json::parse(result->body).value("name", "");
  };
  EXPECT_EQ(name_of(1, "..%2F..%2Fetc%2Fpasswd"), "passwd");
  EXPECT_EQ(name_of(2, "C%3A%5Cscenes%5Cpark.spcap"), "park.spcap");
  EXPECT_EQ(name_of(3, "a%00b%0Ac"), "a\\x00b\\x0ac");
  EXPECT_EQ(name_of(4, "%FF%C0%AF"), "\\xff\\xc0\\xaf");
  EXPECT_EQ(name_of(5, "%20"), "unnamed");
  EXPECT_LE(name_of(6, std::string(2000, 'n')).size(), 120u);
  EXPECT_EQ(name_of(7, "%E2%80%AEgnp.exe"), "\\u{202e}gnp.exe") << "no text that turns its direction around";
}

TEST_F(Captures, DeletedWithItsRunsAndBlobs) {
  const std::string hash = client().upload_fake({{"frames", 1}});
  const std::int64_t run = client().start_run(hash);
  EXPECT_EQ(client().wait_for_end(run).at("status"), "done");
  const json results = client().get("/api/runs/" + std::to_string(run) + "/results.json").at("results");
  const std::string blob = results.at(0).at("images").at("image");
  EXPECT_EQ(client().http().Delete("/api/captures/" + hash)->status, 204);
  client().get("/api/captures/" + hash, 404);
  client().get("/api/runs/" + std::to_string(run), 404);
  client().get("/api/blobs/" + blob, 404);
  EXPECT_EQ(files_in(folder() / "data" / "captures"), 0u);
  EXPECT_EQ(client().http().Delete("/api/captures/" + hash)->status, 404);
  EXPECT_EQ(client().upload_fake({{"frames", 1}}), hash) << "it can be stored again";
}

TEST_F(Captures, NotDeletedWhileARunOfItIsActive) {
  const std::string hash = client().upload_fake({{"frames", 1}, {"result_ms", 60'000}});
  const std::int64_t run = client().start_run(hash);
  error_of(client().http().Delete("/api/captures/" + hash), 409);
  client().http().Post("/api/runs/" + std::to_string(run) + "/cancel", "", "application/json");
  EXPECT_EQ(client().wait_for_end(run).at("status"), "cancelled");
  EXPECT_EQ(client().http().Delete("/api/captures/" + hash)->status, 204);
}

TEST_F(Captures, TooLittleRoomIs507BeforeTheBody) {
  server::ServiceOptions full = options();
  full.reserved_bytes = std::uint64_t{1} << 60;
  start(full);
  EXPECT_EQ(error_of(client().upload(fake_capture({{"frames", 1}})), 507).at("where"), "data folder");
}

// A file-size limit fails writes in the middle of a file, as a disk does that fills up meanwhile.
TEST_F(Captures, DiskThatFillsUpIs507AndLeavesNothing) {
  client();
  const auto previous = ::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{200'000, before.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &small);
  const httplib::Result result = client().upload("FAKE {}\n" + std::string(500'000, 'x'));
  ::setrlimit(RLIMIT_FSIZE, &before);
  ::signal(SIGXFSZ, previous);
  error_of(result, 507);
  EXPECT_EQ(files_in(folder() / "data" / "uploads"), 0u);
  EXPECT_EQ(files_in(folder() / "data" / "captures"), 0u);
  EXPECT_EQ(client().upload("FAKE {}\n" + std::string(500'000, 'x'))->status, 201);
}

// A file system of 3 MB, which a run's images fill. Needs the right to mount one.
TEST(FullDisk, RunEndsWithTheReasonAndTheServiceLives) {
  const TemporaryFolder folder;
  if (::mount("tmpfs", folder.path().c_str(), "tmpfs", 0, "size=3m") != 0)
    GTEST_SKIP() << "mounting is not allowed here";
  {
    server::ServiceOptions options = test_options(folder.path() / "data");
    options.reserved_bytes = 0;
    const RunningService service(options);
    Client client(service.port());
    const std::string hash = client.upload_fake({{"frames", 40}});
    const httplib::Result started = client.post_run(
        {{"capture", hash}, {"techniques", {{{"technique", "noaa"}}}}, {"width", 320}, {"height", 180}});
    ASSERT_EQ(started->status, 201) << started->body;
    const json run = client.wait_for_end(json::parse(started->body).at("id").get<std::int64_t>());
    EXPECT_EQ(run.at("status"), "failed");
    EXPECT_NE(run.at("reason").get<std::string>().find("disk"), std::string::npos) << run;
    EXPECT_EQ(client.get("/api/health").at("status"), "ok");
    // What the failed run gave back is taken too, so that the disk is full for certain.
    std::ofstream(folder.path() / "filler") << std::string(3u << 20, 'x');
    error_of(client.upload(fake_capture({{"frames", 2}}) + std::string(900'000, 'x')), 507);
  }
  ::umount2(folder.path().c_str(), MNT_DETACH);
}

}  // namespace
}  // namespace subpixel::tests
