# `cmake --install`: libraries, public headers as they lie in the source tree, the shaders' text, the program, and the package
# files for find_package(raygraph).
include(CMakePackageConfigHelpers)

get_property(libraries GLOBAL PROPERTY RAYGRAPH_LIBRARIES)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/raygraph)

install(TARGETS ${libraries} EXPORT raygraphTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT raygraphTargets NAMESPACE raygraph:: DESTINATION ${package})
if(TARGET raygraph)
    install(TARGETS raygraph RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

install(CODE "set(RAYGRAPH_SOURCE_DIR \"${PROJECT_SOURCE_DIR}\")
    set(RAYGRAPH_INCLUDE_DIR \"${CMAKE_INSTALL_INCLUDEDIR}/raygraph\")")
install(SCRIPT ${PROJECT_SOURCE_DIR}/cmake/InstallHeaders.cmake)

set(RAYGRAPH_INSTALL_SHADER_DIR ${CMAKE_INSTALL_DATADIR}/raygraph/shaders)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/shaders/
    DESTINATION ${RAYGRAPH_INSTALL_SHADER_DIR}
    PATTERN CMakeLists.txt EXCLUDE
    PATTERN README.md EXCLUDE
    PATTERN embedded.h EXCLUDE)

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/raygraphConfig.cmake.in
    ${PROJECT_BINARY_DIR}/raygraphConfig.cmake
    INSTALL_DESTINATION ${package}
    PATH_VARS RAYGRAPH_INSTALL_SHADER_DIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/raygraphConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES
    ${PROJECT_BINARY_DIR}/raygraphConfig.cmake
    ${PROJECT_BINARY_DIR}/raygraphConfigVersion.cmake
    ${PROJECT_SOURCE_DIR}/cmake/Dependencies.cmake
    DESTINATION ${package})
