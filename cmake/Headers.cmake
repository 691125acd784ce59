# Ways to compile the project in half the time: precompiled headers, and the sources of a library as one file. Nothing
# depends on them, and without SELFPROJ_FAST_BUILD every source is compiled alone.
option(SELFPROJ_FAST_BUILD "Precompile headers of libraries, and compile the sources of each library as one file" OFF)

# g++ looks through its memory for what it no longer needs when that has doubled. Below 1 GB it need not: a tenth of the
# time.
if(SELFPROJ_FAST_BUILD)
  add_compile_options($<$<COMPILE_LANG_AND_ID:CXX,GNU>:--param=ggc-min-heapsize=1000000>)
endif()

# An invalid precompiled header only costs time. In the builds where warnings are errors, it is found.
set(CMAKE_PCH_WARN_INVALID ${SELFPROJ_WARNINGS_AS_ERRORS})

# selfproj_precompile(NAME HEADERS header... [OPTIONS option...] [LIBRARIES library...])
# selfproj_use_precompiled(NAME target...)
#
# Precompiles headers of libraries once for many sources; reading them takes half of the compile time of a source. NAME
# is an object library that reads them with these options and libraries. Sources still include every header that they
# need. Preset dev uses no precompiled headers and compiles each source alone, so it finds missing includes.
#
# g++ accepts a precompiled header only for a source with the same macros and instruction set, and since version 13 only
# with the same optimization. So a source with its own options goes without (SKIP_PRECOMPILE_HEADERS).
function(selfproj_precompile name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "HEADERS;OPTIONS;LIBRARIES")
  if(arg_UNPARSED_ARGUMENTS OR NOT arg_HEADERS)
    message(FATAL_ERROR "selfproj_precompile(${name}): HEADERS missing, or unknown: ${arg_UNPARSED_ARGUMENTS}")
  endif()
  set(source "${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp")
  file(CONFIGURE OUTPUT "${source}" CONTENT "// Written by cmake/Headers.cmake.\n" @ONLY)
  add_library(${name} OBJECT EXCLUDE_FROM_ALL "${source}")
  target_compile_options(${name} PRIVATE ${arg_OPTIONS} $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
  target_link_libraries(${name} PRIVATE selfproj_warnings ${arg_LIBRARIES})
  list(TRANSFORM arg_HEADERS REPLACE "^(.+)$" "<\\1>")
  target_precompile_headers(${name} PRIVATE ${arg_HEADERS})
endfunction()

function(selfproj_use_precompiled name)
  get_target_property(shared ${name} POSITION_INDEPENDENT_CODE)
  foreach(target IN LISTS ARGN)
    if(shared)
      selfproj_for_shared_libraries(${target})
    endif()
    if(SELFPROJ_FAST_BUILD)
      target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)  # for ccache
      target_precompile_headers(${target} REUSE_FROM ${name})
    endif()
  endforeach()
endfunction()

# selfproj_for_shared_libraries(TARGET...)
#
# Compiles the targets such that shared libraries can contain them. Their names are hidden, so that the code is as fast
# as that of a program, and a shared library exports only what it marks. Targets that use a precompiled header of this
# kind are compiled in the same way, because g++ accepts the header only then.
function(selfproj_for_shared_libraries)
  set_target_properties(${ARGN} PROPERTIES
    POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
endfunction()

# selfproj_compile_as_one(TARGET...)
#
# Compiles the sources of each target as one file: headers are read once, and the templates of JSON, fmt, OpenCV and
# GoogleTest are instantiated once. The names in the unnamed namespaces of a target must therefore differ. A source with
# its own compile options is compiled alone.
function(selfproj_compile_as_one)
  if(SELFPROJ_FAST_BUILD)
    set_target_properties(${ARGN} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
  endif()
endfunction()

# selfproj_alone(OPTION source...): compiles sources of a library with an option of their own.
function(selfproj_alone option)
  set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS "${option}" SKIP_PRECOMPILE_HEADERS ON)
endfunction()

set(SELFPROJ_STANDARD_HEADERS
  algorithm array bit chrono cmath cstddef cstdint cstdio cstdlib cstring deque filesystem fstream functional iterator
  limits map memory numbers numeric optional random set span sstream stdexcept string string_view system_error thread
  utility variant vector)
