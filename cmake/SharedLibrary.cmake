# libraygraph.so: the objects of all layers in one library, so that nothing but RAYGRAPH_API is exported. In the package
# it stands behind the same targets as the static libraries, raygraph::rhi and so on.

get_property(libraries GLOBAL PROPERTY RAYGRAPH_LIBRARIES)
add_library(raygraph_shared SHARED)
_raygraph_flags(raygraph_shared)
set_target_properties(raygraph_shared PROPERTIES
    OUTPUT_NAME raygraph
    EXPORT_NAME raygraph
    LINKER_LANGUAGE CXX
    VERSION ${PROJECT_VERSION}
    # Before 1.0 a minor version may change what is there.
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
target_compile_features(raygraph_shared INTERFACE cxx_std_20)
target_include_directories(raygraph_shared INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/raygraph>)
# What the archives hold that we are linked with is hidden too; every symbol is found, but for a sanitizer's own.
target_link_options(raygraph_shared PRIVATE LINKER:--exclude-libs,ALL)
if(NOT RAYGRAPH_SANITIZE)
    target_link_options(raygraph_shared PRIVATE LINKER:--no-undefined)
endif()
# A project in C does not look for these.
target_link_libraries(raygraph_shared INTERFACE $<TARGET_NAME_IF_EXISTS:glm::glm> $<TARGET_NAME_IF_EXISTS:Vulkan::Headers>)

set(sharedTargets raygraph_shared)
foreach(library IN LISTS libraries)
    get_target_property(type ${library} TYPE)
    if(type STREQUAL "STATIC_LIBRARY")
        target_sources(raygraph_shared PRIVATE $<TARGET_OBJECTS:${library}>)
        _raygraph_outer_links(${library} links)
        target_link_libraries(raygraph_shared PRIVATE ${links})
    endif()
    get_target_property(name ${library} EXPORT_NAME)
    add_library(raygraph_shared_${name} INTERFACE)
    set_target_properties(raygraph_shared_${name} PROPERTIES EXPORT_NAME ${name})
    if(name STREQUAL "c")  # for hosts without a C++ compiler: nothing of C++ but the library itself
        target_link_libraries(raygraph_shared_c INTERFACE $<LINK_ONLY:raygraph_shared>)
        target_include_directories(raygraph_shared_c INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
    else()
        target_link_libraries(raygraph_shared_${name} INTERFACE raygraph_shared)
    endif()
    list(APPEND sharedTargets raygraph_shared_${name})
endforeach()

install(TARGETS ${sharedTargets} EXPORT raygraphSharedTargets
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT raygraph_runtime NAMELINK_COMPONENT raygraph_shared)
install(EXPORT raygraphSharedTargets NAMESPACE raygraph:: DESTINATION ${package} COMPONENT raygraph_shared)
