#include "capture_format/reading/capture_file.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <iterator>
#include <set>
#include <span>
#include <system_error>
#include <thread>
#include <utility>

#include "base/error.hpp"
#include "capture_format/checks.hpp"
#include "capture_format/streams.hpp"
#include "capture_format/texture_reads.hpp"

namespace subpixel::capture {
namespace {

// What a frame's draws refer to, by number.
struct Used {
  std::set<std::uint32_t> buffers, materials;
};

void add_used(Used& used, const Draw& draw) {
  for (const VertexStream* stream : {&draw.position, &draw.normal, &draw.uv, &draw.tangent, &draw.uv2, &draw.colour}) {
    if (stream->buffer != kNone) used.buffers.insert(stream->buffer);
  }
  if (draw.index_type != IndexType::none) used.buffers.insert(draw.index_buffer);
  if (draw.instance_buffer != kNone) used.buffers.insert(draw.instance_buffer);
  used.materials.insert(draw.material);
}

// New numbers of what is kept, in the old order.
class Numbers {
 public:
  explicit Numbers(const std::set<std::uint32_t>& kept) : kept_(kept.begin(), kept.end()) {}

  void renew(std::uint32_t& number) const {
    if (number == kNone) return;
    number = static_cast<std::uint32_t>(std::lower_bound(kept_.begin(), kept_.end(), number) - kept_.begin());
  }

