# Targets opencv::core, opencv::imgproc and opencv::calib3d, or those that selfproj_opencv_modules lists.
#
# Debian ships OpenCVConfig.cmake only with the package of all modules (libopencv-dev, several hundred MB with its
# dependencies). Headers and libraries come module by module, so this file looks them up one by one.
find_path(SELFPROJ_OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
mark_as_advanced(SELFPROJ_OPENCV_INCLUDE_DIR)

if(NOT DEFINED selfproj_opencv_modules)
  set(selfproj_opencv_modules core imgproc calib3d)
endif()
foreach(module IN LISTS selfproj_opencv_modules)
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
if(TARGET opencv::calib3d)
  set_property(TARGET opencv::calib3d APPEND PROPERTY INTERFACE_LINK_LIBRARIES opencv::imgproc)
endif()

# selfproj_find_opencv_structured_light(FOUND): the module with which decoding is compared. It comes with
# libopencv-contrib-dev, several hundred MB, and is optional: FOUND is true if it is installed, as target
# opencv::structured_light.
function(selfproj_find_opencv_structured_light found)
  find_path(SELFPROJ_OPENCV_STRUCTURED_LIGHT_INCLUDE_DIR opencv2/structured_light/graycodepattern.hpp
    PATH_SUFFIXES opencv4)
  find_library(SELFPROJ_OPENCV_structured_light opencv_structured_light)
  mark_as_advanced(SELFPROJ_OPENCV_STRUCTURED_LIGHT_INCLUDE_DIR SELFPROJ_OPENCV_structured_light)
  if(NOT SELFPROJ_OPENCV_STRUCTURED_LIGHT_INCLUDE_DIR OR NOT SELFPROJ_OPENCV_structured_light)
    set(${found} FALSE PARENT_SCOPE)
    return()
  endif()
  if(NOT TARGET opencv::structured_light)
    add_library(opencv::structured_light UNKNOWN IMPORTED)
    set_target_properties(opencv::structured_light PROPERTIES
      IMPORTED_LOCATION "${SELFPROJ_OPENCV_structured_light}"
      INTERFACE_INCLUDE_DIRECTORIES "${SELFPROJ_OPENCV_STRUCTURED_LIGHT_INCLUDE_DIR}"
      INTERFACE_LINK_LIBRARIES opencv::imgproc)
  endif()
  set(${found} TRUE PARENT_SCOPE)
endfunction()
