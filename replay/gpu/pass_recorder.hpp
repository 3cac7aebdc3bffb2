// Collects the passes of a technique or of the front-end. A pass declares what it reads and writes; barriers, layouts
// and timers follow from that. The recorded sequence can be run any number of times.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "replay/gpu/pipeline.hpp"
#include "replay/gpu/resources.hpp"

namespace subpixel::gpu {

// A buffer that a pass reaches by its address.
struct AddressedUse {
  Buffer* buffer = nullptr;
  bool is_written = false;
};

// Hands out the addresses that a pass passes on in its push constants; with the address, the use is declared, from
// which its barrier follows. Nothing else but an AddressTable hands out addresses.
class AddressUses {
 public:
  std::uint64_t reads(Buffer& buffer) {
    addressed.push_back({&buffer, false});
    return buffer.address();
  }
  std::uint64_t writes(Buffer& buffer) {  // or reads and writes
    addressed.push_back({&buffer, true});
    return buffer.address();
  }

  std::vector<AddressedUse> addressed;
};

// A buffer of addresses, for shaders whose push constants have no room for them. A pass that binds it uses what they
// lead to as it uses the table: `reads` or `writes`.
class AddressTable {
 public:
  AddressTable(Device& device, std::string name, VkDeviceSize bytes) : buffer_(device, std::move(name), bytes) {}
  // The address of a buffer that the table is going to hold.
  std::uint64_t of(Buffer& target) {
    if (std::ranges::find(targets_, &target) == targets_.end()) targets_.push_back(&target);
    return target.address();
  }
  // `value`: a structure of what of() returned. The device must be idle.
  template <typename T>
  void set(const T& value) {
    buffer_.as<T>()[0] = value;
  }
  Buffer& buffer() { return buffer_; }
  VkDeviceSize bytes() const { return buffer_.bytes(); }
  const std::vector<Buffer*>& targets() const { return targets_; }

 private:
  Buffer buffer_;
  std::vector<Buffer*> targets_;
};

struct Binding {
  enum class Kind { uniform, storage_read, storage_write, sampled, image_write };
  Kind kind = Kind::storage_read;
  std::uint32_t slot = 0;  // within its kind's range: storage 0..10, sampled 0..7, storage image 0..3
  Buffer* buffer = nullptr;
  Image* image = nullptr;
  const Sampler* sampler = nullptr;     // sampled; none: the recorder's nearest, clamped sampler
  const AddressTable* table = nullptr;  // whose buffer it is
};

Binding uniform(Buffer& buffer);
Binding reads(std::uint32_t slot, Buffer& buffer);
Binding writes(std::uint32_t slot, Buffer& buffer);  // or reads and writes
Binding reads(std::uint32_t slot, AddressTable& table);
Binding writes(std::uint32_t slot, AddressTable& table);  // what the addresses lead to
Binding samples(std::uint32_t slot, Image& image, const Sampler* sampler = nullptr);
Binding image_writes(std::uint32_t slot, Image& image);

struct PushConstants {
  std::array<std::byte, kPushConstantBytes> bytes{};
  std::uint32_t size = 0;  // of the value they are made of
  PushConstants() = default;
  template <typename T>
  explicit PushConstants(const T& value) : size(sizeof(T)) {
    static_assert(sizeof(T) <= kPushConstantBytes);
    std::memcpy(bytes.data(), &value, sizeof(T));
  }
};

struct ComputePass : AddressUses {
  std::string name, shader;
  Constants constants;
  std::vector<Binding> bindings;
  PushConstants push;
  std::array<std::uint32_t, 3> groups{1, 1, 1};
  VkDescriptorSet material = VK_NULL_HANDLE;  // set 1, if the shader reads a material's textures
  Buffer* indirect = nullptr;                 // the three group counts are read from its start instead of `groups`
  std::uint64_t fragments = 0;                // that it goes through, of passes over lists of them
};

struct RasterPass;

// Binds further state between the draws of one raster pass.
class DrawEncoder {
 public:
  DrawEncoder(Device& device, VkCommandBuffer commands, const RasterPass& pass)
      : device_(device), commands_(commands), pass_(pass) {}
  void push(const PushConstants& push);  // as many bytes as the pass's own
  void pipeline(std::size_t number);     // 0: the pass's own; then its alternatives
  void material(VkDescriptorSet set);
  void index_buffer(const Buffer& buffer);  // 32-bit
  void draw(std::uint32_t vertices, std::uint32_t instances = 1, std::uint32_t first_vertex = 0,
            std::uint32_t first_instance = 0);
  void draw_indexed(std::uint32_t indices, std::uint32_t instances, std::uint32_t first_index,
                    std::uint32_t first_instance);
  void draw_indexed_indirect(const Buffer& buffer, VkDeviceSize offset);  // one draw
  void viewport(float x, float y, float width, float height);

