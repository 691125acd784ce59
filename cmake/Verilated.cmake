# selfproj_verilate(TARGET TOP module PREFIX name [TRACE] [UNCOUNTED] [SMALL] [OPEN file] [CLOCKS port...]
#                   [PARAMETERS Name=Value...])
#
# Adds the Verilated model of an RTL module to the library TARGET, as class `name` (header `name`.h). Verilator gets all
# of rtl/, the package first, and leaves out what the top does not instantiate. All libraries share one runtime of
# Verilator.
#
# With TRACE the model can write waveforms (FST).
#
# CLOCKS names the ports that are clocks. The model then gets rise() and settle(), which clocks.h (sim/board) declares.
# The code that runs in every clock is compiled as one file, so that the compiler sees all of it (a tenth fewer
# instructions).
#
# OPEN names a configuration file for Verilator. VPI can set the registers that this file makes public. In a model with
# CLOCKS, settle() then updates the logic behind them.
#
# With UNCOUNTED the model counts no coverage, even where SELFPROJ_COVERAGE is set, because other models count the same.
#
# With SMALL the code is compiled as two files even where it counts coverage.

# Set in advance, because Verilator's CMake package would take seconds to determine these options, and needs only
# -pthread.
set(VERILATOR_CFLAGS "")
set(VERILATOR_MT_CFLAGS -pthread)
find_package(verilator REQUIRED HINTS $ENV{VERILATOR_ROOT})
find_package(Threads REQUIRED)
find_package(ZLIB REQUIRED)  # of waveforms

option(SELFPROJ_COVERAGE "Count line and toggle coverage of rtl/ in the Verilated models" OFF)