 private:
  std::vector<std::uint32_t> kept_;
};

void renumber(Draw& draw, const Numbers& buffers, const Numbers& materials) {
  for (VertexStream* stream : {&draw.position, &draw.normal, &draw.uv, &draw.tangent, &draw.uv2, &draw.colour}) {
    buffers.renew(stream->buffer);
  }
  if (draw.index_type != IndexType::none) buffers.renew(draw.index_buffer);
  buffers.renew(draw.instance_buffer);
  materials.renew(draw.material);
}

// The payloads of chunks, decoded on the threads of the machine where they are large. Throws what the first chunk that
// can't be decoded throws, whichever thread meets one first.
std::vector<std::vector<std::byte>> decode_side_by_side(std::span<const std::byte> file,
                                                        const std::vector<const ChunkAt*>& chunks) {
  constexpr std::uint64_t kWorthAThread = 1 << 20;
  std::uint64_t total = 0;
  for (const ChunkAt* chunk : chunks) total += chunk->header.decoded_bytes;
  std::vector<std::vector<std::byte>> decoded(chunks.size());
  std::vector<std::exception_ptr> failures(chunks.size());
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < chunks.size(); i = next++) {
      try {
        decoded[i] = decode_chunk(file, *chunks[i]);
      } catch (...) {
        failures[i] = std::current_exception();
        next = chunks.size();  // those before it are begun
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    const std::uint64_t wanted = std::min(
        {std::uint64_t{std::thread::hardware_concurrency()}, total / kWorthAThread, std::uint64_t{chunks.size()}});
    try {
      for (std::uint64_t t = 1; t < wanted; ++t) threads.emplace_back(work);
    } catch (const std::system_error&) {
      // The system gives no more: those there are do it.
    }
    work();
  }
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
  return decoded;
}

}  // namespace

CaptureFile::CaptureFile(const std::filesystem::path& path, const ReadLimits& limits)
    : name_(path.string()), limits_(limits), file_(path, limits.file_bytes) {
  try {
    const ChunkList list = list_chunks(file_.bytes(), limits);
    records_ = std::make_unique<RecordReader>(list.version);
    std::vector<ChunkAt> metadata;
    std::set<std::string> skipped;
    for (const ChunkAt& chunk : list.chunks) {
      switch (chunk.header.type) {
        case ChunkType::metadata:
          metadata.push_back(chunk);
          break;
        case ChunkType::data:
          data_.push_back(chunk);
          break;
        case ChunkType::buffer:
          buffers_.push_back(chunk);
          break;
        case ChunkType::texture:
          textures_.push_back(chunk);
          break;
        case ChunkType::material:
          materials_.push_back(chunk);
          break;
        case ChunkType::frame:
          frames_.push_back(chunk);
          break;
        default:
          skipped.insert(chunk_name(chunk.header.type, chunk.header.id).substr(0, 4));
      }
    }
    if (metadata.size() != 1) fail_reading(metadata.empty() ? "chunk META is missing" : "more than one", 0, "META", "");
    if (materials_.empty()) fail_reading("chunk MATL is missing", 0, "", "");
    const std::pair<std::size_t, std::uint32_t> counts[] = {
        {buffers_.size(), kMaxBuffers}, {textures_.size(), kMaxTextures}, {frames_.size(), kMaxFrames}};
    for (const auto& [count, most] : counts) {
      if (count > most) fail_reading("more than " + std::to_string(most) + " of a kind", 0, "", "");
    }
    const std::vector<std::byte> meta = payload(metadata.front());
    FieldReader in(meta, metadata.front());
    metadata_ = records_->metadata(in);
    in.finish();
    add_skip_notice(metadata_, skipped);
    // Ranges of draws are held to the sizes of buffers, which are those of the chunks they refer to.
    for (const ChunkAt& chunk : buffers_) {
      const std::vector<std::byte> record = payload(chunk);
      FieldReader fields(record, chunk);
      fields.text("name");
      buffer_bytes_.push_back(data_chunk(fields).header.decoded_bytes);
    }
  } catch (const InputError& error) {
    throw InputError(name_, error.what(), "");
  }
}

std::vector<std::byte> CaptureFile::payload(const ChunkAt& chunk) const {
  return decode_chunk(file_.bytes(), chunk);
}

const ChunkAt& CaptureFile::data_chunk(FieldReader& in) const {
  const auto number = in.get<std::uint32_t>("data");
  if (number >= data_.size()) in.fail("data", std::to_string(number) + " is not below " + std::to_string(data_.size()));
  return data_[number];
}

std::vector<Material> CaptureFile::materials() const {
  std::vector<Material> all;
  for (const ChunkAt& chunk : materials_) {
    const std::vector<std::byte> bytes = payload(chunk);
    FieldReader in(bytes, chunk);
    std::vector<Material> more = records_->materials(in, textures_.size());
    in.finish();
    if (more.size() > kMaxMaterials - all.size())
      fail_reading("more than " + std::to_string(kMaxMaterials) + " in all", chunk.offset, "MATL", "materials");
    std::move(more.begin(), more.end(), std::back_inserter(all));
  }
  return all;
}

Frame CaptureFile::frame(std::size_t number, std::size_t material_count) const {
  const std::vector<std::byte> bytes = payload(frames_[number]);
  FieldReader in(bytes, frames_[number]);
  Frame frame = records_->frame(in, {buffer_bytes_, material_count}, [](const Draw&, const Report&) {});
  in.finish();
  return frame;
}

Capture CaptureFile::load(std::size_t first, std::size_t last, Triangles triangles,
                          std::span<const std::uint32_t> also) const {
  try {
    std::set<std::size_t> wanted(also.begin(), also.end());
    for (std::size_t f = first; f <= last && f < frames_.size(); ++f) wanted.insert(f);
    wanted.erase(wanted.lower_bound(frames_.size()), wanted.end());
    Capture capture;
    capture.metadata = metadata_;
    std::vector<Material> all_materials = materials();
    capture.frames.resize(frames_.size());
    if (!frames_.empty()) {
      capture.frames[0] = frame(0, all_materials.size());
      if (!wanted.contains(0)) capture.frames[0].draws.clear();
    }
    Used used;
    for (const std::size_t f : wanted) {
      if (f > 0) capture.frames[f] = frame(f, all_materials.size());
      for (const Draw& draw : capture.frames[f].draws) add_used(used, draw);
    }
    std::set<std::uint32_t> used_textures;
    for (const std::uint32_t material : used.materials) {
      capture.materials.push_back(std::move(all_materials[material]));
      for (const TextureRead& read : texture_reads(capture.materials.back())) used_textures.insert(read.texture);
    }
    const Numbers buffer_numbers(used.buffers), material_numbers(used.materials), texture_numbers(used_textures);
    for (Material& material : capture.materials) {
      for (std::uint32_t* texture : {&material.base_colour_texture, &material.metallic_roughness_texture,
                                     &material.normal_texture, &material.emissive_texture}) {
        texture_numbers.renew(*texture);
      }
    }
    // Records first, whose chunks of bytes are then decoded side by side.
    std::uint64_t bytes_left = limits_.decoded_bytes;
    std::vector<const ChunkAt*> chunks;
    const auto note = [&](FieldReader& in) {
      const ChunkAt& chunk = data_chunk(in);
      if (chunk.header.decoded_bytes > bytes_left) in.fail("data", "too many bytes in all buffers and textures");
      bytes_left -= chunk.header.decoded_bytes;
      chunks.push_back(&chunk);
      return std::vector<std::byte>();
    };
    for (const std::uint32_t number : used.buffers) {
      const std::vector<std::byte> record = payload(buffers_[number]);
      FieldReader in(record, buffers_[number]);
      capture.buffers.push_back(records_->buffer(in, note));
      check_buffer(capture.buffers.back(), fail_in(in));
      in.finish();
    }
    for (const std::uint32_t number : used_textures) {
      const std::vector<std::byte> record = payload(textures_[number]);
      FieldReader in(record, textures_[number]);
      capture.textures.push_back(records_->texture(in, note));
      check_texture(capture.textures.back(), chunks.back()->header.decoded_bytes, fail_in(in));
      in.finish();
    }
    std::vector<std::vector<std::byte>> bytes = decode_side_by_side(file_.bytes(), chunks);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const bool of_buffer = i < capture.buffers.size();
      (of_buffer ? capture.buffers[i].bytes : capture.textures[i - capture.buffers.size()].bytes) = std::move(bytes[i]);
    }
    IndexChecker indices;
    for (const std::size_t f : wanted) {
      for (std::size_t d = 0; d < capture.frames[f].draws.size(); ++d) {
        Draw& draw = capture.frames[f].draws[d];
        renumber(draw, buffer_numbers, material_numbers);
        indices.check(capture, draw, [&](std::string_view field, const std::string& why) {
          fail_reading(why, frames_[f].offset, "FRAM " + std::to_string(f) + ", draw " + std::to_string(d), field);
        });
      }
    }
    if (triangles == Triangles::lists) make_triangle_lists(capture, bytes_left);
    return capture;
  } catch (const InputError& error) {
    throw InputError(name_, error.what(), "");
  }
}

