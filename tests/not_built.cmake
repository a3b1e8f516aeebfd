# Configures SOURCE in SCRATCH with COMPILER as if packages were missing, and checks that each part that needs them is
# left out with one line and that the program is still configured.
file(REMOVE_RECURSE ${SCRATCH})

# expect_lines(LINES OPTION...): configuring with the options prints these lines and no other about missing packages.
function(expect_lines lines)
    execute_process(COMMAND ${CMAKE_COMMAND} -S ${SOURCE} -B ${SCRATCH} -G Ninja -DCMAKE_CXX_COMPILER=${COMPILER} ${ARGN}
        RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE errors)
    if(NOT code EQUAL 0)
        message(FATAL_ERROR "${ARGN}: configuring failed with ${code}:\n${errors}")
    endif()
    string(REGEX REPLACE "; install with tools/build --with ([a-z_]+) PRESET\n" " (\\1)\n" output "${output}")
    string(REGEX MATCHALL "[^\n]* not built: [^\n]*" found "${output}")
    list(TRANSFORM found REPLACE "^-- " "")
    if(NOT found STREQUAL lines)
        message(FATAL_ERROR "${ARGN}: found lines\n${found}\nexpected\n${lines}")
    endif()
    file(READ ${SCRATCH}/build.ninja rules)
    if(NOT rules MATCHES "\nbuild haarfield: ")
        message(FATAL_ERROR "${ARGN}: the program is not configured")
    endif()
endfunction()

set(without_tests -DCMAKE_DISABLE_FIND_PACKAGE_GTest=ON -DCMAKE_DISABLE_FIND_PACKAGE_benchmark=ON)
set(python "Python module and Blender add-on not built")
set(tests "Tests not built: GoogleTest, Google Benchmark are missing (tests)")
expect_lines("${python}: pybind11 is missing (python);${tests}"
    -DCMAKE_DISABLE_FIND_PACKAGE_pybind11=ON ${without_tests})
expect_lines("${python}: Python with its headers is missing (python);${tests}"
    -DCMAKE_DISABLE_FIND_PACKAGE_Python=ON ${without_tests})
expect_lines("Test of the sources' format not built: clang-format is missing (tests);\
Test of the licences not built: reuse is missing (tests);\
Tests in Blender not built: blender is missing (blender);\
Test with Slurm not built: Slurm, munge are missing (cluster);\
Tests of the page of `view` not built: Chromium, chromedriver are missing (view_tests)"
    -UCMAKE_DISABLE_FIND_PACKAGE_* -DCLANG_FORMAT=OFF -DBLENDER=OFF -DSLURMCTLD=OFF -DMUNGED=OFF -DCHROMIUM=OFF
    -DCHROMEDRIVER=OFF -DREUSE=OFF)
file(REMOVE_RECURSE ${SCRATCH})
