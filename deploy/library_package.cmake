# What find_package(haptics) finds after cmake --install --component library: a target for each component.
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/haptics)
foreach(component contact step client device)
  install(EXPORT haptics_${component} NAMESPACE haptics:: DESTINATION ${package_folder} COMPONENT library)
endforeach()
configure_package_config_file(deploy/haptics-config.cmake.in ${CMAKE_BINARY_DIR}/haptics-config.cmake
  INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/haptics-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/haptics-config.cmake ${CMAKE_BINARY_DIR}/haptics-config-version.cmake
  DESTINATION ${package_folder} COMPONENT library)
