# The target `documentation`, if Doxygen is installed, writes pages of the four libraries' declarations into html/ of the
# build folder. A declaration without a comment is an error. Fields may lack a comment if name, type and the comment of
# their struct suffice, and default comparisons need none.
find_package(Doxygen QUIET)
if(NOT DOXYGEN_FOUND)
    return()
endif()

set(DOXYGEN_FILE_PATTERNS *.h)
set(DOXYGEN_EXCLUDE_PATTERNS *-inl.h */scenes/gallery/data/*)  # the latter: of tools/gallery
set(DOXYGEN_EXCLUDE_SYMBOLS TOML_*)
set(DOXYGEN_STRIP_FROM_PATH ${PROJECT_SOURCE_DIR})
set(DOXYGEN_STRIP_FROM_INC_PATH ${PROJECT_SOURCE_DIR})
set(DOXYGEN_DISTRIBUTE_GROUP_DOC YES)  # one comment for several declarations between @{ and @}
set(DOXYGEN_HAVE_DOT NO)
set(DOXYGEN_QUIET YES)
# The comment at the top of a header documents the file.
set(DOXYGEN_INPUT_FILTER "sed '1s|^#pragma once$|/// \\\\file|'")
set(DOXYGEN_WARN_LOGFILE ${PROJECT_BINARY_DIR}/documentation.log)
doxygen_add_docs(documentation fields shading scenes bridge)
set(check_documentation ${CMAKE_COMMAND} -DLOG=${DOXYGEN_WARN_LOGFILE})
add_custom_command(TARGET documentation POST_BUILD
    COMMAND ${check_documentation} -P ${CMAKE_CURRENT_LIST_DIR}/documentation_log.cmake VERBATIM)
set(HAARFIELD_DOCUMENTATION_TEST ${check_documentation} -DDOXYGEN=${DOXYGEN_EXECUTABLE}
    -DDOXYFILE=${PROJECT_BINARY_DIR}/Doxyfile.documentation -DSOURCE=${PROJECT_SOURCE_DIR}
    -P ${CMAKE_CURRENT_LIST_DIR}/documentation_log.cmake)
