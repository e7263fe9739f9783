# Every target of the project gets the same language level, warnings and sanitizers from here.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)

function(_raygraph_flags target)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ${RAYGRAPH_UNITY} UNITY_BUILD_BATCH_SIZE 10)
    target_compile_options(${target} PRIVATE
        -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor -Woverloaded-virtual -Werror
        -Wno-missing-field-initializers  # a Desc names the fields that differ from their defaults
        # No fused multiply-add on the CPU: shading text compiled twice must round alike on every host.
        -ffp-contract=off)
    if(RAYGRAPH_ASSERTS)
        target_compile_definitions(${target} PRIVATE RAYGRAPH_ASSERTS=1)
    endif()
    if(RAYGRAPH_SANITIZE)
        target_compile_options(${target} PRIVATE -fsanitize=${RAYGRAPH_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
        target_link_options(${target} PUBLIC -fsanitize=${RAYGRAPH_SANITIZE})
    endif()
endfunction()

# raygraph_library(NAME [STATIC|INTERFACE] SOURCES...): target raygraph_NAME with the alias raygraph::NAME. Headers are
# included from the root of the source tree ("rhi/device.h"), or from include/raygraph once installed.
function(raygraph_library name)
    set(target raygraph_${name})
    add_library(${target} ${ARGN})
    add_library(raygraph::${name} ALIAS ${target})
    get_target_property(type ${target} TYPE)
    if(type STREQUAL "INTERFACE_LIBRARY")
        set(scope INTERFACE)
    else()
        set(scope PUBLIC)
        _raygraph_flags(${target})
        target_link_libraries(${target} PRIVATE fmt::fmt)  # base/text.h
        # What RAYGRAPH_API does not mark stays inside: base/api.h.
        set_target_properties(${target} PROPERTIES CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
    endif()
    set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
    target_include_directories(${target} ${scope}
        $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
        $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/raygraph>)
    target_compile_features(${target} ${scope} cxx_std_20)
    set_property(GLOBAL APPEND PROPERTY RAYGRAPH_LIBRARIES ${target})
endfunction()

# What a library is linked with that is not of this tree.
function(_raygraph_outer_links target result)
    get_target_property(links ${target} LINK_LIBRARIES)
    if(NOT links)
        set(links)
    endif()
    list(FILTER links EXCLUDE REGEX "^raygraph::")
    set(${result} ${links} PARENT_SCOPE)
endfunction()

# raygraph_private_library(TARGET SOURCES...): a library for this tree's own programs and tests, not installed.
function(raygraph_private_library target)
    add_library(${target} STATIC ${ARGN})
    target_include_directories(${target} PUBLIC ${PROJECT_SOURCE_DIR})
    target_link_libraries(${target} PRIVATE fmt::fmt)
    _raygraph_flags(${target})
endfunction()

function(raygraph_executable target)
    add_executable(${target} ${ARGN})
    target_link_libraries(${target} PRIVATE fmt::fmt)
    _raygraph_flags(${target})
endfunction()
