# Debian packages: `cpack --config <build folder>/CPackConfig.cmake` makes one for each component that is built, or for
# several that go together. `cmake --workflow --preset package` configures, builds and packs.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME raygraph)
set(CPACK_PACKAGE_CONTACT "Raygraph developers <raygraph@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # else CPack puts it before each package's own
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_THREADS 0)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR})  # libraygraph.so of the build
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_COMPONENTS_ALL)

set(version "${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}")
set(runtime libraygraph${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
# The loader opens the driver, so that no linked library names either.
set(vulkan "mesa-vulkan-drivers (>= 25.0) | nvidia-vulkan-icd")

set(papers ${PROJECT_BINARY_DIR}/packaging)
configure_file(${PROJECT_SOURCE_DIR}/packaging/changelog.in ${papers}/changelog @ONLY)
file(READ LICENSE license)
file(READ THIRD_PARTY.md others)
file(CONFIGURE OUTPUT ${papers}/copyright CONTENT "@license@\n\n@others@" @ONLY)
execute_process(COMMAND gzip -9nc ${papers}/changelog OUTPUT_FILE ${papers}/changelog.Debian.gz COMMAND_ERROR_IS_FATAL ANY)

# _raygraph_deb(PACKAGE [BINARY] SECTION <section> [DEPENDS <packages>] [RECOMMENDS <packages>] [SUGGESTS <packages>]
#               COMPONENTS <components>... DESCRIPTION <line> <text>)
# BINARY: what the package's programs and libraries are linked with is found, for which CPack looks at each of its files.
function(_raygraph_deb package)
    cmake_parse_arguments(PARSE_ARGV 1 arg "BINARY" "SECTION;DEPENDS;RECOMMENDS;SUGGESTS" "COMPONENTS;DESCRIPTION")
    list(GET arg_COMPONENTS 0 first)
    install(FILES ${papers}/copyright ${papers}/changelog.Debian.gz
        DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${first} EXCLUDE_FROM_ALL)
    list(APPEND CPACK_COMPONENTS_ALL ${arg_COMPONENTS})
    set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} PARENT_SCOPE)
    # CPack knows a package by its group of components.
    string(TOUPPER ${first} group)
    foreach(component IN LISTS arg_COMPONENTS)
        string(TOUPPER ${component} component)
        set(CPACK_COMPONENT_${component}_GROUP ${first} PARENT_SCOPE)
    endforeach()
    list(JOIN arg_DESCRIPTION "\n" arg_DESCRIPTION)
    set(CPACK_COMPONENT_${group}_DESCRIPTION "${arg_DESCRIPTION}" PARENT_SCOPE)
    set(CPACK_DEBIAN_${group}_PACKAGE_NAME ${package} PARENT_SCOPE)
    if(arg_BINARY)
        set(CPACK_DEBIAN_${group}_PACKAGE_SHLIBDEPS ON PARENT_SCOPE)
    endif()
    foreach(field IN ITEMS SECTION DEPENDS RECOMMENDS SUGGESTS)
        set(CPACK_DEBIAN_${group}_PACKAGE_${field} "${arg_${field}}" PARENT_SCOPE)
    endforeach()
endfunction()

