# selfproj_verilate(TARGET TOP module PREFIX name [TRACE] [COVERAGE] [PARAMETERS Name=Value...])
#
# Adds the Verilated model of an RTL module to the library TARGET, as class `name` (header name.h). All of rtl/ is given to
# Verilator, the package first; what the top does not instantiate is left out. Every model of a program belongs into one
# library, since each library carries Verilator's runtime.
find_package(verilator REQUIRED HINTS $ENV{VERILATOR_ROOT})
find_package(Threads REQUIRED)

option(SELFPROJ_COVERAGE "Count line and toggle coverage of rtl/ in the Verilated models" OFF)

file(GLOB SELFPROJ_RTL CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/rtl/*/sp_*.sv")
list(REMOVE_ITEM SELFPROJ_RTL "${PROJECT_SOURCE_DIR}/rtl/common/sp_spec_pkg.sv")
list(PREPEND SELFPROJ_RTL "${PROJECT_SOURCE_DIR}/rtl/common/sp_spec_pkg.sv")

function(selfproj_verilate target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "TRACE" "TOP;PREFIX" "PARAMETERS")
  if(arg_UNPARSED_ARGUMENTS OR NOT arg_TOP OR NOT arg_PREFIX)
    message(FATAL_ERROR "selfproj_verilate(${target}): TOP or PREFIX missing, or unknown: ${arg_UNPARSED_ARGUMENTS}")
  endif()
  set(options -Wall -O3 --x-assign fast --x-initial fast --assert)
  foreach(parameter IN LISTS arg_PARAMETERS)
    list(APPEND options "-G${parameter}")
  endforeach()
  set(features "")
  if(arg_TRACE)
    list(APPEND features TRACE_FST)
  endif()
  if(SELFPROJ_COVERAGE)
    list(APPEND options --coverage-line --coverage-toggle)
    list(APPEND features COVERAGE)
  endif()
  # The model is always built for speed: an unoptimized one is ten times slower, and there is nothing to step through.
  verilate(${target} ${features} SOURCES ${SELFPROJ_RTL} TOP_MODULE ${arg_TOP} PREFIX ${arg_PREFIX}
    VERILATOR_ARGS ${options} OPT_FAST -O3 OPT_SLOW -O1 OPT_GLOBAL -O2)
  # Headers of others: their warnings are not ours.
  get_target_property(includes ${target} INTERFACE_INCLUDE_DIRECTORIES)
  list(REMOVE_ITEM includes "${PROJECT_SOURCE_DIR}")
  set_property(TARGET ${target} PROPERTY INTERFACE_SYSTEM_INCLUDE_DIRECTORIES ${includes})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${SELFPROJ_RTL})
endfunction()
