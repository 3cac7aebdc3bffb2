# Compiles the sources of TARGET as few large ones where SUBPIXEL_MERGED_SOURCES says so. For targets whose sources have no
# names of their own in common.
function(merge_sources target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${SUBPIXEL_MERGED_SOURCES})
endfunction()