 private:
  Device& device_;
  VkCommandBuffer commands_;
  const RasterPass& pass_;
};

// One layer of an image that a raster pass draws to.
struct Attachment {
  Image* image = nullptr;
  std::uint32_t layer = 0;
  Attachment() = default;
  Attachment(Image& target, std::uint32_t target_layer = 0) : image(&target), layer(target_layer) {}
};

// The frame's triangles that a raster pass draws, which decide how many fragments it shades: those of the front-end
// that are on the screen. Small ones left to a compute pass of the same name count as drawn.
enum class Triangles { none, all };

struct RasterPass : AddressUses {
  std::string name;
  RasterDescription pipeline;  // bound first; the formats of its targets are those of the attachments below
  std::vector<RasterDescription> alternatives;  // that `draws` may bind; the targets are the same
  std::vector<Attachment> colours;
  Image* depth = nullptr;
  std::array<std::uint32_t, 2> size{};  // pixels; of a pass without attachments
  // Where the targets are rows of a higher frame: the first of them, and how many the frame has; 0: as the targets.
  std::uint32_t first_row = 0, frame_rows = 0;
  // Rows of the targets that are drawn to, the first and how many; 0: all.
  std::array<std::uint32_t, 2> scissor_rows{};
  std::vector<std::array<std::uint32_t, 4>> clear_colours;  // bits; with targets.clear, one each
  float clear_depth = 0;
  std::vector<Binding> bindings;
  std::vector<Buffer*> indices_and_indirect;  // buffers the draws read as indices or indirect commands
  PushConstants push;                         // with `draws` that push their own: the first of them
  Triangles triangles = Triangles::none;
  std::function<void(DrawEncoder&)> draws;  // empty: one full-screen triangle
};

struct PassTiming {
  std::string name;
  std::vector<double> ms;              // one for each run since clear_timings
  std::uint64_t screen_pixels = 0;     // of the full-screen triangles of one run
  std::uint64_t listed_fragments = 0;  // that compute passes of one run go through
  std::uint32_t times_all = 0;         // that one run draws those triangles
};

class PassRecorder {
 public:
  explicit PassRecorder(Device& device);
  ~PassRecorder();  // waits for pipelines that are being made for it: nothing goes on beside what comes next
  PassRecorder(const PassRecorder&) = delete;
  PassRecorder& operator=(const PassRecorder&) = delete;

  // Resources the technique owns; counted in allocated_bytes and held in the device's ledger, which may throw
  // OverBudget. References stay valid for the recorder's life.
  Buffer& buffer(std::string name, VkDeviceSize bytes);
  Image& image(const ImageDescription& description);
  AddressTable& address_table(std::string name, VkDeviceSize bytes);
  std::uint64_t allocated_bytes() const;

  void compute(ComputePass pass);
  void raster(RasterPass pass);
  void fill(const std::string& name, Buffer& buffer, std::uint32_t value);
  // Host work between passes (reading a device-side total); not timed.
  void host(std::function<void()> work);
  // A pass whose work the host does, timed as the others are.
  void host_pass(const std::string& name, std::function<void()> work);

  // Runs all passes once, in order, waiting after each; adds to the timings.
  void run();
  void clear_timings() {
    for (auto& timing : timings_) timing.ms.clear();
  }
  const std::vector<PassTiming>& timings() const { return timings_; }
  Device& device() { return device_; }

 private:
  void hold(const std::string& name, std::uint64_t bytes);
  struct Use {
    Buffer* buffer = nullptr;
    Image* image = nullptr;
    AccessState state;
  };
  struct Step {
    std::size_t timing = 0;
    std::vector<Use> uses;
    std::function<void(VkCommandBuffer)> record;
    std::function<void()> host;
    bool is_pass = true;  // which is timed
  };
  void bind(VkCommandBuffer commands, VkPipelineBindPoint point, const std::vector<Binding>& bindings,
            const std::vector<Attachment>& inputs);
  std::vector<Use> uses_of(const std::vector<Binding>& bindings, VkPipelineStageFlags2 stages) const;
  void barrier(VkCommandBuffer commands, const std::vector<Use>& uses);
  std::size_t timing(const std::string& name);
  void require_interface(const std::string& pass, const std::vector<std::string>& shaders, SuppliedInterface supplied,
                         const Constants& constants, const std::vector<Binding>& bindings, const PushConstants& push,
                         const std::vector<Use>& uses);
  std::string undeclared_address(const ShaderStage& stage, const PushConstants& push,
                                 const std::vector<Use>& uses) const;
  static void add_addressed(std::vector<Use>& uses, const AddressUses& addresses, VkPipelineStageFlags2 stages);
  VkFramebuffer framebuffer(const RasterPass& pass, VkRenderPass render_pass);

  Device& device_;
  std::deque<Buffer> buffers_;
  std::deque<Image> images_;
  std::deque<AddressTable> tables_;
  std::vector<Step> steps_;
  std::vector<PassTiming> timings_;
  Sampler nearest_;
  std::vector<UniqueFramebuffer> framebuffers_;
  std::vector<const Pipeline*> pipelines_;
  std::uint64_t held_ = 0;
};

}  // namespace subpixel::gpu
