# embed_shaders(TARGET STATIC|OBJECT TABLE SHADER...): compiles the shaders, named from the folder shaders/, to SPIR-V with
# glslang, one file each under ${SUBPIXEL_SPIRV_DIR}, and adds the library TARGET whose function TABLE
# (shaders/embedded.hpp) lists them.
# A shader that needs variants says so in its first lines:
#   // variants: NAME=-DX=1,-DY=2 OTHER=...
# makes "path/file.frag:NAME". A shader without that line is compiled once, as "path/file.frag". The files are named
# path/file.frag.NAME.spv and path/file.frag.spv; `cmake --build ... --target shaders_spv` brings just them up to date.
set(shader_root ${PROJECT_SOURCE_DIR}/shaders)
find_program(GLSLANG NAMES glslangValidator glslang REQUIRED)
enable_language(ASM)
option(SUBPIXEL_SHADER_SYMBOLS "Names and sources of shaders go into their SPIR-V, for RenderDoc and the validation layer" OFF)
set(glslang_flags -V --target-env vulkan1.3 -I${shader_root})
if(SUBPIXEL_SHADER_SYMBOLS)
  # Not -gV, -gVS: glslang 12 makes modules of them that are not valid wherever a shader has buffer references.
  list(APPEND glslang_flags -g)
endif()
set(SUBPIXEL_SPIRV_DIR ${CMAKE_BINARY_DIR}/spirv)
function(embed_shaders target kind table)
  set(spirv_files)
  set(entries "")
  set(declarations "")
  set(assembly "")
  foreach(source ${ARGN})
    file(STRINGS ${shader_root}/${source} variant_line REGEX "^// variants: " LIMIT_COUNT 1)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${shader_root}/${source})
    if(variant_line)
      string(REPLACE "// variants: " "" variant_line "${variant_line}")
      separate_arguments(variants UNIX_COMMAND "${variant_line}")
    else()
      set(variants "=")
    endif()
    foreach(variant ${variants})
      string(REGEX MATCH "^([^=]*)=(.*)$" matched "${variant}")
      set(name ${source})
      set(file ${source})
      if(NOT "${CMAKE_MATCH_1}" STREQUAL "")
        string(APPEND name ":${CMAKE_MATCH_1}")
        string(APPEND file ".${CMAKE_MATCH_1}")
      endif()
      string(REPLACE "," ";" defines "${CMAKE_MATCH_2}")
      string(MAKE_C_IDENTIFIER "spirv_${file}" symbol)
      set(output ${SUBPIXEL_SPIRV_DIR}/${file}.spv)
      cmake_path(GET output PARENT_PATH folder)
      file(MAKE_DIRECTORY ${folder})
      # glslang's own list of what a shader includes: an edit compiles again what reads the edited file, and no more.
      add_custom_command(OUTPUT ${output}
        COMMAND ${GLSLANG} ${glslang_flags} ${defines} --quiet --depfile ${output}.d -o ${output}
                ${shader_root}/${source}
        DEPENDS ${shader_root}/${source} DEPFILE ${output}.d VERBATIM
        COMMENT "Shader ${name}")
      list(APPEND spirv_files ${output})
      string(APPEND assembly ".balign 4\n.globl ${symbol}\n.globl ${symbol}_end\n"
        "${symbol}:\n.incbin \"${output}\"\n${symbol}_end:\n")
      string(APPEND declarations "extern \"C\" const std::uint32_t ${symbol}[], ${symbol}_end[];\n")
      string(APPEND entries "    {\"${name}\", {${symbol}, ${symbol}_end}},\n")
    endforeach()
  endforeach()
  file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${target}.S CONTENT "// Generated: the SPIR-V of every shader.
.section .rodata
${assembly}.section .note.GNU-stack,\"\",%progbits
" @ONLY)
  file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${target}.cpp CONTENT "// Generated: the names of every shader.
#include \"shaders/embedded.hpp\"
${declarations}
std::span<const subpixel::shaders::Embedded> subpixel::shaders::${table}() {
  static const Embedded table[] = {
${entries}  };
  return table;
}
" @ONLY)
  set_source_files_properties(${CMAKE_CURRENT_BINARY_DIR}/${target}.S PROPERTIES OBJECT_DEPENDS "${spirv_files}")
  add_library(${target} ${kind} ${CMAKE_CURRENT_BINARY_DIR}/${target}.cpp ${CMAKE_CURRENT_BINARY_DIR}/${target}.S)
  add_custom_target(${target}_spv DEPENDS ${spirv_files})
  if(NOT TARGET shaders_spv)
    add_custom_target(shaders_spv)
  endif()
  add_dependencies(shaders_spv ${target}_spv)
endfunction()
