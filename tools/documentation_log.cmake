# Ends in failure if Doxygen has warned of anything in LOG but of fields that have no comment of their own.
file(STRINGS ${LOG} warnings)
list(FILTER warnings EXCLUDE REGEX "Member [^ ]+ \\(variable\\) of (struct|class) [^ ]+.* is not documented")
if(warnings)
    list(JOIN warnings "\n" warnings)
    message(FATAL_ERROR "${warnings}")
endif()
