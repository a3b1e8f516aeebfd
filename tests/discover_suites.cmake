# haarfield_discover_suites(TARGET SECONDS [SUITE COST]...): one test of ctest for each suite of a GoogleTest program,
# which may take so many seconds; of some suites the cost, by which ctest orders what it starts.
# A program that links as much as ours needs a quarter of a second to start: too much for each test.
function(haarfield_discover_suites target seconds)
    set(listed ${CMAKE_CURRENT_BINARY_DIR}/${target}_suites.cmake)
    add_custom_command(TARGET ${target} POST_BUILD BYPRODUCTS ${listed}
        COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${target}> -DLISTED=${listed} -DSECONDS=${seconds}
            "-DCOSTS=${ARGN}" -P ${CMAKE_CURRENT_FUNCTION_LIST_FILE}
        VERBATIM)
    set(included ${CMAKE_CURRENT_BINARY_DIR}/${target}_tests.cmake)
    file(WRITE ${included} "if(EXISTS [==[${listed}]==])\n  include([==[${listed}]==])\nelse()\n"
        "  add_test(${target}_NOT_BUILT ${target}_NOT_BUILT)\nendif()\n")
    set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${included})
endfunction()

if(CMAKE_SCRIPT_MODE_FILE)
    cmake_policy(VERSION 3.25)
    execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE output COMMAND_ERROR_IS_FATAL ANY)
    # Suites stand at the begin of a line and end in a full stop; their tests are indented.
    string(REGEX MATCHALL "(^|\n)[A-Za-z_][A-Za-z0-9_/]*\\." suites "${output}")
    if(NOT suites)
        message(FATAL_ERROR "${PROGRAM} --gtest_list_tests lists no suite: ${output}")
    endif()
    set(known_suites "")
    set(tests "")
    foreach(suite ${suites})
        string(REGEX REPLACE "^\n|\\.$" "" suite "${suite}")
        string(APPEND tests "add_test([==[${suite}]==] [==[${PROGRAM}]==] [==[--gtest_filter=${suite}.*]==])\n"
            "set_tests_properties([==[${suite}]==] PROPERTIES TIMEOUT ${SECONDS})\n")
        list(APPEND known_suites "${suite}")
    endforeach()
    while(COSTS)
        list(POP_FRONT COSTS suite cost)
        if(NOT suite IN_LIST known_suites)
            message(FATAL_ERROR "${PROGRAM} has no suite ${suite}, whose cost is given")
        endif()
        string(APPEND tests "set_tests_properties([==[${suite}]==] PROPERTIES COST ${cost})\n")
    endwhile()
    file(WRITE ${LISTED} "${tests}")
endif()
