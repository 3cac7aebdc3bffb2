#include "capture_format/recorder.hpp"

#include <utility>

#include "base/error.hpp"
#include "base/hash.hpp"
#include "capture_format/checks.hpp"
#include "capture_format/limits.hpp"
#include "capture_format/recorder_parts.hpp"
#include "capture_format/writer.hpp"

namespace subpixel::capture {
Recorder::Recorder(Metadata metadata) {
  check_metadata(metadata, refuse_to_record("metadata"));
  capture_.metadata = std::move(metadata);
}

std::uint32_t Recorder::add_buffer(std::string name, std::span<const std::byte> bytes) {
  const std::string hash = content_hash_hex(bytes);
  if (const auto found = buffers_.find(hash); found != buffers_.end()) return found->second;
  require_of_caller(capture_.buffers.size() < kMaxBuffers, "can't record the buffer", "there are too many");
  Buffer buffer{std::move(name), {bytes.begin(), bytes.end()}};
  check_buffer(buffer, refuse_to_record("buffer"));
  const auto number = static_cast<std::uint32_t>(capture_.buffers.size());
  make_room(buffer_bytes_);
  make_room(capture_.buffers);
  buffers_.emplace(hash, number);  // the last that may throw
  buffer_bytes_.push_back(buffer.bytes.size());
  capture_.buffers.push_back(std::move(buffer));
  return number;
}

std::uint32_t Recorder::add_texture(Texture texture) {
  check_texture(texture, refuse_to_record("texture"));
  const std::string key = texture_key(texture);
  if (const auto found = textures_.find(key); found != textures_.end()) return found->second;
  require_of_caller(capture_.textures.size() < kMaxTextures, "can't record the texture", "there are too many");
  const auto number = static_cast<std::uint32_t>(capture_.textures.size());
  make_room(capture_.textures);
  textures_.emplace(key, number);  // the last that may throw
  capture_.textures.push_back(std::move(texture));
  return number;
}

std::uint32_t Recorder::add_material(Material material) {
  check_material(material, capture_.textures.size(), refuse_to_record("material"));
  require_of_caller(capture_.materials.size() < kMaxMaterials, "can't record the material", "there are too many");
  capture_.materials.push_back(std::move(material));
  return static_cast<std::uint32_t>(capture_.materials.size() - 1);
}

void Recorder::begin_frame(Frame frame) {
  require_of_caller(!frame_, "can't begin a frame", "the frame before has not ended");
  require_of_caller(frame.draws.empty(), "can't begin a frame", "it has draws already");
  require_of_caller(capture_.frames.size() < kMaxFrames, "can't begin a frame", "there are too many");
  check_frame(frame, refuse_to_record("frame"));
  frame_ = std::move(frame);
}

void Recorder::draw(Draw draw) {
  require_of_caller(frame_.has_value(), "can't record the draw", "no frame has begun");
  require_of_caller(frame_->draws.size() < kMaxDraws, "can't record the draw", "the frame has too many");
  check_draw({buffer_bytes_, capture_.materials.size()}, draw, refuse_to_record("draw"));
  indices_.check(capture_, draw, refuse_to_record("draw"));
  frame_->draws.push_back(std::move(draw));
}

void Recorder::end_frame() {
  require_of_caller(frame_.has_value(), "can't end the frame", "none has begun");
  Frame frame = *std::exchange(frame_, std::nullopt);
  check_draw_list(frame, refuse_to_record("frame"));
  capture_.frames.push_back(std::move(frame));
}

Capture Recorder::take() {
  require_of_caller(!frame_, "can't take the recording", "a frame has not ended");
  buffers_.clear();
  textures_.clear();
  indices_ = {};
  buffer_bytes_.clear();
  return std::exchange(capture_, {});
}

void Recorder::save(const std::filesystem::path& path) const {
  require_of_caller(!frame_, "can't save the recording", "a frame has not ended");
  write_capture(capture_, path);
}

}  // namespace subpixel::capture
