# The target `documentation`, where Doxygen is installed: pages of the four libraries' declarations, in html/ of the
# build folder. A declaration without a comment is an error; fields alone may go without one, where their struct's
# comment, name and type say it all.
find_package(Doxygen QUIET)
if(NOT DOXYGEN_FOUND)
    return()
endif()

set(DOXYGEN_FILE_PATTERNS *.h)
set(DOXYGEN_EXCLUDE_PATTERNS *-inl.h)
set(DOXYGEN_EXCLUDE_SYMBOLS TOML_*)
set(DOXYGEN_STRIP_FROM_PATH ${PROJECT_SOURCE_DIR})
set(DOXYGEN_STRIP_FROM_INC_PATH ${PROJECT_SOURCE_DIR})
set(DOXYGEN_DISTRIBUTE_GROUP_DOC YES)  # one comment for several declarations between @{ and @}
set(DOXYGEN_HAVE_DOT NO)
set(DOXYGEN_QUIET YES)
# The comment at the top of a header is the file's.
set(DOXYGEN_INPUT_FILTER "sed '1s|^#pragma once$|/// \\\\file|'")
set(DOXYGEN_WARN_LOGFILE ${PROJECT_BINARY_DIR}/documentation.log)
doxygen_add_docs(documentation fields shading scenes bridge)
add_custom_command(TARGET documentation POST_BUILD
    COMMAND ${CMAKE_COMMAND} -DLOG=${DOXYGEN_WARN_LOGFILE} -P ${CMAKE_CURRENT_LIST_DIR}/documentation_log.cmake
    VERBATIM)
