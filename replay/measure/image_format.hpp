// What kind of file an image's is, and whether it is all there.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace subpixel::replay {

// OpenImageIO's name of the format of a file that begins with `start`, or where that says nothing its path's ending in
// lower case (TGA has no signature); empty when there is none either.
std::string image_format(std::string_view start, const std::filesystem::path& path);

// Whether the last part of a whole PNG or JPEG file is missing, of which their libraries give what there is. PNG ends
// with a chunk IEND (PNG specification, 5.6), JPEG with a marker EOI, FF D9 (ITU-T T.81, B.1.1), which no entropy-coded
// data holds. False for other formats.
bool is_cut_short(std::string_view bytes, std::string_view format);

}  // namespace subpixel::replay
