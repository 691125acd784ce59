# Targets opencv::core, opencv::imgproc and opencv::imgcodecs.
#
# Debian packs OpenCVConfig.cmake only with the package of all modules (libopencv-dev, several hundred MB with what it
# needs); headers and libraries come module by module, so they are looked up here one by one.
find_path(SELFPROJ_OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
mark_as_advanced(SELFPROJ_OPENCV_INCLUDE_DIR)

foreach(module core imgproc imgcodecs)
  if(TARGET opencv::${module})
    continue()
  endif()
  find_library(SELFPROJ_OPENCV_${module} opencv_${module} REQUIRED)
  mark_as_advanced(SELFPROJ_OPENCV_${module})
  add_library(opencv::${module} UNKNOWN IMPORTED)
  set_target_properties(opencv::${module} PROPERTIES
    IMPORTED_LOCATION "${SELFPROJ_OPENCV_${module}}"
    INTERFACE_INCLUDE_DIRECTORIES "${SELFPROJ_OPENCV_INCLUDE_DIR}")
endforeach()
set_property(TARGET opencv::imgproc APPEND PROPERTY INTERFACE_LINK_LIBRARIES opencv::core)
set_property(TARGET opencv::imgcodecs APPEND PROPERTY INTERFACE_LINK_LIBRARIES opencv::imgproc)
