# selfproj_verilate(TARGET TOP module PREFIX name [TRACE] [UNCOUNTED] [OPEN file] [CLOCKS] [PARAMETERS Name=Value...])
#
# Adds the Verilated model of an RTL module to the library TARGET, as class `name` (header `name`.h). Verilator gets all
# of SELFPROJ_RTL (by default all of rtl/), the package first, and leaves out what the top does not instantiate. It runs
# when the library is built (verilate.cmake). All libraries share one runtime of Verilator.
#
# With TRACE the model can write waveforms (FST).
#
# With CLOCKS, of which the model has clk_i and perhaps bus_clk_i, it gets rise(), which clocks.h (sim/board) declares.
#
# OPEN names a configuration file for Verilator. VPI can set the registers that this file makes public; the next eval()
# updates the logic behind them.
#
# Registers begin with what the context of the model asks for: zeros, or random values (randReset).
#
# With UNCOUNTED the model counts no coverage, even where SELFPROJ_COVERAGE is set, because other models count the same.

set(hints "")
if(DEFINED ENV{VERILATOR_ROOT})
  set(hints HINTS "$ENV{VERILATOR_ROOT}/bin")
endif()
find_program(SELFPROJ_VERILATOR verilator ${hints} REQUIRED
  DOC "Verilator 5.006 or newer; by default that of VERILATOR_ROOT, or the first in PATH")
find_package(ZLIB REQUIRED)  # of waveforms

option(SELFPROJ_COVERAGE "Count line and toggle coverage of rtl/ in the Verilated models" OFF)
option(SELFPROJ_FAST_RISE "Step models by the parts of Verilator's eval() where they are known" ON)

# The models are always built for speed, except for a short run: without optimization they are ten times slower, and
# there is nothing to step through. Vectorization is off because gathering the scattered bits costs more than it saves.
if(SELFPROJ_COVERAGE OR SELFPROJ_QUICK)
  set(selfproj_model_options -O1)
else()
  set(selfproj_model_options -O3 -fno-tree-vectorize -fno-tree-slp-vectorize)
endif()

