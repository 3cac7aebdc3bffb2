// Files of other programs: formats, names, channels, layers, parts and windows.
#include "replay/measure/image_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "tests/unit/exr_writer.hpp"

namespace subpixel::replay {
namespace {

namespace fs = std::filesystem;
using tests::exr_file;
using tests::ExrPart;

constexpr tests::ExrBox kWhole{0, 0, 7, 5};

// A value that tells channel and place.
float value_of(const std::string& channel, int x, int y) {
  float value = static_cast<float>(x + 10 * y);
  for (const char c : channel) value += 1000.0F * static_cast<float>(c);
  return value;
}

ExrPart part_of(std::vector<std::string> channels, const std::string& name = "") {
  return {name, std::move(channels), kWhole, kWhole, value_of};
}

class OtherImages : public testing::Test {
 protected:
  OtherImages() {
    std::string name = (fs::temp_directory_path() / "subpixel_files_XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~OtherImages() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  fs::path write(const std::string& name, const std::vector<std::uint8_t>& bytes) {
    return write(name, std::string(bytes.begin(), bytes.end()));
  }
  ImageFile read(const std::vector<ExrPart>& parts, std::string_view layer = "") {
    return read_image_file(write("a.exr", exr_file(parts)), layer);
  }
  std::string refusal(const fs::path& path, std::string_view layer = "") {
    try {
      read_image_file(path, layer);
    } catch (const InputError& error) {
      const std::string words = error.what();
      EXPECT_TRUE(words.ends_with(": " + path.string())) << words;
      EXPECT_EQ(words.find('\n'), std::string::npos) << words;
      return words.substr(0, words.size() - path.string().size());
    }
    return "accepted";
  }
  fs::path folder_;
};

void expect_values(const ImageFile& file) {
  for (std::uint32_t y = 0; y < file.image.height; ++y)
    for (std::uint32_t x = 0; x < file.image.width; ++x)
      for (std::uint32_t c = 0; c < file.image.channels; ++c)
        ASSERT_EQ(file.image.pixels[file.image.offset(x, y) + c],
                  value_of(file.channels[c], static_cast<int>(x), static_cast<int>(y)));
}

TEST_F(OtherImages, ColoursAreFoundByTheirNamesAmongOthers) {
  const ImageFile plain =
      read({part_of({"Z", "B", "A", "G", "R", "N.x", "sampleCount.R", "sampleCount.G", "sampleCount.B"})});
  EXPECT_EQ(plain.channels, (std::vector<std::string>{"R", "G", "B", "A"}));
  EXPECT_EQ(plain.left_out.size(), 5U);
  expect_values(plain);
  const ImageFile layered = read({part_of({"diffuse.R", "diffuse.G", "diffuse.B", "depth.Z"})});
  EXPECT_EQ(layered.channels, (std::vector<std::string>{"diffuse.R", "diffuse.G", "diffuse.B"}));
  EXPECT_EQ(layered.left_out, std::vector<std::string>{"depth.Z"});
  expect_values(layered);
  const ImageFile grey = read({part_of({"Y", "Z"})});
  EXPECT_EQ(grey.image.channels, 1U);
  expect_values(grey);
  EXPECT_EQ(read({part_of({"Y", "A"})}).image.channels, 4U);
}

TEST_F(OtherImages, LayersAndPartsAreChosenByName) {
  const std::vector<std::string> both = {"a.R", "a.G", "a.B", "b.c.R", "b.c.G", "b.c.B", "b.c.A"};
  EXPECT_EQ(read({part_of(both)}, "b.c").channels, (std::vector<std::string>{"b.c.R", "b.c.G", "b.c.B", "b.c.A"}));
  const fs::path path = write("layers.exr", exr_file({part_of(both)}));
  EXPECT_EQ(refusal(path), "image: several layers have colours, and --layer names none: a, b.c: ");
  EXPECT_EQ(refusal(path, "c"), "image: it has no layer c with colours, only a, b.c: ");

  const std::vector<ExrPart> parts = {part_of({"Z"}, "depth"), part_of({"R", "G", "B"}, "left"),
                                      part_of({"R", "G", "B", "A"}, "right")};
  const ImageFile first = read(parts);
  EXPECT_EQ(first.image.channels, 3U);
  EXPECT_EQ(first.left_out, (std::vector<std::string>{"depth:Z", "right:R", "right:G", "right:B", "right:A"}));
  expect_values(first);
  EXPECT_EQ(read(parts, "right").image.channels, 4U);
  EXPECT_EQ(refusal(write("parts.exr", exr_file(parts)), "depth"),
            "image: it has no layer depth with colours, only left, right: ");
}

TEST_F(OtherImages, FilesWithoutColoursSayWhatTheyHave) {
  EXPECT_EQ(refusal(write("z.exr", exr_file({part_of({"Z"})}))), "image: it has no colours (R, G, B or Y), only Z: ");
  EXPECT_EQ(refusal(write("r.exr", exr_file({part_of({"R", "G", "id"})}))),
            "image: it has no colours (R, G, B or Y), only R, G, id: ");
  std::vector<std::string> many;
  for (int i = 0; i < 40; ++i) many.push_back("id" + std::to_string(10 + i));
  EXPECT_NE(refusal(write("many.exr", exr_file({part_of(many)}))).find("id21 and 28 more"), std::string::npos);
}

TEST_F(OtherImages, PixelsLieInTheDisplayWindow) {
  ExrPart part = part_of({"R", "G", "B", "A"});
  part.data = {3, 1, 9, 2};  // two columns beyond the right side
  const ImageFile cropped = read({part});
  EXPECT_EQ(cropped.window, (PixelWindow{0, 0, 8, 6}));
  EXPECT_EQ(cropped.pixels_outside, 4U);
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 8; ++x)
      for (std::uint32_t c = 0; c < 4; ++c)
        EXPECT_EQ(cropped.image.pixels[cropped.image.offset(x, y) + c],
                  x >= 3 && y >= 1 && y <= 2 ? value_of(cropped.channels[c], x, y) : 0.0F);
  part.display = {-4, -4, 3, 1};
  const ImageFile moved = read({part});
  EXPECT_EQ(moved.window, (PixelWindow{-4, -4, 8, 6}));
  EXPECT_EQ(moved.image.pixels[moved.image.offset(7, 5)], value_of("R", 3, 1));
  part.display = {100, 100, 101, 101};
  const ImageFile apart = read({part});
  EXPECT_EQ(apart.pixels_outside, 14U);
  EXPECT_EQ(apart.image.pixels, std::vector<float>(16, 0.0F));
}

TEST_F(OtherImages, NamesAndEndingsMeanNothing) {
  const Image image(9, 5, 3, Encoding::display, 0.2F);
  for (const char* const name : {"what?x=1.png", "frame%04d.png", "frame#1.png", "my pic \xc3\xbc.png", "UP.PNG",
                                 "wrong.exr", "none", "a.b.c", "line\nend.png", "a?b", "-.png"}) {
    const ImageFile file = read_image_file(write(name, encode_png(image)));
    EXPECT_EQ(file.image.pixels, image.pixels) << name;
  }
  // Not the pattern's other frames either.
  write("frame0001.png", encode_png(image));
  EXPECT_NE(refusal(folder_ / "frame%03d.png"), "accepted");
  EXPECT_NE(refusal(folder_ / "frame0001.png?x=1"), "accepted");
}

TEST_F(OtherImages, WhatCannotBeReadIsRefusedInOneLine) {
  const auto expect = [&](const std::string& name, const std::string& bytes, const std::string& why) {
    EXPECT_NE(refusal(write(name, bytes)).find(why), std::string::npos) << name << refusal(folder_ / name);
  };
  expect("empty.png", "", "empty");
  expect("text", "this is no image", "no kind that can be read");
  expect("text.png", "this is no image", "");
  expect("text.xyz", "this is no image", "no kind that can be read");
  EXPECT_NE(refusal(folder_ / "none.png").find("No such file"), std::string::npos);
  EXPECT_NE(refusal(folder_).find("not a regular file"), std::string::npos);
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  EXPECT_NE(refusal(folder_ / "pipe").find("not a regular file"), std::string::npos);
  ExrPart huge = part_of({"R", "G", "B"});
  huge.display = {0, 0, 32767, 32767};
  expect("huge.exr", exr_file({huge}), "32768x32768");
  const std::vector<std::uint8_t> jpeg_start = {0xff, 0xd8, 0xff, 0xe0, 0x00, 0x04, 0xff, 0xd9, 0xff, 0xda, 0, 2, 1, 2};
  expect("cut.jpg", std::string(jpeg_start.begin(), jpeg_start.end()), "ends early, after 14 bytes");
}

TEST_F(OtherImages, EveryCutOfAFileIsRefused) {
  Image image(40, 30, 3);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] = static_cast<float>(i * i * 7919 % 251) / 250.0F;
  const std::vector<std::uint8_t> png = encode_png(image);
  const std::string exr = exr_file({part_of({"R", "G", "B"})});
  for (const std::string& whole : {std::string(png.begin(), png.end()), exr}) {
    ASSERT_EQ(refusal(write("whole", whole)), "accepted");
    for (const std::size_t left : {whole.size() - 1, whole.size() - 4, whole.size() - 12, whole.size() * 3 / 4,
                                   whole.size() / 2, std::size_t{40}, std::size_t{9}, std::size_t{1}})
      EXPECT_NE(refusal(write("cut", whole.substr(0, left))), "accepted") << left;
  }
}

}  // namespace
}  // namespace subpixel::replay
