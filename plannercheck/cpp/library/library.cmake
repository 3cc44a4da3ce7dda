# The C++ library: one shared (or, with -DBUILD_SHARED_LIBS=OFF, static) library with all SIMD levels, of which the
# first use chooses one (dispatch.cpp); find_package(plannercheck) gives plannercheck::plannercheck.
#
# Several -march in one shared object leak through weak symbols: of an inline function compiled twice, the linker keeps
# either, and an old processor may meet the new one's instructions. So all objects of a level, those that are compiled
# once included, are joined into one, in which every symbol but the level's entry becomes local. That takes GNU ld and
# objcopy. Outside there is only the face, for the lowest level.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

option(BUILD_SHARED_LIBS "a shared library" ON)

set(folder "${CMAKE_CURRENT_SOURCE_DIR}/library")
file(STRINGS "${CMAKE_CURRENT_SOURCE_DIR}/../../pyproject.toml" version REGEX "^version = ")
string(REGEX REPLACE "^version = \"(.*)\"$" "\\1" version "${version}")

if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(settings INTERFACE -fno-gnu-unique)  # such symbols can't be made local
endif()
add_library(face OBJECT library/dispatch.cpp library/checker.cpp library/checker_scenes.cpp
  library/checker_trajectories.cpp)
target_include_directories(face PRIVATE "${folder}/include")
compile_for_all_levels(face)
set(objects $<TARGET_OBJECTS:face>)

foreach(level IN LISTS levels)
  target_compile_definitions(level_${level} PRIVATE PLANNERCHECK_ENGINE=plannercheck_engine_${level})
  target_compile_definitions(face PRIVATE PLANNERCHECK_HAS_${level})
  if(level STREQUAL "plain")
    list(APPEND objects $<TARGET_OBJECTS:level_${level}> $<TARGET_OBJECTS:common>)
    continue()
  endif()
  set(joined "${CMAKE_CURRENT_BINARY_DIR}/level_${level}")
  add_custom_command(OUTPUT "${joined}.o"
    COMMAND "${CMAKE_LINKER}" -r --force-group-allocation -o "${joined}.all.o" $<TARGET_OBJECTS:level_${level}>
      $<TARGET_OBJECTS:common>
    COMMAND "${CMAKE_OBJCOPY}" --keep-global-symbol=plannercheck_engine_${level} "${joined}.all.o" "${joined}.o"
    DEPENDS level_${level} common $<TARGET_OBJECTS:level_${level}> $<TARGET_OBJECTS:common>
    COMMAND_EXPAND_LISTS VERBATIM)
  list(APPEND objects "${joined}.o")
endforeach()

add_library(plannercheck ${objects})
set_target_properties(plannercheck PROPERTIES LINKER_LANGUAGE CXX VERSION "${version}" SOVERSION 0 UNITY_BUILD OFF)
target_link_libraries(plannercheck PRIVATE Threads::Threads)
if(BUILD_SHARED_LIBS AND NOT APPLE)  # the templates of std that are compiled here stay here
  target_link_options(plannercheck PRIVATE "-Wl,--version-script=${folder}/exports.map,-z,defs")
  set_target_properties(plannercheck PROPERTIES LINK_DEPENDS "${folder}/exports.map")
endif()
target_compile_features(plannercheck INTERFACE cxx_std_20)
if(PLANNERCHECK_SANITIZE)
  target_link_options(plannercheck PUBLIC -fsanitize=${PLANNERCHECK_SANITIZE})
endif()
target_include_directories(plannercheck INTERFACE "$<BUILD_INTERFACE:${folder}/include>"
  "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")

set(package "${CMAKE_INSTALL_LIBDIR}/cmake/plannercheck")
install(TARGETS plannercheck EXPORT plannercheck)
install(DIRECTORY "${folder}/include/" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
install(EXPORT plannercheck NAMESPACE plannercheck:: DESTINATION "${package}" FILE plannercheck-targets.cmake)
write_basic_package_version_file(plannercheck-config-version.cmake VERSION "${version}" COMPATIBILITY SameMinorVersion)
install(FILES "${folder}/plannercheck-config.cmake" "${CMAKE_CURRENT_BINARY_DIR}/plannercheck-config-version.cmake"
  DESTINATION "${package}")
