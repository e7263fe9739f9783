# An overlay port of the tree in which it lies: `vcpkg install raygraph --overlay-ports=packaging/vcpkg`. The programs
# glslangValidator and zstd, which compile and compress the shaders, and pkg-config are the machine's own.
get_filename_component(tree "${CURRENT_PORT_DIR}/../../.." ABSOLUTE)
string(COMPARE EQUAL "${VCPKG_LIBRARY_LINKAGE}" dynamic shared)
vcpkg_cmake_configure(SOURCE_PATH "${tree}"
    OPTIONS
        -DRAYGRAPH_BUILD_TESTS=OFF
        -DRAYGRAPH_BUILD_CLI=OFF
        -DRAYGRAPH_BUILD_EDITOR=OFF
        -DRAYGRAPH_BUILD_MPI=OFF
        -DRAYGRAPH_BUILD_PYTHON=OFF
        -DBUILD_SHARED_LIBS=${shared})
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/raygraph)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
vcpkg_install_copyright(FILE_LIST "${tree}/LICENSE" "${tree}/THIRD_PARTY.md")