if(RAYGRAPH_PACKAGE_SHARED)
    _raygraph_deb(${runtime} BINARY SECTION libs COMPONENTS raygraph_runtime
        DEPENDS "libvulkan1" RECOMMENDS "${vulkan}"
        DESCRIPTION "render-graph engine module with a glTF path tracer (library)"
            "Raygraph renders glTF scenes by path tracing on any Vulkan device with ray
tracing. Engines embed it to see ground truth beside their raster view.
.
This package has the shared library.")
    # By these, packages that are linked with the library depend on it, and the loader's cache is brought up to date.
    file(WRITE ${papers}/shlibs "libraygraph ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} ${runtime}\n")
    file(WRITE ${papers}/triggers "activate-noawait ldconfig\n")
    set(CPACK_DEBIAN_RAYGRAPH_RUNTIME_PACKAGE_CONTROL_EXTRA "${papers}/shlibs;${papers}/triggers")
    _raygraph_deb(libraygraph-dev SECTION libdevel COMPONENTS raygraph_core raygraph_shared
        DEPENDS "${runtime} (= ${version}), libglm-dev, libvulkan-dev" SUGGESTS "raygraph-doc"
        DESCRIPTION "render-graph engine module with a glTF path tracer (headers)"
            "Raygraph renders glTF scenes by path tracing on any Vulkan device with ray
tracing. Engines embed it to see ground truth beside their raster view.
.
This package has the C++ headers, the shaders' sources, and the files by which
CMake's find_package and pkg-config find the library.")
endif()
if(TARGET raygraph)
    _raygraph_deb(raygraph BINARY SECTION graphics COMPONENTS raygraph_program
        DEPENDS "libvulkan1" RECOMMENDS "${vulkan}, shared-mime-info" SUGGESTS "raygraph-doc, zenity"
        DESCRIPTION "path tracer and editor for glTF scenes"
            "Raygraph renders glTF scenes by path tracing on any Vulkan device with ray
tracing, from the command line or in the window of an editor. Samples are
unbiased; pictures are denoised, compared, explained, resumed and merged.")
endif()
if(TARGET raygraph_mpi)
    _raygraph_deb(raygraph-mpi BINARY SECTION graphics COMPONENTS raygraph_mpi
        DEPENDS "libvulkan1, openmpi-bin" RECOMMENDS "${vulkan}" SUGGESTS "raygraph"
        DESCRIPTION "path tracer for glTF scenes on many nodes"
            "raygraph-mpi renders one picture by the ranks of an MPI job. The file is, bit
for bit, that of the program raygraph.")
endif()
if(TARGET raygraph_python)
    string(REGEX MATCH "^([0-9]+)\\.([0-9]+)$" _ ${RAYGRAPH_PYTHON_VERSION})
    math(EXPR next "${CMAKE_MATCH_2} + 1")
    _raygraph_deb(python3-raygraph BINARY SECTION python COMPONENTS raygraph_python
        DEPENDS "${runtime} (= ${version}), python3 (>= ${RAYGRAPH_PYTHON_VERSION}), python3 (<< ${CMAKE_MATCH_1}.${next}), python3-numpy"
        SUGGESTS "raygraph-doc"
        DESCRIPTION "path tracer for glTF scenes (Python package)"
            "Raygraph renders glTF scenes by path tracing on any Vulkan device with ray
tracing. From Python it renders scenes of files and of arrays into arrays, and
runs passes from GLSL text.")
    set(scripts ${PROJECT_SOURCE_DIR}/packaging/python3)
    set(CPACK_DEBIAN_RAYGRAPH_PYTHON_PACKAGE_CONTROL_EXTRA "${scripts}/postinst;${scripts}/prerm")
endif()

set(folder ${CMAKE_INSTALL_DATADIR}/doc/raygraph)
install(FILES README.md DESTINATION ${folder} COMPONENT raygraph_doc EXCLUDE_FROM_ALL)
install(DIRECTORY docs examples DESTINATION ${folder} COMPONENT raygraph_doc EXCLUDE_FROM_ALL PATTERN Doxyfile EXCLUDE)
install(CODE "set(RAYGRAPH_SOURCE_DIR \"${PROJECT_SOURCE_DIR}\")
    set(RAYGRAPH_BINARY_DIR \"${PROJECT_BINARY_DIR}\")
    set(RAYGRAPH_VERSION \"${PROJECT_VERSION}\")
    set(RAYGRAPH_DOC_DIR \"${folder}\")" COMPONENT raygraph_doc EXCLUDE_FROM_ALL)
install(SCRIPT cmake/InstallReference.cmake COMPONENT raygraph_doc EXCLUDE_FROM_ALL)
_raygraph_deb(raygraph-doc SECTION doc COMPONENTS raygraph_doc
    DESCRIPTION "path tracer and engine module for glTF scenes (documentation)"
        "Pages on rendering, embedding and writing passes with Raygraph, and example
programs.")
set(CPACK_DEBIAN_RAYGRAPH_DOC_PACKAGE_ARCHITECTURE all)

include(CPack)
