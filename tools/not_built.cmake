# Prints one line if a part of the project lacks a dependency, and sets the variable RESULT to the missing
# names.
#
#     haarfield_not_built(RESULT PART LIST NAME FOUND [NAME FOUND]...)
#
# PART   the name of the part in that line
# LIST   the list in tools/packages/ that has the packages
# FOUND  the name of a variable that is true if NAME was found
function(haarfield_not_built result part list)
    set(missing "")
    while(ARGN)
        list(POP_FRONT ARGN name found)
        if(NOT ${found})
            list(APPEND missing ${name})
        endif()
    endwhile()
    if(missing)
        list(LENGTH missing count)
        list(JOIN missing ", " names)
        set(verb "is")
        if(count GREATER 1)
            set(verb "are")
        endif()
        message(STATUS "${part} not built: ${names} ${verb} missing; install with tools/build --with ${list} PRESET")
    endif()
    set(${result} "${missing}" PARENT_SCOPE)
endfunction()
