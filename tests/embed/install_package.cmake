# cmake -D BUILD=<folder> -D KINDS=static|shared|static,shared|none -D PREFIX=<folder> -P install_package.cmake: the
# package with libraries of these kinds alone, and nothing left of an earlier one.
file(REMOVE_RECURSE ${PREFIX})
string(REPLACE "," ";" components "core,${KINDS}")
list(REMOVE_ITEM components none)
if(components MATCHES "shared")
    list(APPEND components runtime)
endif()
foreach(component IN LISTS components)
    execute_process(COMMAND_ERROR_IS_FATAL ANY
        COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX} --component raygraph_${component})
endforeach()
