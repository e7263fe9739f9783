# What the libraries stand on, all of it from the distribution's packages (see `./dev`). Used twice: while the project
# is built, and by raygraphConfig.cmake.
include(CMakeFindDependencyMacro)

# What the public headers in C++ include; a project in C alone has no need of it. Inside find_package(raygraph) a missing
# package is the caller's to report, so find_dependency passes it on.
get_property(_raygraph_languages GLOBAL PROPERTY ENABLED_LANGUAGES)
macro(_raygraph_needs)
    if("${CMAKE_FIND_PACKAGE_NAME}" STREQUAL "raygraph")
        if("CXX" IN_LIST _raygraph_languages OR _raygraph_kind STREQUAL "Static")
            find_dependency(${ARGN})
        endif()
    else()
        find_package(${ARGN} REQUIRED)
    endif()
endmacro()

# What the libraries are linked with. With the static ones a program is linked with it too, but one that uses
# raygraph::scene alone has no need of a shader compiler: inside find_package(raygraph) a missing package is no fault,
# and CMake names it when something is linked that stands on it. The shared library brings its own.
macro(_raygraph_links)
    if("${CMAKE_FIND_PACKAGE_NAME}" STREQUAL "raygraph")
        if(_raygraph_kind STREQUAL "Static")
            find_package(${ARGN} QUIET)
        endif()
    else()
        find_package(${ARGN} REQUIRED)
    endif()
endmacro()

_raygraph_needs(glm)
_raygraph_needs(VulkanHeaders CONFIG)

_raygraph_links(Threads)
_raygraph_links(fmt)
_raygraph_links(nlohmann_json)
_raygraph_links(meshoptimizer)
_raygraph_links(draco CONFIG)
_raygraph_links(PNG)
_raygraph_links(JPEG)
_raygraph_links(OpenEXR)
_raygraph_links(spirv_cross_core)
_raygraph_links(glslang)
# Optional; where the libraries were built with it they are linked with it.
if(NOT "${CMAKE_FIND_PACKAGE_NAME}" STREQUAL "raygraph" OR _raygraph_kind STREQUAL "Static")
    find_package(SPIRV-Tools-opt CONFIG QUIET)
endif()
_raygraph_links(PkgConfig)
if("${CMAKE_FIND_PACKAGE_NAME}" STREQUAL "raygraph")
    if(PkgConfig_FOUND)
        pkg_check_modules(WEBP QUIET IMPORTED_TARGET libwebp)
        pkg_check_modules(ZSTD QUIET IMPORTED_TARGET libzstd)
    endif()
else()
    pkg_check_modules(WEBP REQUIRED QUIET IMPORTED_TARGET libwebp)
    pkg_check_modules(ZSTD REQUIRED QUIET IMPORTED_TARGET libzstd)
endif()
