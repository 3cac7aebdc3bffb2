#include "capture_format/stream_recorder.hpp"

#include <fcntl.h>
#include <unistd.h>
#include <zstd.h>

#include <cerrno>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <exception>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>
#include <utility>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/hash.hpp"
#include "capture_format/chunk_writer.hpp"
#include "capture_format/record_writer.hpp"
#include "capture_format/recorder_parts.hpp"

namespace subpixel::capture {
namespace {

// Of the version in which chunks may stand in the order in which they come.
const RecordWriter kRecords(3);

[[noreturn]] void fail(const std::filesystem::path& path, int error) {
  throw InputError("can't write the recording", std::generic_category().message(error), path.string());
}

}  // namespace

struct StreamRecorder::Chunk {
  ChunkType type;
  std::uint32_t id;
  std::vector<std::byte> payload;
};

// Takes chunks and writes them in their order.
class StreamRecorder::Writer {
 public:
  Writer(const std::filesystem::path& path, const StreamOptions& options)
      : no_memory_(std::make_exception_ptr(
            InputError("can't write the recording", "there is no memory left to compress it", path.string()))),
        options_(options),
        path_(path),
        descriptor_(opened(path_)) {
    thread_ = std::thread([this] { run(); });
  }

  ~Writer() {
    stop();
    if (descriptor_ >= 0) ::close(descriptor_);
  }

  const std::filesystem::path& path() const { return path_; }

  // All of them or, when it throws, none.
  void add(std::list<Chunk> chunks) {
    std::uint64_t bytes = 0;
    for (const Chunk& chunk : chunks) bytes += chunk.payload.size();
    std::unique_lock lock(mutex_);
    require_no_error();
    if (bytes > options_.most_bytes - total_bytes_) {
      throw UsageError("can't record more", "the recording passes " + std::to_string(options_.most_bytes) + " bytes",
                       path_.string());
    }
    has_room_.wait(lock, [&] { return queued_bytes_ == 0 || queued_bytes_ + bytes <= options_.queued_bytes; });
    require_no_error();
    total_bytes_ += bytes;
    queued_bytes_ += bytes;
    queue_.splice(queue_.end(), chunks);
    has_work_.notify_one();
  }

  // The payload of DATA chunk `id`, which has been added, read back from the file.
  std::vector<std::byte> read_back(std::uint32_t id) {
    std::unique_lock lock(mutex_);
    has_room_.wait(lock, [&] { return data_offsets_.size() > id || error_; });
    require_no_error();
    const std::uint64_t offset = data_offsets_[id];
    lock.unlock();
    std::vector<std::byte> header(kChunkHeaderBytes);
    read_at(offset, header);
    std::uint64_t stored_bytes = 0, decoded_bytes = 0;
    Codec codec{};
    std::memcpy(&codec, header.data() + 8, sizeof codec);
    std::memcpy(&stored_bytes, header.data() + 16, sizeof stored_bytes);
    std::memcpy(&decoded_bytes, header.data() + 24, sizeof decoded_bytes);
    std::vector<std::byte> stored(stored_bytes);
    read_at(offset + kChunkHeaderBytes, stored);
    if (codec == Codec::raw) return stored;
    std::vector<std::byte> decoded(decoded_bytes);
    const std::size_t got = ZSTD_decompress(decoded.data(), decoded.size(), stored.data(), stored.size());
    if (got != decoded.size()) fail(path_, EIO);
    return decoded;
  }

  // Everything added is in the file, with its end, and on the disk.
  void finish() {
    stop();
    require_no_error();
    if (::fsync(descriptor_) != 0) fail(path_, errno);
    if (::close(std::exchange(descriptor_, -1)) != 0) fail(path_, errno);
  }

 private:
  // A new file of that name, or with a number in it where there is one from before.
  static int opened(std::filesystem::path& path) {
    const std::filesystem::path wanted = path;
    for (int attempt = 1; attempt <= 1000; ++attempt) {
      path = wanted;
      if (attempt > 1) path.concat(".").concat(std::to_string(attempt));
      path += ".part";
      const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (descriptor >= 0) return descriptor;
      if (errno != EEXIST) fail(path, errno);
    }
    fail(path, EEXIST);
  }

  void require_no_error() const {
    if (error_) std::rethrow_exception(error_);
  }

