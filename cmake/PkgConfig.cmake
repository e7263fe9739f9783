# raygraph.pc for the shared library, raygraph-static.pc for the static ones with all that they stand on:
# `pkg-config --cflags --libs NAME`. Each has its own name, so that both may lie in one prefix.

# Which pkg-config package an imported target is.
set(packageOfTarget
    PNG::PNG libpng JPEG::JPEG libjpeg OpenEXR::OpenEXR OpenEXR PkgConfig::WEBP libwebp PkgConfig::ZSTD libzstd glm::glm glm
    fmt::fmt fmt Vulkan::Headers vulkan)

# The linker's name of an imported library, by its file.
function(_raygraph_pc_name target result)
    get_target_property(configurations ${target} IMPORTED_CONFIGURATIONS)
    foreach(suffix IN ITEMS "" LISTS configurations)
        string(REGEX REPLACE "(.+)" "_\\1" suffix "${suffix}")
        get_target_property(file ${target} IMPORTED_LOCATION${suffix})
        if(file)
            break()
        endif()
    endforeach()
    cmake_path(GET file STEM name)
    string(REGEX REPLACE "^lib" "" name ${name})
    set(${result} ${name} PARENT_SCOPE)
endfunction()

# Appends to PKG_REQUIRES the packages, and to PKG_LIBS the linker's names (dependents first), behind the link items.
function(_raygraph_pc_collect)
    foreach(item IN LISTS ARGN)
        string(REGEX REPLACE "^\\$<LINK_ONLY:(.*)>$" "\\1" item "${item}")
        list(FIND packageOfTarget "${item}" found)
        if(NOT found EQUAL -1)
            math(EXPR found "${found} + 1")
            list(GET packageOfTarget ${found} found)
            list(APPEND PKG_REQUIRES ${found})
        elseif(item STREQUAL "Threads::Threads")
            list(APPEND PKG_LIBS -pthread)
        elseif(NOT TARGET ${item})
            list(APPEND PKG_LIBS -l${item})
        else()
            get_target_property(type ${item} TYPE)
            if(NOT type STREQUAL "INTERFACE_LIBRARY")
                _raygraph_pc_name(${item} name)
                list(APPEND PKG_LIBS -l${name})
            endif()
            get_target_property(links ${item} INTERFACE_LINK_LIBRARIES)
            if(links)
                _raygraph_pc_collect(${links})
            endif()
        endif()
    endforeach()
    set(PKG_REQUIRES ${PKG_REQUIRES} PARENT_SCOPE)
    set(PKG_LIBS ${PKG_LIBS} PARENT_SCOPE)
endfunction()

# _raygraph_pc(NAME KIND LIBS REQUIRES): the file for a kind of library. It finds its prefix from where it lies. What only
# the headers of glm and Vulkan are needed for is private: none of their libraries is linked.
function(_raygraph_pc name kind libs requires)
    list(JOIN requires " " requires)
    list(JOIN libs " " libs)
    file(RELATIVE_PATH up /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
    file(GENERATE OUTPUT ${PROJECT_BINARY_DIR}/${kind}/${name}.pc CONTENT
"prefix=\${pcfiledir}/${up}
libdir=\${prefix}/${CMAKE_INSTALL_LIBDIR}
includedir=\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}/raygraph
shaderdir=\${prefix}/${CMAKE_INSTALL_DATADIR}/raygraph/shaders

Name: ${name}
Description: ${PROJECT_DESCRIPTION}
Version: ${PROJECT_VERSION}
Cflags: -I\${includedir} -I\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}
Libs: -L\${libdir} ${libs}
Requires: ${requires}
Requires.private: glm vulkan
")
    install(FILES ${PROJECT_BINARY_DIR}/${kind}/${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
        COMPONENT raygraph_${kind})
endfunction()

if(RAYGRAPH_PACKAGE_SHARED)
    _raygraph_pc(raygraph shared -lraygraph "")
endif()
if(RAYGRAPH_PACKAGE_STATIC)
    set(PKG_REQUIRES)
    set(PKG_LIBS)
    set(archives)
    foreach(library IN LISTS libraries)
        get_target_property(type ${library} TYPE)
        if(type STREQUAL "STATIC_LIBRARY")
            _raygraph_outer_links(${library} links)
            _raygraph_pc_collect(${links})
            string(APPEND archives " -l$<TARGET_LINKER_FILE_BASE_NAME:${library}>")
        endif()
    endforeach()
    list(REMOVE_DUPLICATES PKG_REQUIRES)
    list(REMOVE_ITEM PKG_REQUIRES glm vulkan)
    # The last mention of a library comes after all that need it.
    list(REVERSE PKG_LIBS)
    list(REMOVE_DUPLICATES PKG_LIBS)
    list(REVERSE PKG_LIBS)
    # By its whole name: -lraygraph is the shared library, where that is installed too.
    _raygraph_pc(raygraph-static static "-l:libraygraph.a;${PKG_LIBS}" "${PKG_REQUIRES}")
    # One name for the archives of all layers, whatever their order: a script for the linker.
    file(GENERATE OUTPUT ${PROJECT_BINARY_DIR}/static/libraygraph.a CONTENT "GROUP(${archives} )\n")
    install(FILES ${PROJECT_BINARY_DIR}/static/libraygraph.a DESTINATION ${CMAKE_INSTALL_LIBDIR}
        COMPONENT raygraph_static)
endif()
