#include "cli/service_verbs.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "base/error.hpp"
#include "base/json_text.hpp"
#include "base/log_fields.hpp"
#include "base/numbers.hpp"
#include "base/printable.hpp"
#include "cli/option_values.hpp"
#include "cli/submission.hpp"
#include "process/confinement.hpp"
#include "server/service.hpp"
#include "server/store/store.hpp"

namespace subpixel::cli {
namespace {

struct ServeArguments {
  std::string data, listen = "127.0.0.1:8080", worker;
  std::vector<std::string> host_names;
  std::uint32_t workers = 1;
  double upload_limit_gb = 4, worker_file_gb = 4;
  std::optional<double> worker_memory_gb;
  std::uint32_t silence_s = 600, duration_s = 12 * 3600, processor_s = 0;
  std::vector<std::string> worker_reads;
  bool require_token = false, no_token = false;  // neither: where other machines can call
  bool log_json = false, log_requests = false;
};

// Splits "HOST:PORT" or "[V6]:PORT".
std::pair<std::string, int> parse_address(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  int port = -1;
  if (colon != std::string::npos) {
    port = parse_number<int>(std::string_view(text).substr(colon + 1)).value_or(-1);
  }
  if (port < 0 || port > 65535 || colon == 0) {
    throw UsageError("can't listen", "expected HOST:PORT with a port from 0 to 65535, got " + text, "--listen");
  }
  std::string host = text.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  return {host, port};
}

bool is_loopback(const std::string& host) {
  return host == "localhost" || host == "::1" || host.starts_with("127.");
}

// The machine's, 0 when it is not known or a sanitizer needs more address space than that.
std::uint64_t memory_bytes() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return 0;
#else
  const long pages = ::sysconf(_SC_PHYS_PAGES), page_bytes = ::sysconf(_SC_PAGESIZE);
  return pages <= 0 || page_bytes <= 0 ? 0 : static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes);
#endif
}

server::ServiceOptions service_options(const ServeArguments& arguments) {
  server::ServiceOptions options;
  options.data = arguments.data;
  std::tie(options.host, options.port) = parse_address(arguments.listen);
  options.host_names = arguments.host_names;
  options.require_token = arguments.require_token || (!arguments.no_token && !is_loopback(options.host));
  options.log_requests = arguments.log_requests;
  constexpr double kGigabyte = 1 << 30;
  options.upload_limit_bytes = static_cast<std::uint64_t>(arguments.upload_limit_gb * kGigabyte);
  options.worker.program = arguments.worker.empty() ? std::filesystem::read_symlink("/proc/self/exe").string()
                                                    : std::filesystem::absolute(arguments.worker).string();
  options.worker.count = arguments.workers;
  options.worker.limits.silence = std::chrono::seconds(arguments.silence_s);
  options.worker.limits.duration = std::chrono::seconds(arguments.duration_s);
  options.worker.limits.address_space_bytes =
      arguments.worker_memory_gb ? static_cast<std::uint64_t>(*arguments.worker_memory_gb * kGigabyte) : memory_bytes();
  options.worker.limits.file_bytes = static_cast<std::uint64_t>(arguments.worker_file_gb * kGigabyte);
  options.worker.limits.processor_s = arguments.processor_s;
  options.worker.readable = arguments.worker_reads;
  return options;
}

// A log line's text, in which there may be names from requests and captures.
class PrintableText : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&, spdlog::memory_buf_t& out) override {
    const std::string text = printable({message.payload.data(), message.payload.size()});
    out.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override { return std::make_unique<PrintableText>(); }
};

// What the thread is busy with, after the text.
class Fields : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg&, const std::tm&, spdlog::memory_buf_t& out) override {
    for (const auto& [name, value] : log_fields()) {
      const std::string text = fmt::format(" {}={}", name, printable(value));
      out.append(text.data(), text.data() + text.size());
    }
  }
  std::unique_ptr<custom_flag_formatter> clone() const override { return std::make_unique<Fields>(); }
};

