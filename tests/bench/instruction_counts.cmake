# Counts the instructions of the kernels with callgrind and compares them with stored counts.
#
# PROGRAM   haarfield_counted_kernels
# KEPT      the file of stored counts
# COMPILER  the compiler of the program, with its version
# VALGRIND  may be NOTFOUND
# KEEP      true: write the counts to KEPT instead of comparing
cmake_minimum_required(VERSION 3.25)

if(NOT VALGRIND)
    message(FATAL_ERROR "Instructions are counted by valgrind, which is not installed (Debian: valgrind).")
endif()

set(kept_lines "")
if(EXISTS ${KEPT})
    file(STRINGS ${KEPT} kept_lines)
    list(FILTER kept_lines EXCLUDE REGEX "^#")
endif()

execute_process(COMMAND ${PROGRAM} OUTPUT_VARIABLE kernels COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[a-z_]+" kernels "${kernels}")

set(new_text "# Instructions per vertex, of the kernels of shipped_kernels.h and of products of six functions, counted by
# callgrind in a release build on one thread, with AVX2 at most, since valgrind knows no more. Compared by the
# target instruction_counts, written by keep_instruction_counts.
compiler ${COMPILER}
")
set(grown "")
foreach(kernel IN LISTS kernels)
    execute_process(
        COMMAND ${VALGRIND} --tool=callgrind --callgrind-out-file=/dev/null --toggle-collect=counted_kernel
                ${PROGRAM} ${kernel}
        OUTPUT_VARIABLE vertices ERROR_VARIABLE log RESULT_VARIABLE failed)
    if(failed OR NOT log MATCHES "Collected : ([0-9]+)")
        message(FATAL_ERROR "${kernel}: ${log}")
    endif()
    set(count ${CMAKE_MATCH_1})
    string(STRIP "${vertices}" vertices)
    math(EXPR count "${count} / ${vertices}")
    string(APPEND new_text "${kernel} ${count}\n")

    set(line "${kernel}: ${count} instructions per vertex")
    foreach(kept IN LISTS kept_lines)
        if(kept MATCHES "^${kernel} ([0-9]+)$")
            set(before ${CMAKE_MATCH_1})
            math(EXPR per_mille "1000 * ${count} / ${before}")
            string(APPEND line ", kept ${before}, ${per_mille} per mille of it")
            if(per_mille GREATER 1020)
                list(APPEND grown ${kernel})
            endif()
        endif()
    endforeach()
    message("${line}")
endforeach()

if(KEEP)
    file(WRITE ${KEPT} "${new_text}")
elseif(NOT "compiler ${COMPILER}" IN_LIST kept_lines)
    message("The kept counts are of another compiler than ${COMPILER}: not compared.")
elseif(grown)
    message(FATAL_ERROR "More than 2 % more instructions than kept: ${grown}")
endif()
