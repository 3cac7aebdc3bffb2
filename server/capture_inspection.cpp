#include "server/capture_inspection.hpp"

#include <fmt/format.h>

#include <utility>

#include "base/error.hpp"
#include "base/failure.hpp"
#include "base/json_document.hpp"
#include "base/printable.hpp"
#include "server/http_error.hpp"

namespace subpixel::server {
namespace {

constexpr std::size_t kMaxSummaryBytes = std::size_t{16} << 20;
constexpr std::size_t kMaxTitleBytes = 200;

// The reader's message without the program's name and without the path of the upload's file, which means nothing to
// users.
std::string reader_message(std::string message, const std::filesystem::path& file) {
  while (!message.empty() && (message.back() == '\n' || message.back() == ' ')) message.pop_back();
  if (const std::size_t line = message.rfind('\n'); line != std::string::npos) message.erase(0, line + 1);
  if (message.starts_with("subpixel: ")) message.erase(0, 10);
  for (std::size_t at = 0; (at = message.find(file.string(), at)) != std::string::npos;) {
    message.replace(at, file.string().size(), "uploaded file");
  }
  return printable(message, 1000);
}

}  // namespace

CaptureRecord parse_capture_summary(std::string_view text) {
  const std::string what = "capture summary";
  CaptureRecord record;
  record.summary = parse_json_document(text, what, "the worker's answer");
  const JsonField summary(record.summary, what);
  record.title = printable(summary.member("title").text(), kMaxTitleBytes);
  record.frame_count = summary.member("frame_count").u32();
  record.width = summary.member("width").u32();
  record.height = summary.member("height").u32();
  record.triangles = summary.member("triangles").u64();
  return record;
}

CaptureRecord inspect_capture(const std::filesystem::path& file, const WorkerOptions& worker, std::stop_token stop) {
  std::string output;
  ChildLimits limits = worker.limits;
  limits.silence = limits.duration = std::min<std::chrono::milliseconds>(limits.silence, std::chrono::minutes(5));
  limits.processor_s = static_cast<std::uint64_t>(limits.duration / std::chrono::seconds(1)) + 1;
  limits.confinement = confined(worker, {file}, {});
  const ChildOutcome outcome = run_child({worker.program.string(), "info", file.string(), "--json"}, limits,
                                         std::move(stop), [&](std::string_view line) {
                                           output.append(line) += '\n';
                                           return output.size() <= kMaxSummaryBytes;
                                         });
  if (outcome.kind == ChildOutcome::Kind::stopped)
    throw HttpError(503, "the capture is not stored", "the service is ending", "");
  if (outcome.kind == ChildOutcome::Kind::exited && outcome.code == kInputExit) {
    throw HttpError(422, "the file is no valid capture", reader_message(outcome.error_tail, file), "body");
  }
  if (outcome.kind == ChildOutcome::Kind::exited && outcome.code == kInternalExit) {
    throw HttpError(500, "the capture could not be inspected", reader_message(outcome.error_tail, file), "body");
  }
  if (!outcome.reason.empty()) {
    throw HttpError(422, "the capture could not be inspected", outcome.reason,
                    reader_message(outcome.error_tail, file));
  }
  try {
    return parse_capture_summary(output);
  } catch (const std::exception& error) {
    throw HttpError(500, "the capture could not be inspected", printable(error.what(), 300), "capture summary");
  }
}

nlohmann::json ask_program(const std::filesystem::path& file, const Question& question, const WorkerOptions& worker,
                           std::stop_token stop) {
  const std::string& what = question.what;
  std::vector<std::string> arguments{worker.program.string(), question.verb, file.string(), "--json"};
  arguments.insert(arguments.end(), question.options.begin(), question.options.end());
  ChildLimits limits = worker.limits;
  limits.silence = limits.duration = std::min<std::chrono::milliseconds>(limits.silence, std::chrono::minutes(5));
  limits.processor_s = 4 * static_cast<std::uint64_t>(limits.duration / std::chrono::seconds(1));
  limits.confinement = confined(worker, {file}, {});
  std::string output;
  const ChildOutcome outcome = run_child(arguments, limits, std::move(stop), [&](std::string_view line) {
    output.append(line) += '\n';
    return output.size() <= kMaxSummaryBytes;
  });
  if (outcome.kind == ChildOutcome::Kind::stopped) throw HttpError(503, what, "the service is ending", "");
  const std::string message = reader_message(outcome.error_tail, file);
  if (outcome.kind == ChildOutcome::Kind::exited && outcome.code == kUsageExit)
    throw HttpError(400, what, message, "query");
  if (outcome.kind == ChildOutcome::Kind::exited && outcome.code == kInternalExit)
    throw HttpError(500, what, message, "");
  if (!outcome.reason.empty())
    throw HttpError(422, what, message.empty() ? outcome.reason : message, file.filename().string());
  try {
    return parse_json_document(output, what, "the worker's answer");
  } catch (const InputError& error) {
    throw HttpError(500, what, error.what(), "");
  }
}

}  // namespace subpixel::server
