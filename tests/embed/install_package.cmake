# cmake -D BUILD=<folder> -D KIND=static|shared -D PREFIX=<folder> -P install_package.cmake: the package with libraries of
# that kind alone, and nothing left of an earlier one.
file(REMOVE_RECURSE ${PREFIX})
foreach(component IN ITEMS core ${KIND})
    execute_process(COMMAND_ERROR_IS_FATAL ANY
        COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX} --component raygraph_${component})
endforeach()
