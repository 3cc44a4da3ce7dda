# The library: one shared (or, with -DBUILD_SHARED_LIBS=OFF, static) library with all SIMD levels. In C++, the first use
# chooses one (dispatch.cpp); find_package(plannercheck) gives plannercheck::plannercheck. Python's modules link it.
#
# Several -march in one shared object leak through weak symbols: of an inline function compiled twice, the linker keeps
# either, and an old processor may meet the new one's instructions. So all objects of a level, those that are compiled
# once included, are joined into one, in which every symbol becomes local but the level's entry and what Python's
# bindings leave undefined: of that, `f` is called `f.v3` in level v3 and in a copy of the bindings for this level. That
# takes GNU ld and objcopy; on macOS, a module has the objects of its level, and no library. Outside there is only the
# face, for the lowest level.
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

set(PLANNERCHECK_GNU_LD "${CMAKE_LINKER}")
if(CMAKE_LINKER MATCHES "lld")  # CMake's choice for Clang; it leaves groups, whose symbols can't be made local
  unset(PLANNERCHECK_GNU_LD)
  find_program(PLANNERCHECK_GNU_LD ld.bfd REQUIRED)
endif()
foreach(level IN LISTS levels)
  target_compile_definitions(face PRIVATE PLANNERCHECK_HAS_${level})
  if(APPLE)
    set(level_objects $<TARGET_OBJECTS:level_${level}> $<TARGET_OBJECTS:common>)
    list(APPEND objects ${level_objects})
    set(bindings_${level} $<TARGET_OBJECTS:bindings> ${level_objects})
    continue()
  endif()
  set_target_properties(level_${level} common PROPERTIES CXX_VISIBILITY_PRESET protected)
  set(joined "${CMAKE_CURRENT_BINARY_DIR}/level_${level}")
  if(PLANNERCHECK_PYTHON)
    set(called "${joined}.called")
    set(renamed "--redefine-syms=${called}")
    set(bindings_${level} "${CMAKE_CURRENT_BINARY_DIR}/bindings_${level}.o")
    add_custom_command(OUTPUT "${called}" "${bindings_${level}}"
      COMMAND "${PLANNERCHECK_GNU_LD}" -r -o "${joined}.bindings.o" $<TARGET_OBJECTS:bindings>
      COMMAND sh -c "'${CMAKE_NM}' -u '${joined}.bindings.o' | sed -n 's/.* \\(.*plannercheck.*\\)/\\1 \\1.${level}/p' > '${called}'"
      COMMAND "${CMAKE_OBJCOPY}" "${renamed}" "${joined}.bindings.o" "${bindings_${level}}"
      DEPENDS bindings $<TARGET_OBJECTS:bindings> COMMAND_EXPAND_LISTS VERBATIM)
  endif()
  add_custom_command(OUTPUT "${joined}.o"
    COMMAND "${PLANNERCHECK_GNU_LD}" -r --force-group-allocation -o "${joined}.all.o" $<TARGET_OBJECTS:level_${level}>
      $<TARGET_OBJECTS:common>
    COMMAND "${CMAKE_OBJCOPY}" ${renamed} --wildcard --keep-global-symbol=*.${level}
      --keep-global-symbol=plannercheck_engine_${level} "${joined}.all.o" "${joined}.o"
    DEPENDS level_${level} common $<TARGET_OBJECTS:level_${level}> $<TARGET_OBJECTS:common> ${called}
    COMMAND_EXPAND_LISTS VERBATIM)
  list(APPEND objects "${joined}.o")
endforeach()
if(APPLE AND PLANNERCHECK_PYTHON)
  return()
endif()

add_library(plannercheck ${objects})
set_target_properties(plannercheck PROPERTIES LINKER_LANGUAGE CXX UNITY_BUILD OFF)
if(PLANNERCHECK_PYTHON)  # all in the package, where a link would be a second file
  set(CMAKE_INSTALL_LIBDIR plannercheck)
  set(CMAKE_INSTALL_INCLUDEDIR plannercheck/include)
  set(package plannercheck/cmake)
else()
  set_target_properties(plannercheck PROPERTIES VERSION "${version}" SOVERSION 0)
  set(package "${CMAKE_INSTALL_LIBDIR}/cmake/plannercheck")
endif()
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

install(TARGETS plannercheck EXPORT plannercheck)
install(DIRECTORY "${folder}/include/" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
install(EXPORT plannercheck NAMESPACE plannercheck:: DESTINATION "${package}" FILE plannercheck-targets.cmake)
write_basic_package_version_file(plannercheck-config-version.cmake VERSION "${version}" COMPATIBILITY SameMinorVersion)
install(FILES "${folder}/plannercheck-config.cmake" "${CMAKE_CURRENT_BINARY_DIR}/plannercheck-config-version.cmake"
  DESTINATION "${package}")
