# embed_files(TARGET HEADER FUNCTION FILE...): adds the library TARGET whose FUNCTION, a qualified name that HEADER declares,
# returns the files as EmbeddedFile (base/embedded_file.hpp) in the order given. An edit of a file is in the next build.
set(write_embedded_files ${CMAKE_CURRENT_LIST_DIR}/write_embedded_files.cmake)
function(embed_files target header function)
  set(output ${CMAKE_CURRENT_BINARY_DIR}/${target}.cpp)
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${output} -DHEADER=${header} -DFUNCTION=${function} "-DFILES=${ARGN}"
            -P ${write_embedded_files}
    DEPENDS ${ARGN} ${write_embedded_files}
    COMMENT "Embedding the files of ${target}"
    VERBATIM)
  add_library(${target} STATIC ${output})
endfunction()
