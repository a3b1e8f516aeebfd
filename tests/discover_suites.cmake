# haarfield_discover_suites(TARGET SECONDS N [EACH SUITE...] [SLOW NAME...])
#
# Adds one ctest entry for each suite of a GoogleTest program, or one for each test of the suites in EACH. Suites are
# the default because the program needs a quarter of a second to start.
#
# SECONDS  the time limit of each entry
# EACH     suites whose tests take long, as they start many processes; ctest starts these entries first
# SLOW     regular expressions; entries whose whole name matches one get the label `slow`
function(haarfield_discover_suites target)
    cmake_parse_arguments(PARSE_ARGV 1 wanted "" "SECONDS" "EACH;SLOW")
    set(listed ${CMAKE_CURRENT_BINARY_DIR}/${target}_suites.cmake)
    add_custom_command(TARGET ${target} POST_BUILD BYPRODUCTS ${listed}
        COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${target}> -DLISTED=${listed} -DSECONDS=${wanted_SECONDS}
            "-DEACH=${wanted_EACH}" "-DSLOW=${wanted_SLOW}" -P ${CMAKE_CURRENT_FUNCTION_LIST_FILE}
        VERBATIM)
    set(included ${CMAKE_CURRENT_BINARY_DIR}/${target}_tests.cmake)
    file(WRITE ${included} "if(EXISTS [==[${listed}]==])\n  include([==[${listed}]==])\nelse()\n"
        "  add_test(${target}_NOT_BUILT ${target}_NOT_BUILT)\nendif()\n")
    set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${included})
endfunction()

if(CMAKE_SCRIPT_MODE_FILE)
    cmake_policy(VERSION 3.25)
    execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE output COMMAND_ERROR_IS_FATAL ANY)
    # Suites start a line and end in a full stop; their tests are indented.
    string(REGEX MATCHALL "[^\n]+" lines "${output}")
    set(names "")
    foreach(line ${lines})
        string(REGEX REPLACE " *#.*" "" line "${line}")
        if(line MATCHES "^([A-Za-z_][A-Za-z0-9_/]*)\\.$")
            set(suite ${CMAKE_MATCH_1})
            if(NOT suite IN_LIST EACH)
                list(APPEND names "${suite}")
            endif()
        elseif(line MATCHES "^  (.+)$" AND suite IN_LIST EACH)
            list(APPEND names "${suite}.${CMAKE_MATCH_1}")
        endif()
    endforeach()
    if(NOT names)
        message(FATAL_ERROR "${PROGRAM} --gtest_list_tests lists no suite: ${output}")
    endif()
    foreach(suite ${EACH})
        if(NOT names MATCHES "(^|;)${suite}\\.")
            message(FATAL_ERROR "${PROGRAM} has no suite ${suite}")
        endif()
    endforeach()
    set(tests "")
    foreach(name ${names})
        set(filter "${name}")
        set(cost 1)
        if(NOT name MATCHES "\\.")
            set(filter "${name}.*")
            set(cost 0)
        endif()
        set(labels "")
        foreach(slow ${SLOW})
            if(name MATCHES "^(${slow})$")
                set(labels " LABELS slow")
            endif()
        endforeach()
        string(APPEND tests "add_test([==[${name}]==] [==[${PROGRAM}]==] [==[--gtest_filter=${filter}]==])\n"
            "set_tests_properties([==[${name}]==] PROPERTIES TIMEOUT ${SECONDS} COST ${cost}${labels})\n")
    endforeach()
    file(WRITE ${LISTED} "${tests}")
endif()