  void write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) fail(path_, written < 0 ? errno : ENOSPC);
      bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
  }

  void read_at(std::uint64_t offset, std::span<std::byte> to) const {
    while (!to.empty()) {
      const ssize_t got = ::pread(descriptor_, to.data(), to.size(), static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) fail(path_, got < 0 ? errno : EIO);
      offset += static_cast<std::uint64_t>(got);
      to = to.subspan(static_cast<std::size_t>(got));
    }
  }

  void run() {
    try {
      ChunkWriter chunks(kRecords.version(), options_.zstd_level, [this](auto bytes) { write(bytes); });
      std::unique_lock lock(mutex_);
      while (true) {
        has_work_.wait(lock, [&] { return !queue_.empty() || ending_; });
        if (queue_.empty()) break;
        const Chunk chunk = std::move(queue_.front());
        queue_.pop_front();
        lock.unlock();
        const std::uint64_t offset = chunks.chunk(chunk.type, chunk.id, chunk.payload);
        lock.lock();
        if (chunk.type == ChunkType::data) data_offsets_.push_back(offset);
        queued_bytes_ -= chunk.payload.size();
        has_room_.notify_all();
      }
      lock.unlock();
      chunks.finish();
    } catch (const std::bad_alloc&) {
      end_with(no_memory_);
    } catch (...) {
      end_with(std::current_exception());
    }
  }

  void end_with(const std::exception_ptr& error) {
    const std::lock_guard lock(mutex_);
    error_ = error;
    queue_.clear();
    queued_bytes_ = 0;
    has_room_.notify_all();
  }

  void stop() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
      has_work_.notify_one();
    }
    if (thread_.joinable()) thread_.join();
  }

  const std::exception_ptr no_memory_;  // made while there is some
  StreamOptions options_;
  std::filesystem::path path_;
  int descriptor_;
  std::thread thread_;
  std::mutex mutex_;
  std::condition_variable has_work_, has_room_;
  std::list<Chunk> queue_;
  std::uint64_t queued_bytes_ = 0, total_bytes_ = 0;
  std::vector<std::uint64_t> data_offsets_;
  std::exception_ptr error_;
  bool ending_ = false;
};

StreamRecorder::StreamRecorder(const Metadata& metadata, const std::filesystem::path& path,
                               const StreamOptions& options)
    : options_(options), path_(path) {
  check_metadata(metadata, refuse_to_record("metadata"));
  writer_ = std::make_unique<Writer>(path, options);
  part_path_ = writer_->path();
  std::list<Chunk> chunks;
  chunks.push_back({ChunkType::metadata, 0, kRecords.metadata(metadata)});
  writer_->add(std::move(chunks));
}

StreamRecorder::~StreamRecorder() = default;

// What a call will write and keep in mind is made ready first, then the chunks are queued, and from there on nothing
// throws: numbers are those of what is written, and a DATA chunk never comes without what refers to it.

// The number of these bytes' chunk, which is added to `chunks` and `fresh` when there is none yet.
std::uint32_t StreamRecorder::data_number(const std::string& hash, std::span<const std::byte> bytes,
                                          std::list<Chunk>& chunks, Numbers& fresh) const {
  if (const auto found = data_.find(hash); found != data_.end()) return found->second;
  const auto number = static_cast<std::uint32_t>(data_.size());
  chunks.push_back({ChunkType::data, number, {bytes.begin(), bytes.end()}});
  fresh.emplace(hash, number);
  return number;
}

std::uint32_t StreamRecorder::add_buffer(const std::string& name, std::span<const std::byte> bytes) {
  const std::string hash = content_hash_hex(bytes);
  if (const auto found = buffers_.find(hash); found != buffers_.end()) return found->second;
  require_of_caller(buffer_bytes_.size() < kMaxBuffers, "can't record the buffer", "there are too many");
  const Buffer buffer{name, {}};
  check_buffer(buffer, refuse_to_record("buffer"));
  const auto number = static_cast<std::uint32_t>(buffer_bytes_.size());
  std::list<Chunk> chunks;
  Numbers fresh_data, fresh_buffer{{hash, number}};
  const std::uint32_t data = data_number(hash, bytes, chunks, fresh_data);
  chunks.push_back({ChunkType::buffer, number, kRecords.buffer(buffer, data)});
  std::map<std::uint32_t, std::vector<std::byte>> kept;
  kept.emplace(number, std::vector<std::byte>(bytes.begin(), bytes.end()));
  make_room(buffer_bytes_);
  make_room(buffer_data_);
  writer_->add(std::move(chunks));
  data_.merge(fresh_data);
  buffers_.merge(fresh_buffer);
  buffer_bytes_.push_back(bytes.size());
  buffer_data_.push_back(data);
  keep(std::move(kept));
  return number;
}