file(GLOB SELFPROJ_RTL CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/rtl/*/sp_*.sv")
list(REMOVE_ITEM SELFPROJ_RTL "${PROJECT_SOURCE_DIR}/rtl/common/sp_spec_pkg.sv")
list(PREPEND SELFPROJ_RTL "${PROJECT_SOURCE_DIR}/rtl/common/sp_spec_pkg.sv")

# Verilator's runtime, compiled once for all models. selfproj_verilator_interfaces is what DPI and VPI need of it.
if(NOT TARGET selfproj_verilator_runtime)
  execute_process(COMMAND "${SELFPROJ_VERILATOR}" --getenv VERILATOR_ROOT
    OUTPUT_VARIABLE runtime OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  string(APPEND runtime "/include")
  add_library(selfproj_verilator_runtime STATIC EXCLUDE_FROM_ALL
    "${runtime}/verilated.cpp" "${runtime}/verilated_fst_c.cpp" "${runtime}/verilated_threads.cpp")
  if(SELFPROJ_COVERAGE)
    target_sources(selfproj_verilator_runtime PRIVATE "${runtime}/verilated_cov.cpp")
  endif()
  add_library(selfproj_verilator_interfaces STATIC EXCLUDE_FROM_ALL
    "${runtime}/verilated_dpi.cpp" "${runtime}/verilated_vpi.cpp")
  target_compile_definitions(selfproj_verilator_runtime
    PUBLIC VM_COVERAGE=$<BOOL:${SELFPROJ_COVERAGE}> VM_SC=0 VM_TRACE=1 VM_TRACE_FST=1 VM_TRACE_VCD=0)
  target_link_libraries(selfproj_verilator_runtime PUBLIC Threads::Threads ZLIB::ZLIB)
  if(EXISTS "${runtime}/fstcpp")  # newer versions do not bring LZ4
    find_library(SELFPROJ_LZ4 lz4 REQUIRED DOC "LZ4 for waveforms (liblz4-dev)")
    target_link_libraries(selfproj_verilator_runtime PUBLIC "${SELFPROJ_LZ4}")
  endif()
  target_link_libraries(selfproj_verilator_interfaces PUBLIC selfproj_verilator_runtime)
  target_include_directories(selfproj_verilator_runtime SYSTEM PUBLIC "${runtime}" "${runtime}/vltstd")
  foreach(target selfproj_verilator_runtime selfproj_verilator_interfaces)
    target_compile_options(${target} PRIVATE -w -O2)
  endforeach()
  # Tests run the same program.
  find_program(first verilator NO_CACHE)
  if(NOT first STREQUAL SELFPROJ_VERILATOR)
    cmake_path(GET SELFPROJ_VERILATOR PARENT_PATH folder)
    file(WRITE "${PROJECT_BINARY_DIR}/verilator.cmake" "set(ENV{PATH} \"${folder}:\$ENV{PATH}\")\n")
    set_property(DIRECTORY "${PROJECT_SOURCE_DIR}"
      APPEND PROPERTY TEST_INCLUDE_FILES "${PROJECT_BINARY_DIR}/verilator.cmake")
  endif()
  # Verilator's header is most of the cost of a small file.
  selfproj_precompile(selfproj_verilator_headers HEADERS verilated.h OPTIONS ${selfproj_model_options}
    LIBRARIES selfproj_verilator_runtime)
endif()

function(selfproj_verilate target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "TRACE;UNCOUNTED;CLOCKS" "TOP;PREFIX;OPEN" "PARAMETERS")
  if(arg_UNPARSED_ARGUMENTS OR NOT arg_TOP OR NOT arg_PREFIX)
    message(FATAL_ERROR "selfproj_verilate(${target}): TOP or PREFIX missing, or unknown: ${arg_UNPARSED_ARGUMENTS}")
  endif()
  set_property(GLOBAL PROPERTY selfproj_model_${arg_PREFIX} ${arg_TOP} ${arg_PARAMETERS})  # for its netlists
  set(options -Wall -O3 --x-assign fast --x-initial unique --assert --top-module ${arg_TOP})
  list(TRANSFORM arg_PARAMETERS PREPEND -G)
  if(arg_OPEN)
    list(APPEND options --vpi "${arg_OPEN}")
  endif()
  if(arg_TRACE)
    list(APPEND options --trace-fst)
  endif()
  # Any optimization of the function that names thousands of coverage points takes minutes.
  set(seldom -O1)
  if(SELFPROJ_COVERAGE AND NOT arg_UNCOUNTED)
    set(seldom -O0)
    list(APPEND options --coverage-line --coverage-toggle)
  endif()
  set(folder "${CMAKE_CURRENT_BINARY_DIR}/${arg_PREFIX}.dir")
  set(code "${folder}/${arg_PREFIX}")
  set(sources "${code}__often.cpp" "${code}__seldom.cpp")
  set(together 0)
  if(seldom STREQUAL selfproj_model_options)
    set(sources "${code}__often.cpp")
    set(together 1)
  endif()
  add_custom_command(OUTPUT ${sources} "${code}.h"
    COMMAND "${CMAKE_COMMAND}" "-DVERILATOR=${SELFPROJ_VERILATOR}" "-DFOLDER=${folder}" -DPREFIX=${arg_PREFIX}
            -DRISE=${arg_CLOCKS} -DTOGETHER=${together} -P "${PROJECT_SOURCE_DIR}/cmake/verilate.cmake" --
            ${options} ${arg_PARAMETERS} ${SELFPROJ_RTL}
    DEPENDS "${PROJECT_SOURCE_DIR}/cmake/verilate.cmake" "${SELFPROJ_VERILATOR}" ${arg_OPEN} ${SELFPROJ_RTL}
    COMMENT "Verilating ${arg_PREFIX}" VERBATIM)
  target_sources(${target} PRIVATE ${sources} "${code}.h")
  set_source_files_properties("${code}__often.cpp" PROPERTIES COMPILE_OPTIONS "${selfproj_model_options}")
  if(NOT together)
    set_source_files_properties("${code}__seldom.cpp" PROPERTIES COMPILE_OPTIONS ${seldom})
    if(CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 13)
      set_source_files_properties("${code}__seldom.cpp" PROPERTIES SKIP_PRECOMPILE_HEADERS ON)  # cmake/Headers.cmake
    endif()
  endif()
  # A model with waveforms or coverage keeps records in eval().
  if(SELFPROJ_FAST_RISE AND NOT SELFPROJ_COVERAGE AND NOT arg_TRACE)
    set_source_files_properties("${code}__often.cpp" PROPERTIES COMPILE_DEFINITIONS SELFPROJ_FAST_RISE)
  endif()
  # System headers, about which the compiler does not warn
  target_include_directories(${target} SYSTEM PUBLIC "${folder}")
  target_link_libraries(${target} PUBLIC
    $<IF:$<BOOL:${arg_OPEN}>,selfproj_verilator_interfaces,selfproj_verilator_runtime>)
  get_target_property(precompiled ${target} PRECOMPILE_HEADERS_REUSE_FROM)
  if(NOT SELFPROJ_COVERAGE AND NOT precompiled)
    selfproj_use_precompiled(selfproj_verilator_headers ${target})
  endif()
endfunction()
