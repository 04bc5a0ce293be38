# Configures the project SOURCE in SCRATCH and runs its tests, all and one alone; the drive must be gone afterwards.
file(REMOVE_RECURSE ${SCRATCH})
execute_process(COMMAND ${CMAKE_COMMAND} -S ${SOURCE} -B ${SCRATCH} -D SERVOBUS_BIN=${PROGRAMS} -D DRIVE_ADDRESS=${ADDRESS}
    OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
foreach(selection client client.reads)
    execute_process(COMMAND ${CMAKE_CTEST_COMMAND} --test-dir ${SCRATCH} --output-on-failure -R ${selection}
        COMMAND_ERROR_IS_FATAL ANY OUTPUT_VARIABLE said)
    if(NOT said MATCHES "100% tests passed" OR NOT said MATCHES "drive.stop")
        message(FATAL_ERROR "${said}")
    endif()
endforeach()