CaptureFile::Outline CaptureFile::outline() const {
  try {
    Outline outline;
    Capture& capture = outline.capture;
    outline.buffer_bytes = buffer_bytes_;
    capture.metadata = metadata_;
    capture.materials = materials();
    for (const ChunkAt& chunk : buffers_) {
      const std::vector<std::byte> record = payload(chunk);
      FieldReader in(record, chunk);
      capture.buffers.push_back(records_->buffer(in, [this](FieldReader& fields) {
        data_chunk(fields);
        return std::vector<std::byte>();
      }));
      check_buffer(capture.buffers.back(), fail_in(in));
      in.finish();
    }
    for (const ChunkAt& chunk : textures_) {
      const std::vector<std::byte> record = payload(chunk);
      FieldReader in(record, chunk);
      Texture texture = records_->texture(in, [&](FieldReader& fields) {
        outline.texture_bytes.push_back(data_chunk(fields).header.decoded_bytes);
        return std::vector<std::byte>();
      });
      check_texture(texture, outline.texture_bytes.back(), fail_in(in));
      in.finish();
      capture.textures.push_back(std::move(texture));
    }
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      capture.frames.push_back(frame(f, capture.materials.size()));
      for (Draw& draw : capture.frames.back().draws) {
        if (draw.topology == Topology::triangle_list) continue;
        // Where restarts are, only the indices say how many triangles there are.
        if (draw.restart && capture.buffers[draw.index_buffer].bytes.empty()) {
          const std::vector<std::byte> record = payload(buffers_[draw.index_buffer]);
          FieldReader in(record, buffers_[draw.index_buffer]);
          in.text("name");
          capture.buffers[draw.index_buffer].bytes = payload(data_chunk(in));
        }
        draw.index_count =
            draw.restart ? static_cast<std::uint32_t>(decode_indices(capture, draw).size())
                         : static_cast<std::uint32_t>(3 * (triangle_count(draw) / std::max(draw.instance_count, 1u)));
        draw.topology = Topology::triangle_list;
        draw.restart = false;
      }
    }
    for (Buffer& buffer : capture.buffers) buffer.bytes.clear();
    return outline;
  } catch (const InputError& error) {
    throw InputError(name_, error.what(), "");
  }
}

}  // namespace subpixel::capture
