# Target opencv::imgcodecs: the image codecs, and the hundred libraries that they need, are loaded when an image is
# first read or written.
find_library(SELFPROJ_OPENCV_imgcodecs opencv_imgcodecs REQUIRED)
mark_as_advanced(SELFPROJ_OPENCV_imgcodecs)
execute_process(COMMAND "${CMAKE_OBJDUMP}" -p "${SELFPROJ_OPENCV_imgcodecs}" OUTPUT_VARIABLE header
  COMMAND_ERROR_IS_FATAL ANY)
if(NOT header MATCHES "SONAME +([^ \n]+)")
  message(FATAL_ERROR "${SELFPROJ_OPENCV_imgcodecs}: not a shared library")
endif()
set_property(GLOBAL PROPERTY SELFPROJ_IMAGE_CODECS "${CMAKE_MATCH_1}")  # such as libopencv_imgcodecs.so.406
add_library(selfproj_image_codecs STATIC "${PROJECT_SOURCE_DIR}/host/images/image_codecs.cpp")
target_compile_definitions(selfproj_image_codecs PRIVATE SELFPROJ_IMAGE_CODECS="${CMAKE_MATCH_1}")
target_link_libraries(selfproj_image_codecs PUBLIC opencv::imgproc ${CMAKE_DL_LIBS} PRIVATE selfproj_warnings)
selfproj_for_shared_libraries(selfproj_image_codecs)
add_library(opencv::imgcodecs ALIAS selfproj_image_codecs)
