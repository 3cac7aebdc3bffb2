# Writes OUTPUT, which defines subpixel::build_commit(), from the git repository SOURCES; leaves it alone when nothing has
# changed. Run by every build, since a commit changes no source.
set(commit "")
find_program(GIT git)
if(GIT)
  execute_process(COMMAND ${GIT} -C ${SOURCES} rev-parse --verify HEAD OUTPUT_VARIABLE head ERROR_QUIET
    OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed)
  execute_process(COMMAND ${GIT} -C ${SOURCES} rev-parse --show-toplevel OUTPUT_VARIABLE top ERROR_QUIET
    OUTPUT_STRIP_TRAILING_WHITESPACE)
  file(REAL_PATH "${SOURCES}" own)
  # Sources unpacked inside of another repository have no commit.
  if(NOT failed AND top STREQUAL own)
    set(commit ${head})
    execute_process(COMMAND ${GIT} -C ${SOURCES} --no-optional-locks diff --quiet HEAD -- RESULT_VARIABLE changed)
    if(changed)
      string(APPEND commit "-changed")
    endif()
  endif()
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT [[// Generated.
#include "base/build_commit.hpp"
namespace subpixel {
std::string_view build_commit() {
  return "@commit@";
}
}  // namespace subpixel
]] @ONLY)
