# `cmake --install`: libraries, public headers as they lie in the source tree, the shaders' text, the program, and the package
# files for find_package(raygraph) and pkg-config. As components: raygraph_core (what hosts need of both kinds of library),
# raygraph_static, raygraph_shared and the raygraph_runtime that it links to, raygraph_program, raygraph_mpi, and
# raygraph_python.
include(CMakePackageConfigHelpers)

get_property(libraries GLOBAL PROPERTY RAYGRAPH_LIBRARIES)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/raygraph)

if(RAYGRAPH_PACKAGE_STATIC)
    # All layers under one name, as the shared library is one.
    add_library(raygraph_all INTERFACE)
    set_target_properties(raygraph_all PROPERTIES EXPORT_NAME raygraph)
    target_link_libraries(raygraph_all INTERFACE ${libraries})
    install(TARGETS ${libraries} raygraph_all EXPORT raygraphStaticTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT raygraph_static)
    install(EXPORT raygraphStaticTargets NAMESPACE raygraph:: DESTINATION ${package} COMPONENT raygraph_static)
endif()
if(RAYGRAPH_PACKAGE_SHARED)
    include(SharedLibrary)
endif()
include(PkgConfig)
if(TARGET raygraph_mpi)
    install(TARGETS raygraph_mpi RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT raygraph_mpi)
endif()
if(TARGET raygraph)
    # Its manual page and completion: editor/cli/CMakeLists.txt
    install(TARGETS raygraph RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT raygraph_program)
    install(FILES ${PROJECT_SOURCE_DIR}/scenes/cornell.gltf
        DESTINATION ${CMAKE_INSTALL_DATADIR}/raygraph/scenes COMPONENT raygraph_program)
endif()
if(TARGET raygraph AND RAYGRAPH_BUILD_EDITOR)
    # A desktop offers the editor in its menu and for scene files, whose MIME types shared-mime-info has.
    set(desktop ${PROJECT_SOURCE_DIR}/packaging)
    install(FILES ${desktop}/raygraph.desktop
        DESTINATION ${CMAKE_INSTALL_DATADIR}/applications COMPONENT raygraph_program)
    install(FILES ${desktop}/localhost.raygraph.raygraph.metainfo.xml
        DESTINATION ${CMAKE_INSTALL_DATADIR}/metainfo COMPONENT raygraph_program)
    install(FILES ${desktop}/raygraph.svg
        DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps COMPONENT raygraph_program)
endif()

install(CODE "set(RAYGRAPH_SOURCE_DIR \"${PROJECT_SOURCE_DIR}\")
    set(RAYGRAPH_INCLUDE_DIR \"${CMAKE_INSTALL_INCLUDEDIR}/raygraph\")" COMPONENT raygraph_core)
install(SCRIPT ${PROJECT_SOURCE_DIR}/cmake/InstallHeaders.cmake COMPONENT raygraph_core)

set(RAYGRAPH_INSTALL_SHADER_DIR ${CMAKE_INSTALL_DATADIR}/raygraph/shaders)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/shaders/
    DESTINATION ${RAYGRAPH_INSTALL_SHADER_DIR} COMPONENT raygraph_core
    PATTERN CMakeLists.txt EXCLUDE
    PATTERN README.md EXCLUDE
    PATTERN embedded.h EXCLUDE
    PATTERN embedded.cpp EXCLUDE)

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/raygraphConfig.cmake.in
    ${PROJECT_BINARY_DIR}/raygraphConfig.cmake
    INSTALL_DESTINATION ${package}
    PATH_VARS RAYGRAPH_INSTALL_SHADER_DIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/raygraphConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES
    ${PROJECT_BINARY_DIR}/raygraphConfig.cmake
    ${PROJECT_BINARY_DIR}/raygraphConfigVersion.cmake
    ${PROJECT_SOURCE_DIR}/cmake/Dependencies.cmake
    DESTINATION ${package} COMPONENT raygraph_core)
