# Runs COMMAND, which must end within 20 seconds with STATUS ("any": not 0) and print the regular expression MESSAGE
# TIMES times.
execute_process(COMMAND ${COMMAND} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output TIMEOUT 20)
string(REGEX MATCHALL "${MESSAGE}" found "${output}")
list(LENGTH found times)
if(NOT status MATCHES "^[0-9]+$")
  message(FATAL_ERROR "did not end in order: ${status}\n${output}")
endif()
if((STATUS STREQUAL "any" AND status EQUAL 0) OR (NOT STATUS STREQUAL "any" AND NOT status EQUAL STATUS))
  message(FATAL_ERROR "expected status ${STATUS}, found ${status}\n${output}")
endif()
if(NOT times EQUAL TIMES)
  message(FATAL_ERROR "expected '${MESSAGE}' ${TIMES} times, found it ${times} times in\n${output}")
endif()