std::uint32_t StreamRecorder::add_texture(const Texture& texture) {
  check_texture(texture, refuse_to_record("texture"));
  const std::string key = texture_key(texture);
  if (const auto found = textures_.find(key); found != textures_.end()) return found->second;
  require_of_caller(texture_count_ < kMaxTextures, "can't record the texture", "there are too many");
  std::list<Chunk> chunks;
  Numbers fresh_data, fresh_texture{{key, texture_count_}};
  const std::uint32_t data = data_number(content_hash_hex(texture.bytes), texture.bytes, chunks, fresh_data);
  chunks.push_back({ChunkType::texture, texture_count_, kRecords.texture(texture, data)});
  writer_->add(std::move(chunks));
  data_.merge(fresh_data);
  textures_.merge(fresh_texture);
  return texture_count_++;
}

std::uint32_t StreamRecorder::add_material(Material material) {
  check_material(material, texture_count_, refuse_to_record("material"));
  require_of_caller(material_count_ < kMaxMaterials, "can't record the material", "there are too many");
  new_materials_.push_back(std::move(material));
  return material_count_++;
}

void StreamRecorder::begin_frame(Frame frame) {
  require_of_caller(!frame_, "can't begin a frame", "the frame before has not ended");
  require_of_caller(frame.draws.empty(), "can't begin a frame", "it has draws already");
  require_of_caller(frame_count_ < kMaxFrames, "can't begin a frame", "there are too many");
  check_frame(frame, refuse_to_record("frame"));
  frame_ = std::move(frame);
}

void StreamRecorder::draw(Draw draw) {
  require_of_caller(frame_.has_value(), "can't record the draw", "no frame has begun");
  require_of_caller(frame_->draws.size() < kMaxDraws, "can't record the draw", "the frame has too many");
  static const Report kRefuse = refuse_to_record("draw");
  check_draw({buffer_bytes_, material_count_}, draw, kRefuse);
  indices_.check(
      draw, [this](std::uint32_t buffer) { return bytes_of(buffer); }, kRefuse);
  frame_->draws.push_back(std::move(draw));
}

void StreamRecorder::end_frame() {
  require_of_caller(frame_.has_value(), "can't end the frame", "none has begun");
  const Frame frame = *std::exchange(frame_, std::nullopt);
  check_draw_list(frame, refuse_to_record("frame"));
  std::list<Chunk> chunks = materials_to_write();
  const std::size_t material_chunks = chunks.size();
  chunks.push_back({ChunkType::frame, frame_count_, kRecords.frame(frame)});
  writer_->add(std::move(chunks));
  forget_written_materials(material_chunks);
  ++frame_count_;
}

// Those that came since the last frame. Every file has one such chunk at least.
std::list<StreamRecorder::Chunk> StreamRecorder::materials_to_write() const {
  std::list<Chunk> chunks;
  if (!new_materials_.empty() || material_chunks_ == 0) {
    chunks.push_back({ChunkType::material, material_chunks_, kRecords.materials(new_materials_)});
  }
  return chunks;
}

void StreamRecorder::forget_written_materials(std::size_t chunks) {
  if (chunks == 0) return;
  ++material_chunks_;
  new_materials_.clear();
}

void StreamRecorder::finish() {
  require_of_caller(!frame_, "can't finish the recording", "a frame has not ended");
  try {
    writer_->add(materials_to_write());
  } catch (const UsageError&) {  // no frame draws with them
    new_materials_.clear();
    writer_->add(materials_to_write());
  }
  writer_->finish();
  if (std::rename(part_path_.c_str(), path_.c_str()) != 0) fail(path_, errno);
  const std::filesystem::path folder = path_.has_parent_path() ? path_.parent_path() : std::filesystem::path(".");
  if (const int error = sync_folder(folder); error != 0) fail(path_, error);
}

std::span<const std::byte> StreamRecorder::bytes_of(std::uint32_t buffer) {
  if (const auto found = kept_.find(buffer); found != kept_.end()) return found->second;
  std::map<std::uint32_t, std::vector<std::byte>> read;
  read.emplace(buffer, writer_->read_back(buffer_data_[buffer]));
  keep(std::move(read));
  return kept_.at(buffer);
}

// Takes one more. The oldest leave first, but never the one that came.
void StreamRecorder::keep(std::map<std::uint32_t, std::vector<std::byte>> one) {
  const std::uint32_t buffer = one.begin()->first;
  kept_total_ += one.begin()->second.size();
  kept_.merge(one);
  while (kept_total_ > options_.kept_bytes && kept_.size() > 1) {
    auto oldest = kept_.begin();
    if (oldest->first == buffer) ++oldest;
    kept_total_ -= oldest->second.size();
    kept_.erase(oldest);
  }
}

}  // namespace subpixel::capture
