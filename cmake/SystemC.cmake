# Target systemc::systemc: SystemC 2.3.4 or 3.0.
#
# Debian's packages have no CMake files, so header and library are looked up here. They were built as C++17, and the
# library refuses to link with code of another standard unless that code says so (SC_CPLUSPLUS); ours is C++20.
find_path(SELFPROJ_SYSTEMC_INCLUDE_DIR systemc REQUIRED)
find_library(SELFPROJ_SYSTEMC_LIBRARY systemc REQUIRED)
mark_as_advanced(SELFPROJ_SYSTEMC_INCLUDE_DIR SELFPROJ_SYSTEMC_LIBRARY)

if(NOT TARGET systemc::systemc)
  add_library(systemc::systemc UNKNOWN IMPORTED)
  set_target_properties(systemc::systemc PROPERTIES
    IMPORTED_LOCATION "${SELFPROJ_SYSTEMC_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${SELFPROJ_SYSTEMC_INCLUDE_DIR}"
    INTERFACE_COMPILE_DEFINITIONS "SC_CPLUSPLUS=201703L"
    # g++ 14 warns, inside SystemC 3, about integers that keep their digits in themselves.
    INTERFACE_COMPILE_OPTIONS $<$<CXX_COMPILER_ID:GNU>:-Wno-free-nonheap-object>)
endif()
