# What `cmake --install` lays down: the two programs, one library per folder with its public headers under
# include/servobus/<folder>, and a CMake package, so that find_package(servobus) gives servobus::scanner and the others.
include(CMakePackageConfigHelpers)

set_target_properties(servobus_options PROPERTIES EXPORT_NAME options)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/servobus)

install(TARGETS
    servobus_options
    servobus_drive servobus_cip servobus_assemblies servobus_eds servobus_enip servobus_enip_asio servobus_adapter servobus_scanner
    EXPORT servobusTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS servobus_adapter_main servobus_scanner_main RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY drive cip assemblies eds enip adapter scanner DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/servobus
    FILES_MATCHING PATTERN "*.hpp" PATTERN examples EXCLUDE PATTERN cli EXCLUDE PATTERN conformance EXCLUDE PATTERN axes EXCLUDE
    PATTERN adapter/axis_file.hpp EXCLUDE PATTERN adapter/config.hpp EXCLUDE PATTERN adapter/file_settings.hpp EXCLUDE PATTERN adapter/control.hpp EXCLUDE
    PATTERN adapter/access_file.hpp EXCLUDE PATTERN adapter/flash_file.hpp EXCLUDE
    PATTERN adapter/terminal_sink.hpp EXCLUDE PATTERN adapter/event_json.hpp EXCLUDE PATTERN adapter/json_document.hpp EXCLUDE
    PATTERN adapter/json_settings.hpp EXCLUDE PATTERN adapter/network_json.hpp EXCLUDE PATTERN adapter/scenario.hpp EXCLUDE
    PATTERN adapter/shipped_axis_files.hpp EXCLUDE PATTERN adapter/start_address.hpp EXCLUDE PATTERN adapter/text_file.hpp EXCLUDE)
install(DIRECTORY drive/axes DESTINATION ${CMAKE_INSTALL_DATADIR}/servobus FILES_MATCHING PATTERN "*.json")
install(FILES LICENSE CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})

install(EXPORT servobusTargets NAMESPACE servobus:: DESTINATION ${package_dir})
configure_package_config_file(cmake/servobus-config.cmake.in servobus-config.cmake INSTALL_DESTINATION ${package_dir})
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(servobus-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES
    ${CMAKE_CURRENT_BINARY_DIR}/servobus-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/servobus-config-version.cmake
    DESTINATION ${package_dir})
