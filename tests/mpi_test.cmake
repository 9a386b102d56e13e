# Tests on several ranks.
include_guard(GLOBAL)

# Root in a container, more ranks than cores, and no binding: mpirun would bind the ranks of all tests that run at a
# time to the same cores. Leaks are Open MPI's own, in modules that it has unloaded, so that no suppression names them.
set(COLOSSUS_MPI_ENVIRONMENT
    OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
    OMPI_MCA_hwloc_base_binding_policy=none ASAN_OPTIONS=detect_leaks=0
    CACHE INTERNAL "environment of tests under mpirun, in all folders")

# colossus_mpi_run_test(<test name> <ranks> COMMAND ... [TIMEOUT seconds]): a ctest that runs COMMAND under mpirun.
function(colossus_mpi_run_test name ranks)
  cmake_parse_arguments(ARG "" "TIMEOUT" "COMMAND" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 60)
  endif()
  set(processors ${ranks})
  if(processors GREATER 2)
    set(processors 2)
  endif()
  add_test(NAME ${name} COMMAND ${MPIEXEC_EXECUTABLE} ${MPIEXEC_NUMPROC_FLAG} ${ranks} ${ARG_COMMAND})
  set_tests_properties(${name} PROPERTIES TIMEOUT ${ARG_TIMEOUT} PROCESSORS ${processors}
                       ENVIRONMENT "${COLOSSUS_MPI_ENVIRONMENT}")
endfunction()

# colossus_mpi_test(<name> RANKS 1 2 3 SOURCES ... LINK ... [TIMEOUT seconds]): a GoogleTest program with the main() of
# tests/mpi_main.cpp, as one ctest <name>.ranks_<n> for each number of ranks. RANKS 0 means: without mpirun.
function(colossus_mpi_test name)
  if(NOT COLOSSUS_BUILD_TESTS)
    return()
  endif()
  cmake_parse_arguments(ARG "" "TIMEOUT" "RANKS;SOURCES;LINK" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 60)
  endif()
  add_executable(test_${name} ${ARG_SOURCES} ${PROJECT_SOURCE_DIR}/tests/mpi_main.cpp)
  target_include_directories(test_${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  target_link_libraries(test_${name} PRIVATE ${ARG_LINK} colossus::cluster GTest::gtest colossus_flags)
  foreach(ranks ${ARG_RANKS})
    if(ranks EQUAL 0)
      add_test(NAME ${name}.alone COMMAND test_${name})
      set_tests_properties(${name}.alone PROPERTIES TIMEOUT ${ARG_TIMEOUT} PROCESSORS 1
                           ENVIRONMENT "${COLOSSUS_MPI_ENVIRONMENT}")
    else()
      colossus_mpi_run_test(${name}.ranks_${ranks} ${ranks} COMMAND $<TARGET_FILE:test_${name}> TIMEOUT ${ARG_TIMEOUT})
    endif()
  endforeach()
endfunction()
