# A header with the texts of Python packages: embed_package(OUT FOLDER PACKAGE...)
function(embed_package out folder)
  set(entries "")
  set(count 0)
  foreach(package ${ARGN})
    file(GLOB files CONFIGURE_DEPENDS RELATIVE ${folder} ${folder}/${package}/*.py)
    foreach(file ${files})
      set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${folder}/${file})
      file(READ ${folder}/${file} text)
      # One literal holds 64 KiB by the standard; none of the files is as long.
      string(APPEND entries "    {\"${file}\", R\"python(${text})python\"},\n")
      math(EXPR count "${count} + 1")
    endforeach()
  endforeach()
  file(CONFIGURE OUTPUT ${out} @ONLY CONTENT [[
// Made by cmake/EmbedPackage.cmake.
#pragma once

#include <array>
#include <string_view>
#include <utility>

namespace subpixel::cli {

// Paths below the package folder, and texts.
inline constexpr std::array<std::pair<std::string_view, std::string_view>, @count@> kRenderDocPackage{{
@entries@}};

}  // namespace subpixel::cli
]])
endfunction()
