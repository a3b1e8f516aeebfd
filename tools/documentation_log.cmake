# Fails if Doxygen's log contains any warning except those about fields and default comparisons without a comment.
# Parameters: LOG; to run Doxygen first, DOXYGEN, DOXYFILE and SOURCE (the project's folder).
if(DOXYGEN)
    execute_process(COMMAND ${DOXYGEN} ${DOXYFILE} WORKING_DIRECTORY ${SOURCE} COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
endif()
file(STRINGS ${LOG} warnings)
list(FILTER warnings EXCLUDE REGEX "Member [^ ]+ \\(variable\\) of (struct|class) [^ ]+.* is not documented")
list(FILTER warnings EXCLUDE REGEX "Member operator==.* const =default .* is not documented")
if(warnings)
    list(JOIN warnings "\n" warnings)
    message(FATAL_ERROR "${warnings}")
endif()
