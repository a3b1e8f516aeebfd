# Installs the project into a temporary folder, then configures, builds and runs a project that uses it: the programs in
# the libraries' manuals, and a source for each header.
# Parameters: BUILD (the project's build folder), SOURCE (tests/installed_package), SCRATCH, COMPILER, FLAGS.
file(REMOVE_RECURSE ${SCRATCH})
file(MAKE_DIRECTORY ${SCRATCH})

function(run)
    execute_process(COMMAND ${ARGV} WORKING_DIRECTORY ${SCRATCH} RESULT_VARIABLE code OUTPUT_VARIABLE said ERROR_VARIABLE said)
    message("${said}")
    if(NOT code EQUAL 0)
        list(JOIN ARGV " " command)
        message(FATAL_ERROR "${command}\nended with ${code}")
    endif()
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${SCRATCH}/prefix)
run(${CMAKE_COMMAND} -G Ninja -S ${SOURCE} -B ${SCRATCH}/build -DCMAKE_PREFIX_PATH=${SCRATCH}/prefix
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_FLAGS=${FLAGS})
run(${CMAKE_COMMAND} --build ${SCRATCH}/build)
set(scenes ${SCRATCH}/prefix/share/haarfield/scenes)
# The libraries search for the reader in the configured install folder, which is another one.
set(ENV{HAARFIELD_READER} ${SCRATCH}/prefix/bin/haarfield-reader)
run(${SCRATCH}/build/fields_manual ${scenes}/meshes/chair.obj)
run(${SCRATCH}/build/shading_manual ${scenes}/meshes/chair.obj)
run(${SCRATCH}/build/scenes_manual ${scenes}/single_chair.toml)
run(${SCRATCH}/build/bridge_manual ${scenes}/single_chair.toml)
run(${SCRATCH}/prefix/bin/haarfield --version)
file(REMOVE_RECURSE ${SCRATCH})
