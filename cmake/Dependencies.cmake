# What the libraries stand on, all of it from the distribution's packages (see `./dev`). Used twice: while the project
# is built, and by raygraphConfig.cmake, since whoever links static libraries links what they stand on.
include(CMakeFindDependencyMacro)

# Inside find_package(raygraph) a missing package is the caller's to report, so find_dependency passes it on.
macro(_raygraph_needs)
    if("${CMAKE_FIND_PACKAGE_NAME}" STREQUAL "raygraph")
        find_dependency(${ARGN})
    else()
        find_package(${ARGN} REQUIRED)
    endif()
endmacro()

_raygraph_needs(Threads)
_raygraph_needs(glm)
_raygraph_needs(nlohmann_json)
_raygraph_needs(meshoptimizer)
_raygraph_needs(PNG)
_raygraph_needs(JPEG)
_raygraph_needs(OpenEXR)
_raygraph_needs(VulkanHeaders CONFIG)
_raygraph_needs(spirv_cross_core)
_raygraph_needs(glslang)
_raygraph_needs(PkgConfig)
pkg_check_modules(WEBP REQUIRED QUIET IMPORTED_TARGET libwebp)