file(GLOB SELFPROJ_RTL CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/rtl/*/sp_*.sv")
list(REMOVE_ITEM SELFPROJ_RTL "${PROJECT_SOURCE_DIR}/rtl/common/sp_spec_pkg.sv")
list(PREPEND SELFPROJ_RTL "${PROJECT_SOURCE_DIR}/rtl/common/sp_spec_pkg.sv")

# Verilator's runtime, compiled once for all models. selfproj_verilator_interfaces is what DPI and VPI need of it.
if(NOT TARGET selfproj_verilator_runtime)
  set(runtime "${VERILATOR_ROOT}/include")
  add_library(selfproj_verilator_runtime STATIC EXCLUDE_FROM_ALL
    "${runtime}/verilated.cpp" "${runtime}/verilated_fst_c.cpp" "${runtime}/verilated_threads.cpp")
  if(SELFPROJ_COVERAGE)
    target_sources(selfproj_verilator_runtime PRIVATE "${runtime}/verilated_cov.cpp")
  endif()
  add_library(selfproj_verilator_interfaces STATIC EXCLUDE_FROM_ALL
    "${runtime}/verilated_dpi.cpp" "${runtime}/verilated_vpi.cpp")
  target_link_libraries(selfproj_verilator_runtime PUBLIC ${VERILATOR_MT_CFLAGS} Threads::Threads ZLIB::ZLIB)
  target_link_libraries(selfproj_verilator_interfaces PUBLIC selfproj_verilator_runtime)
  foreach(target selfproj_verilator_runtime selfproj_verilator_interfaces)
    target_include_directories(${target} SYSTEM PUBLIC "${runtime}" "${runtime}/vltstd")
    target_compile_options(${target} PRIVATE -w -O2)
  endforeach()
  # Verilator's header is most of the cost of a small file.
  selfproj_precompile(selfproj_verilator_headers HEADERS verilated.h OPTIONS -O3 LIBRARIES selfproj_verilator_runtime)
  foreach(target selfproj_verilator_runtime selfproj_verilator_interfaces selfproj_verilator_headers)
    target_compile_definitions(${target}
      PRIVATE VM_COVERAGE=$<BOOL:${SELFPROJ_COVERAGE}> VM_SC=0 VM_TRACE=1 VM_TRACE_FST=1 VM_TRACE_VCD=0)
  endforeach()
endif()

function(selfproj_verilate target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "TRACE;UNCOUNTED;SMALL" "TOP;PREFIX;OPEN" "CLOCKS;PARAMETERS")
  if(arg_UNPARSED_ARGUMENTS OR NOT arg_TOP OR NOT arg_PREFIX)
    message(FATAL_ERROR "selfproj_verilate(${target}): TOP or PREFIX missing, or unknown: ${arg_UNPARSED_ARGUMENTS}")
  endif()
  set_property(GLOBAL PROPERTY selfproj_model_${arg_PREFIX} ${arg_TOP} ${arg_PARAMETERS})  # for its netlists
  set(options -Wall -O3 --x-assign fast --x-initial fast --assert)
  foreach(parameter IN LISTS arg_PARAMETERS)
    list(APPEND options "-G${parameter}")
  endforeach()
  if(arg_OPEN)
    list(APPEND options --vpi "${arg_OPEN}")
  endif()
  # The model is always built for speed: without optimization it is ten times slower, and there is nothing to step
  # through. Vectorization is off because gathering the scattered bits costs more than it saves. A model that counts
  # coverage is built for one run only, and any optimization of the function that names its thousands of points takes
  # minutes.
  set(optimization "-O3 -fno-tree-vectorize -fno-tree-slp-vectorize")
  set(seldom_optimization -O1)
  set(features "")
  if(arg_TRACE)
    list(APPEND features TRACE_FST)
  endif()
  set(counted FALSE)
  if(SELFPROJ_COVERAGE)
    set(optimization -O1)
    if(NOT arg_UNCOUNTED)
      set(counted TRUE)
      set(seldom_optimization -O0)
      list(APPEND options --coverage-line --coverage-toggle)
      list(APPEND features COVERAGE)
    endif()
  endif()
  verilate(${target} ${features} SOURCES ${SELFPROJ_RTL} TOP_MODULE ${arg_TOP} PREFIX ${arg_PREFIX}
    VERILATOR_ARGS ${options} OPT_FAST ${optimization} OPT_SLOW ${seldom_optimization} OPT_GLOBAL -O2)
  # Verilator writes a dozen files a model, and each reads the same headers. So the code that runs seldom is compiled as
  # one file, and the code that runs often as another. (Not with coverage, which gives a large model too many functions
  # for one file.)
  get_target_property(seldom ${target} SOURCES)
  list(FILTER seldom INCLUDE REGEX "/${arg_PREFIX}[.]dir/[^/]*[.]cpp$")
  set(often ${seldom})
  list(FILTER seldom INCLUDE REGEX "__Syms[.]cpp$|Slow[.]cpp$|__ConstPool_[0-9]+[.]cpp$")
  list(REMOVE_ITEM often ${seldom})
  set(joined FALSE)
  if(arg_SMALL OR NOT counted)
    set(joined TRUE)
    selfproj_join_sources(${target} ${arg_PREFIX}__seldom ${seldom_optimization} ${seldom})
  endif()
  if(arg_CLOCKS)
    selfproj_verilated_clocks(${target} ${arg_PREFIX} ${arg_TRACE} ${counted} "${optimization}" ${arg_CLOCKS})
  elseif(joined)
    selfproj_join_sources(${target} ${arg_PREFIX}__often "${optimization}" ${often})
  endif()
  # The shared runtime takes the place of the one that Verilator's package adds to each library.
  get_target_property(sources ${target} SOURCES)
  if("${sources}" MATCHES "/verilated_[dv]pi[.]cpp")
    target_link_libraries(${target} PUBLIC selfproj_verilator_interfaces)
  endif()
  list(FILTER sources EXCLUDE REGEX "/verilated[a-z_]*[.]cpp$")
  set_target_properties(${target} PROPERTIES SOURCES "${sources}" VERILATOR_TRACE ON VERILATOR_TRACE_FST ON)
  target_link_libraries(${target} PUBLIC selfproj_verilator_runtime)
  get_target_property(precompiled ${target} PRECOMPILE_HEADERS_REUSE_FROM)
  if(NOT SELFPROJ_COVERAGE AND NOT precompiled)
    selfproj_use_precompiled(selfproj_verilator_headers ${target})
  endif()
  # Makes Verilator's headers system headers, about which the compiler does not warn.
  get_target_property(includes ${target} INTERFACE_INCLUDE_DIRECTORIES)
  list(REMOVE_ITEM includes "${PROJECT_SOURCE_DIR}")
  set_property(TARGET ${target} PROPERTY INTERFACE_SYSTEM_INCLUDE_DIRECTORIES ${includes})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${SELFPROJ_RTL})
endfunction()

# selfproj_join_sources(TARGET name flags source...): compiles the sources as one file, `name`.cpp, with these flags.
function(selfproj_join_sources target name flags)
  set(includes "")
  foreach(source IN LISTS ARGN)
    string(APPEND includes "#include \"${source}\"\n")
  endforeach()
  set(file "${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp")
  file(CONFIGURE OUTPUT "${file}" CONTENT "// Written by cmake/Verilated.cmake.\n${includes}" @ONLY)
  set_source_files_properties(${ARGN} PROPERTIES HEADER_FILE_ONLY ON)
  set_source_files_properties("${file}" PROPERTIES COMPILE_FLAGS " ${flags}" OBJECT_DEPENDS "${ARGN}")
  target_sources(${target} PRIVATE "${file}")
endfunction()

# Writes the file PREFIX__clocked.cpp of a model with CLOCKS. Its rise() consists of the parts of eval() as Verilator
# 5.006 writes it. Other versions may name these parts differently, and then the file does not compile. rise() can call
# `model.eval()` instead, which is right but slower.
function(selfproj_verilated_clocks target prefix waveforms counted optimization)
  get_target_property(fast ${target} SOURCES)
  list(FILTER fast INCLUDE REGEX "/${prefix}[.]dir/[^/]*[.]cpp$")
  list(FILTER fast EXCLUDE REGEX "__Syms[.]cpp$|Slow[.]cpp$|__ConstPool_[0-9]+[.]cpp$")
  set(includes "")
  set(before "")
  set(evaluate "  model.eval();\n")
  if(NOT counted)
    set_source_files_properties(${fast} PROPERTIES HEADER_FILE_ONLY ON)
    foreach(source IN LISTS fast)
      string(APPEND includes "#include \"${source}\"\n")
      file(STRINGS "${source}" input_logic REGEX "^void .*___eval_triggers__ico.*[{]$")
      if(input_logic)
        string(APPEND before "  root->__VicoIterCount = 0;\n  ${prefix}___024root___eval_triggers__ico(root);\n")
        string(APPEND before "  ${prefix}___024root___eval_ico(root);\n")
      endif()
    endforeach()
  endif()
  # A model with waveforms or coverage keeps records in eval().
  if(NOT counted AND NOT waveforms)
    set(evaluate "${before}  ${prefix}___024root___eval_triggers__act(root);\n")
    string(APPEND evaluate "  root->__VnbaTriggered = root->__VactTriggered;\n")
    string(APPEND evaluate "  ${prefix}___024root___eval_nba(root);\n")
  endif()
  set(low "")
  foreach(clock IN LISTS ARGN)
    string(APPEND low "  root->__Vtrigrprev__TOP__${clock} = 0;\n")
  endforeach()
  set(file "${CMAKE_CURRENT_BINARY_DIR}/${prefix}__clocked.cpp")
  file(CONFIGURE OUTPUT "${file}" CONTENT "// Written by cmake/Verilated.cmake.
#include \"sim/board/clocks.h\"
#include \"${prefix}.h\"
#include \"${prefix}___024root.h\"
${includes}
void ${prefix}___024root___eval_settle(${prefix}___024root* vlSelf);
namespace selfproj {
template <>
void settle<${prefix}>(${prefix} & model) {
  ${prefix}___024root___eval_settle(model.rootp);
}
template <>
void rise<${prefix}>(${prefix} & model) {
  ${prefix}___024root* root = model.rootp;
${low}${evaluate}}
}  // namespace selfproj
" @ONLY)
  set_source_files_properties("${file}" PROPERTIES COMPILE_FLAGS " ${optimization}" OBJECT_DEPENDS "${fast}")
  target_sources(${target} PRIVATE "${file}")
endfunction()
