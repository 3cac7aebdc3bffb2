// A file compiled into the binary: what the sources that cmake/EmbedFiles.cmake generates are made of.
#pragma once

#include <string_view>

namespace subpixel {

struct EmbeddedFile {
  std::string_view path;  // the file's name: "app.js"
  std::string_view media_type;
  std::string_view etag;  // of the content, quotes included
  std::string_view content;
};

}  // namespace subpixel