// One JSON document a line.
class JsonLines : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
    const auto level = spdlog::level::to_string_view(message.level);
    nlohmann::json line = {{"time", server::utc_now()},
                           {"level", std::string(level.data(), level.size())},
                           {"message", std::string(message.payload.data(), message.payload.size())}};
    for (const auto& [name, value] : log_fields()) line[name] = value;
    const std::string text = json_text(line) + "\n";
    out.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<formatter> clone() const override { return std::make_unique<JsonLines>(); }
};

void set_up_log(bool as_json) {
  // The log goes to standard error; standard output has the address and nothing else, for scripts.
  spdlog::set_default_logger(spdlog::stderr_color_mt("subpixel"));
  if (as_json) return spdlog::set_formatter(std::make_unique<JsonLines>());
  auto lines = std::make_unique<spdlog::pattern_formatter>();
  lines->add_flag<PrintableText>('*').add_flag<Fields>('?').set_pattern("[%Y-%m-%d %H:%M:%S.%e] [%n] [%^%l%$] %*%?");
  spdlog::set_formatter(std::move(lines));
}

int serve(const ServeArguments& arguments) {
  set_up_log(arguments.log_json);
  ::signal(SIGPIPE, SIG_IGN);
  // Blocked before any thread starts, so that only the waiting one below gets them.
  sigset_t endings;
  ::sigemptyset(&endings);
  ::sigaddset(&endings, SIGTERM);
  ::sigaddset(&endings, SIGINT);
  ::pthread_sigmask(SIG_BLOCK, &endings, nullptr);

  for (const std::string& gap : confinement_gaps()) spdlog::warn("workers are less confined: {}", gap);
  const server::ServiceOptions options = service_options(arguments);
  if (!options.require_token && !is_loopback(options.host)) {
    spdlog::warn("whoever reaches {} may do everything: --require-token asks for tokens", options.host);
  } else if (options.require_token && !arguments.require_token) {
    spdlog::info(
        "{} is reached from elsewhere, so callers need a token: subpixel token add makes one, --no-token asks for none",
        options.host);
  }
  server::Service service(options);
  const std::string host = arguments.listen.substr(0, arguments.listen.rfind(':'));
  fmt::print("listening on http://{}:{}\n", printable(host), service.port());
  std::fflush(stdout);
  std::jthread waiter([&](const std::stop_token& stop) {
    const timespec step{0, 200'000'000};
    while (!stop.stop_requested()) {
      if (::sigtimedwait(&endings, nullptr, &step) > 0) {
        spdlog::info("ending; unfinished runs resume at the next start");
        service.stop();
        return;
      }
    }
  });
  service.run();
  return 0;
}

