// OBJ and MTL files of a test's own in a folder of its own.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include "base/error.hpp"
#include "scenes/import/asset_source.hpp"
#include "scenes/import/model.hpp"

namespace subpixel::capture {

// Red, green, blue and alpha (below 0: no alpha channel) of every texel.
inline std::string tga(int red, int green, int blue, int alpha = -1, int side = 2) {
  std::string file(18, '\0');
  file[2] = 2;
  file[12] = file[14] = static_cast<char>(side);
  file[16] = alpha < 0 ? 24 : 32;
  file[17] = alpha < 0 ? 0x20 : 0x28;  // top row first; 8 bits of alpha
  for (int i = 0; i < side * side; ++i) {
    for (const int channel : {blue, green, red}) file += static_cast<char>(channel);
    if (alpha >= 0) file += static_cast<char>(alpha);
  }
  return file;
}

inline constexpr const char* kQuad = R"(v -1 -1 0
v 1 -1 0
v 1 1 0
v -1 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 0 1
)";

class ObjFixture : public testing::Test {
 protected:
  ObjFixture() : folder_(std::filesystem::path(testing::TempDir()) / ("import_obj_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    write("t.tga", tga(200, 100, 50));
  }
  ~ObjFixture() override { std::filesystem::remove_all(folder_); }

  void write(const std::string& name, const std::string& content) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << content;
  }

  Model load(const std::string& name) const { return load_model(*open_folder(folder_), name); }

  Model load_text(const std::string& obj) const {
    write("m.obj", obj);
    return load("m.obj");
  }

  // A quad of the material that `mtl` defines as m.
  Model load_mtl(const std::string& mtl) const {
    write("m.mtl", mtl);
    return load_text(std::string("mtllib m.mtl\n") + kQuad + "usemtl m\nf 1/1/1 2/2/1 3/3/1 4/4/1\n");
  }

  Material material_of(const std::string& mtl) const { return load_mtl(mtl).materials.at(0); }

  std::string refusal_of(const std::string& obj) const {
    try {
      load_text(obj);
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  }

  std::string refusal_of_mtl(const std::string& mtl) const {
    try {
      load_mtl(mtl);
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  }

  std::filesystem::path folder_;
};

inline bool has_notice(const Model& model, const std::string& part) {
  return std::any_of(model.notices.begin(), model.notices.end(),
                     [&](const std::string& notice) { return notice.find(part) != std::string::npos; });
}

}  // namespace subpixel::capture
