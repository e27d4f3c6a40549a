# Headers and package files for find_package(nfopidn). Each component has the targets of its own, so
# that `core` needs no other package.
install(DIRECTORY cpp/include/nfopidn DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT nfopidn
        FILES_MATCHING PATTERN "*.hpp")
set(nfopidn_package ${CMAKE_INSTALL_LIBDIR}/cmake/nfopidn)
set(nfopidn_targets_core nfopidn_core)
set(nfopidn_targets_host nfopidn_host nfopidn_header_only)
set(nfopidn_targets_batch nfopidn_batch)
set(nfopidn_targets_json nfopidn_json)
set(nfopidn_components core)
foreach(component host batch json)
  string(TOUPPER ${component} option)
  if(NFOPIDN_${option})
    list(APPEND nfopidn_components ${component})
  endif()
endforeach()
foreach(component IN LISTS nfopidn_components)
  install(TARGETS ${nfopidn_targets_${component}} EXPORT nfopidn_${component}_targets
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT nfopidn)
  install(EXPORT nfopidn_${component}_targets NAMESPACE nfopidn:: FILE nfopidn_${component}.cmake
          DESTINATION ${nfopidn_package} COMPONENT nfopidn)
endforeach()
configure_package_config_file(cmake/nfopidn-config.cmake.in
  ${CMAKE_CURRENT_BINARY_DIR}/nfopidn-config.cmake
  INSTALL_DESTINATION ${nfopidn_package})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/nfopidn-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/nfopidn-config.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/nfopidn-config-version.cmake
        DESTINATION ${nfopidn_package} COMPONENT nfopidn)
