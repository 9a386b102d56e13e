# Writes the source of build_id.hpp. Runs in each build; leaves the file alone when it would stay as it is, so that
# nothing is compiled or linked again.
#
#   cmake -DSOURCES=<top of the sources> -DOUTPUT=<file> -P write_build_id.cmake
set(commit none)
find_program(GIT git)
if(GIT)
  execute_process(COMMAND ${GIT} -C ${SOURCES} rev-parse --show-toplevel HEAD OUTPUT_VARIABLE answer RESULT_VARIABLE status
                  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  # A tarball may have been unpacked within a repository of something else.
  get_filename_component(top ${SOURCES} REALPATH)
  if(status EQUAL 0 AND answer MATCHES "^(.*)\n([0-9a-f]+)$" AND CMAKE_MATCH_1 STREQUAL top)
    set(commit ${CMAKE_MATCH_2})
  endif()
endif()

file(GLOB_RECURSE files RELATIVE ${SOURCES} ${SOURCES}/src/*.cpp ${SOURCES}/src/*.hpp)
list(SORT files)
set(hashes "")
foreach(name IN LISTS files)
  file(SHA256 ${SOURCES}/${name} hash)
  string(APPEND hashes "${hash} ${name}\n")
endforeach()
string(SHA256 sources "${hashes}")
string(SUBSTRING ${sources} 0 16 sources)

file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT [[
#include "pipeline/run/build_id.hpp"

namespace colossus::pipeline::run {

const char* build_commit() { return "@commit@"; }
const char* build_id() { return "commit @commit@, sources @sources@"; }

}  // namespace colossus::pipeline::run
]])
