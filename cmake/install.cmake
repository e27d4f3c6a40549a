# Headers and package files for find_package(nfopidn).
install(DIRECTORY cpp/include/nfopidn DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT nfopidn
        FILES_MATCHING PATTERN "*.hpp")
install(TARGETS ${nfopidn_exported} EXPORT nfopidn_targets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT nfopidn)
install(EXPORT nfopidn_targets NAMESPACE nfopidn:: FILE nfopidn_targets.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/nfopidn COMPONENT nfopidn)
configure_package_config_file(cmake/nfopidn-config.cmake.in
  ${CMAKE_CURRENT_BINARY_DIR}/nfopidn-config.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/nfopidn)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/nfopidn-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/nfopidn-config.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/nfopidn-config-version.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/nfopidn COMPONENT nfopidn)
