# Run by `cmake --install BUILD --component raygraph_doc`: makes the reference pages of the public headers by Doxygen, where it
# is installed; a warning is an error. Takes RAYGRAPH_SOURCE_DIR, RAYGRAPH_BINARY_DIR, RAYGRAPH_VERSION, and RAYGRAPH_DOC_DIR
# (relative to the prefix).
find_program(doxygen doxygen NO_CACHE)
if(NOT doxygen)
    message(STATUS "No reference pages: there is no doxygen")
    return()
endif()
set(work ${RAYGRAPH_BINARY_DIR}/reference)
file(REMOVE_RECURSE ${work})
file(MAKE_DIRECTORY ${work})
execute_process(COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET
    COMMAND ${CMAKE_COMMAND} -E env --unset=DESTDIR ${CMAKE_COMMAND} -D CMAKE_INSTALL_PREFIX=${work}
        -D RAYGRAPH_INCLUDE_DIR=include -D RAYGRAPH_SOURCE_DIR=${RAYGRAPH_SOURCE_DIR}
        -P ${CMAKE_CURRENT_LIST_DIR}/InstallHeaders.cmake)
file(COPY ${RAYGRAPH_SOURCE_DIR}/c/raygraph.h DESTINATION ${work}/include)
file(COPY ${RAYGRAPH_SOURCE_DIR}/README.md ${RAYGRAPH_SOURCE_DIR}/docs DESTINATION ${work})
# Doxygen reads comments that begin with three slashes; the first of a file is the file's own. A # before a word would be a link.
file(WRITE ${work}/header.sed [[
1s|^// |/// @file\n/// |
s|^( *)// ?|\1/// |
s|([;,{}]) +// |\1  ///< |
/\/\/\//s|#([a-z])|\\#\1|g
]])
# Doxygen knows headings by other names than links within a page have.
file(WRITE ${work}/page.sed [=[s|\[([^]]*)\]\(#[^)]*\)|\1|g]=])
file(READ ${RAYGRAPH_SOURCE_DIR}/docs/Doxyfile settings)
file(WRITE ${work}/Doxyfile "${settings}
PROJECT_NUMBER = ${RAYGRAPH_VERSION}
FILTER_PATTERNS = \"*.h=sed -E -f header.sed\" \"*.md=sed -E -f page.sed\"
")
execute_process(COMMAND ${doxygen} WORKING_DIRECTORY ${work} COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
file(INSTALL DESTINATION ${CMAKE_INSTALL_PREFIX}/${RAYGRAPH_DOC_DIR} TYPE DIRECTORY FILES ${work}/html)
