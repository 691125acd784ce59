# What `cmake --install` and `cpack` put where: component `programs`, and component `development` with headers,
# libraries and the files by which CMake and pkg-config find them. docs/from-outside.md says what of it is stable.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# The libraries, in two sets, so that model and driver need nothing else.
set(selfproj_core selfproj_warnings selfproj_model selfproj_files selfproj_driver selfproj_c)
set(selfproj_vision selfproj_image_codecs selfproj_io selfproj_rig selfproj_light_section selfproj_structured_light)
foreach(target selfproj_model selfproj_files)
  target_compile_features(${target} INTERFACE cxx_std_20)  # of whoever includes the headers
endforeach()
set(selfproj_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/selfproj)
foreach(set core vision)
  foreach(target IN LISTS selfproj_${set})
    string(REPLACE "selfproj_" "" name ${target})
    set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  endforeach()
  install(TARGETS ${selfproj_${set}} EXPORT selfproj_${set}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
    INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(EXPORT selfproj_${set} NAMESPACE selfproj:: FILE selfproj_${set}.cmake
    DESTINATION ${selfproj_cmake_dir} COMPONENT development)
endforeach()

# For the Python package, which can take its libraries from this build (python/CMakeLists.txt).
set(selfproj_of_python selfproj_calibration selfproj_camera selfproj_report selfproj_parts)
if(TARGET selfproj_aravis)
  list(APPEND selfproj_of_python selfproj_aravis)
endif()
foreach(target IN LISTS selfproj_of_python)
  string(REPLACE "selfproj_" "" name ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
endforeach()
export(TARGETS ${selfproj_core} ${selfproj_vision} ${selfproj_of_python} NAMESPACE selfproj::
  FILE "${PROJECT_BINARY_DIR}/selfproj_libraries.cmake")

install(FILES host/driver/selfproj.lua DESTINATION ${CMAKE_INSTALL_DATADIR}/selfproj COMPONENT programs)
install(FILES capi/dpi/selfproj_dpi_pkg.sv capi/dpi/selfproj_dpi.c DESTINATION ${CMAKE_INSTALL_DATADIR}/selfproj/dpi
  COMPONENT development)
install(DIRECTORY include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)

configure_package_config_file(cmake/install/selfprojConfig.cmake.in "${PROJECT_BINARY_DIR}/selfprojConfig.cmake"
  INSTALL_DESTINATION ${selfproj_cmake_dir} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/selfprojConfigVersion.cmake" COMPATIBILITY SameMajorVersion)
install(FILES "${PROJECT_BINARY_DIR}/selfprojConfig.cmake" "${PROJECT_BINARY_DIR}/selfprojConfigVersion.cmake"
  cmake/OpenCVModules.cmake DESTINATION ${selfproj_cmake_dir} COMPONENT development)
file(RELATIVE_PATH selfproj_back "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")  # from there to the prefix
foreach(name selfproj selfproj-driver)
  configure_file(cmake/install/${name}.pc.in "${PROJECT_BINARY_DIR}/${name}.pc" @ONLY)
  install(FILES "${PROJECT_BINARY_DIR}/${name}.pc" DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
endforeach()

install(TARGETS selfproj selfproj-sim RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT programs)
install(TARGETS selfproj_gentl LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/selfproj COMPONENT programs)

# Packages of Debian: cpack --config build/release/CPackConfig.cmake.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME selfproj)
set(CPACK_PACKAGE_CONTACT "the authors of selfproj")
set(CPACK_PACKAGE_HOMEPAGE_URL "")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_DIRECTORY "${PROJECT_BINARY_DIR}/packages")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL programs development)
set(CPACK_COMPONENT_PROGRAMS_DESCRIPTION "The programs selfproj and selfproj-sim, and the GenTL producer.")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "Headers and libraries of the model, the driver and the measurements.")
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_NAME selfproj)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SHLIBDEPS ON)
get_property(selfproj_codecs GLOBAL PROPERTY SELFPROJ_IMAGE_CODECS)
string(REGEX REPLACE "^libopencv_imgcodecs[.]so[.]" "libopencv-imgcodecs" selfproj_codecs "${selfproj_codecs}")
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_DEPENDS "${selfproj_codecs}, libsdl2-2.0-0")  # are loaded, not linked
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libselfproj-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_RECOMMENDS
  "libopencv-core-dev, libopencv-imgproc-dev, ${selfproj_codecs}, libfmt-dev, libyaml-cpp-dev")
set(CPACK_DEBIAN_COMPRESSION_TYPE gzip)  # a second; xz takes twenty for a tenth less
set(CPACK_STRIP_FILES ON)
include(CPack)
