# find_package(Subpixel) gives Subpixel::recorder, a shared library, and Subpixel::recorder_static, the same as an archive,
# with which zstd and xxHash have to be at hand, and in a project that is C alone C++ has to be a language as well.
include(CMakeFindDependencyMacro)
find_dependency(Threads)
include(${CMAKE_CURRENT_LIST_DIR}/SubpixelTargets.cmake)
