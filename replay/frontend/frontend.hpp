// Triangle set-up and coverage: turns the draws of a frame into ordered fragments with exact masks.
// Source of the scheme: docs/frontend.md (snapped vertices, exact edges, conservative hulls).
#pragma once

#include <cstdint>
#include <vector>

#include "replay/frontend/host_setup.hpp"
#include "replay/gpu/pass_recorder.hpp"
#include "replay/scene/gpu_scene.hpp"
#include "shaders/frontend/frontend_interface.h"

namespace subpixel::replay {

// Who sets up triangles, to the same bits: the device's shaders or the host's threads (host_setup.hpp).
enum class SetupPlace { device, host };
// The host for CPU devices, whose processor it is, and for devices without doubles.
SetupPlace setup_place(const gpu::Device& device);

class Frontend {
 public:
  Frontend(gpu::Device& device, GpuScene& scene) : Frontend(device, scene, setup_place(device)) {}
  Frontend(gpu::Device& device, GpuScene& scene, SetupPlace place) : device_(device), scene_(scene), place_(place) {}

  // Sizes everything for the scene's current frame at `samples` per pixel, by running set-up once.
  void prepare(std::uint32_t samples);

  // The set-up passes, all named "setup". prepare() must have been called for the frame and sample count.
  void record_setup(gpu::PassRecorder& recorder);

  // A geometry pass over all hulls in submission order. `pass` comes with name, fragment shader (by `fragment_opaque`
  // and `fragment_alpha`), targets and bindings; geometry, materials and draws are added. With `by_material` the draws
  // carry attributes (hull.vert:ATTRIBUTES) and `fragment_alpha` is not used.
  struct GeometryPass {
    gpu::RasterPass pass;
    std::string fragment_opaque, fragment_alpha;
    bool by_material = false;
    // Has pixels of the frame's numbers even where rows of it are drawn: for shaders to which hulls matter, not only
    // what they hold. Of passes without attachments.
    bool rasterise_frame = false;
    bool without_small = false;  // leaves out the triangles that record_small_list() listed; not with `by_material`
  };
  void record_geometry(gpu::PassRecorder& recorder, GeometryPass geometry);

  // Fragments of a geometry pass, counted by drawing it once more after the recorded passes have run: pixels, summed
  // over triangles, of which the triangle covers a sample, before depth and alpha.
  // Of `width` x `height` pixels, rows `first` to `first` + `rows` - 1.
  std::uint64_t count_fragments(std::uint32_t width, std::uint32_t height, std::uint32_t first, std::uint32_t rows);
  std::uint64_t count_fragments(std::uint32_t width, std::uint32_t height) {
    return count_fragments(width, height, 0, height);
  }

  // Triangles so small that passes do better to find their pixels in compute (COUNT_SMALL_ bits): how many, known from
  // prepare(); where their records are listed, in submission order, once the passes named `name` have run. Alpha-tested
  // ones on demand.
  std::uint64_t small_count(bool with_tested = false) const { return small_count_ + (with_tested ? small_tested_ : 0); }
  // Blocks of pixels in the bounding boxes of the opaque ones, all together.
  std::uint64_t small_blocks() const { return small_blocks_; }
  void record_small_list(gpu::PassRecorder& recorder, const std::string& name, bool with_tested = false);
  gpu::Buffer& small_records() { return small_records_; }

  // Specialization constants every front-end shader takes: samples and features.
  gpu::Constants constants() const;

  std::uint32_t samples() const { return samples_; }
  std::uint64_t hull_count() const { return hulls_; }               // screen triangles after culling and clipping
  std::uint64_t hull_triangles() const { return hull_triangles_; }  // what their hulls are drawn as
  std::uint64_t clipped_count() const { return clipped_; }          // source triangles that crossed a clip plane
  std::uint64_t allocated_bytes() const;
  GpuScene& scene() { return scene_; }
  gpu::Device& device() const { return device_; }
  std::uint64_t record_count() const { return records_.bytes() / sizeof(gpu_types::TriangleRecord); }
  gpu::Buffer& clip_matrices() { return clip_matrices_; }  // object to clip, one for each instance
  std::uint32_t triangle_slots() const { return chunk_count_ * SUBPIXEL_CHUNK_TRIANGLES; }  // records of pieces follow
  // Consecutive draws of one material, as chunks of SUBPIXEL_CHUNK_TRIANGLES triangles.
  struct Batch {
    std::uint32_t first_chunk = 0, last_chunk = 0;  // [first, last)
    std::uint32_t material = 0;
    bool alpha_test = false;
  };
  const std::vector<Batch>& material_batches() const { return material_batches_; }
  std::uint32_t chunk_count() const { return chunk_count_; }
  gpu::Buffer& counts() { return counts_; }            // by slot, COUNT_ bits of frontend_types.h
  gpu::Buffer& piece_bases() { return piece_bases_; }  // of clipped slots
  // Push constants of a pass over fragments of `material`, whose uses they declare.
  gpu_types::HullPush hull_push(gpu::AddressUses& pass, std::uint32_t material);
  // For tests: the records and the hull indices (4 * record + corner, 3 a hull triangle) of the last run.
  gpu::Buffer& records() { return records_; }
  gpu::Buffer& hull_indices() { return hull_indices_; }

 private:
  void build_chunks();
  void build_clip_matrices();
  void record_triangles(gpu::PassRecorder& recorder);
  HostSetupInput host_input() const;
  gpu_types::SetupPush setup_push(gpu::AddressUses& pass);
  std::vector<gpu::Binding> clip_bindings();
  void record_culling(gpu::PassRecorder& recorder);
  void record_arguments(gpu::PassRecorder& recorder, const std::string& name, std::size_t batches, gpu::Buffer& ranges,
                        gpu::Buffer& sums, gpu::Buffer& commands);

  gpu::Device& device_;
  GpuScene& scene_;
  SetupPlace place_;
  std::vector<std::uint32_t> host_clipped_;  // of the last run
  std::uint32_t samples_ = 0;
  std::uint32_t chunk_count_ = 0;
  std::uint64_t hulls_ = 0, hull_triangles_ = 0, clipped_ = 0, pieces_ = 0, small_count_ = 0, small_tested_ = 0,
                small_blocks_ = 0;
  std::vector<Batch> material_batches_, visibility_batches_;
  gpu::Buffer chunks_, clip_matrices_, counts_, clip_list_, clip_count_, sums_, piece_bases_, records_, hull_indices_;
  gpu::Buffer rest_sums_, rest_indices_, rest_commands_, small_records_;
  gpu::Buffer material_ranges_, visibility_ranges_, material_commands_, visibility_commands_;
};

}  // namespace subpixel::replay