void add_serve(CLI::App& app, std::function<int()>& action) {
  const auto arguments = std::make_shared<ServeArguments>();
  CLI::App* const verb = app.add_subcommand("serve", "Run the HTTP API and the viewer over one data folder");
  verb->add_option("--data", arguments->data, "Folder for captures, results and caches; created when missing")
      ->required();
  verb->add_option("--listen", arguments->listen, "HOST:PORT; port 0 takes any free one")->capture_default_str();
  verb->add_option("--host-name", arguments->host_names,
                   "Further NAME or NAME:PORT by which clients call this service, a proxy's before it");
  verb->add_option("--workers", arguments->workers, "Runs replayed at a time; more than 1 disturbs their timings")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  verb->add_option("--upload-limit", arguments->upload_limit_gb, "Largest capture taken, in GiB")
      ->check(CLI::Range(0.0, 1024.0))
      ->capture_default_str();
  verb->add_option("--worker-memory", arguments->worker_memory_gb,
                   "Address space of a worker, in GiB; 0: no limit; default: as much as the machine has memory")
      ->check(CLI::Range(0.0, 65536.0));
  verb->add_option("--worker-file", arguments->worker_file_gb, "Largest file a worker writes, in GiB; 0: no limit")
      ->check(CLI::Range(0.0, 65536.0))
      ->capture_default_str();
  verb->add_option("--worker-processor-time", arguments->processor_s,
                   "Seconds of processor time, of all its threads, after which a worker is ended; 0: no limit")
      ->check(CLI::Range(0, 1'000'000'000))
      ->capture_default_str();
  verb->add_option("--worker-reads", arguments->worker_reads,
                   "Further file or folder that workers may read: a driver's outside of /usr; may be repeated")
      ->allow_extra_args(false)
      ->check(CLI::ExistingPath);
  verb->add_option("--worker-silence", arguments->silence_s, "Seconds without a word after which a worker is ended")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  verb->add_option("--worker-time", arguments->duration_s, "Seconds after which a worker is ended")
      ->check(CLI::Range(1, 10'000'000))
      ->capture_default_str();
  verb->add_flag("--require-token", arguments->require_token,
                 "Whoever reads or changes anything needs a token (see subpixel token); the default where --listen is "
                 "an address that other machines reach");
  verb->add_flag("--no-token", arguments->no_token, "Nobody needs one, there too")->excludes("--require-token");
  verb->add_flag("--log-json", arguments->log_json, "Write the log as one JSON document a line");
  verb->add_flag("--log-requests", arguments->log_requests, "Log each request");
  verb->add_option("--worker-program", arguments->worker,
                   "Program run as `PROGRAM worker --job FILE`; default: this one")
      ->check(CLI::ExistingFile);
  verb->callback([arguments, &action] { action = [arguments] { return serve(*arguments); }; });
}

void add_submit(CLI::App& app, std::function<int()>& action) {
  const auto submission = std::make_shared<Submission>();
  CLI::App* const verb = app.add_subcommand("submit", "Send a capture to a service and start a run of it");
  verb->add_option("file", submission->file, "Capture")->required()->check(CLI::ExistingFile);
  verb->add_option("--server", submission->server, "http://HOST:PORT, or https://HOST")->required();
  verb->add_option("--token-file", submission->token_file,
                   "File with the token of a service that wants one; default: what SUBPIXEL_TOKEN holds");
  verb->add_option("--techniques", submission->techniques, "a,b:param=v,...; without it the capture is only sent");
  verb->add_option("--samples", submission->samples, "Samples per pixel of techniques that are not given their own")
      ->transform(within(replay::kSamplesLimit));
  verb->add_option("--frames", submission->frames, "FIRST-LAST or one frame; default: all");
  verb->add_option("--size", submission->size, "WxH; default: as recorded");
  verb->add_option("--repeat", submission->repeat, "Timed repeats of each frame")
      ->transform(within(replay::kRepeatLimit));
  verb->add_option("--reference-samples", submission->reference_samples, "Samples of the reference; 0: no error")
      ->transform(within(replay::kReferenceSamplesLimit));
  verb->add_option("--lights", submission->point_lights, "Point lights: this many; as recorded when absent")
      ->transform(within(replay::kPointLightsLimit));
  verb->add_flag("--every-light", submission->every_light, "Evaluate all point lights at every shading point");
  verb->add_option("--memory", submission->memory,
                   "What a frame's passes may hold at a time, as 512M or 2G; no limit when absent");
  verb->add_option("--priority", submission->priority, "Of the run, 0 to 9, the highest is next; default: 5")
      ->transform(within(replay::kPriorityLimit));
  verb->add_option("--retries", submission->retries,
                   "How often in a row a run whose worker died is started again without a new result; default: 2")
      ->transform(within(replay::kRetriesLimit));
  verb->add_flag("--wait", submission->wait, "Wait for the run's end and print its table; exit code 3 when it fails");
  verb->add_flag("--once", submission->once,
                 "Take the run with the same request that is there already, unless it failed");
  verb->callback([submission, &action] { action = [submission] { return submit(*submission); }; });
}

}  // namespace

void add_service_verbs(CLI::App& app, std::function<int()>& action) {
  add_serve(app, action);
  add_submit(app, action);
}

}  // namespace subpixel::cli
