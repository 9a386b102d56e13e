# shellcheck shell=bash
# Sourced by the other scripts: folders, cores, and what mpirun needs on any machine. Not run by itself.
# shellcheck disable=SC2034 # the scripts use what is set here

top=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cores=$(nproc)

export CMAKE_BUILD_PARALLEL_LEVEL=${CMAKE_BUILD_PARALLEL_LEVEL:-$cores}
if command -v ccache >/dev/null; then
  export CMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER-ccache}
fi

# Rank 0 mostly sleeps, so there is one rank more than cores; binding ranks to cores would then put two on one core.
export OMPI_MCA_rmaps_base_oversubscribe=1
export OMPI_MCA_hwloc_base_binding_policy=none
# Open MPI refuses to run as root, which containers and CI machines do.
if [ "$(id -u)" = 0 ]; then
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
fi

# say TEXT...: what the script does next, in a line of its own.
say() {
  printf '== %s\n' "$*"
}

# The number of ranks that is fastest on this machine: rank 0 hands out the work, the others do it; alone, it does both.
build_ranks() {
  if [ "$cores" = 1 ]; then echo 1; else echo $((cores + 1)); fi
}

# usage: prints the comment at the top of the script that runs, and ends it.
usage() {
  sed -n '2,/^[^#]/{/^#/s/^# \{0,1\}//p}' "$0" >&2
  exit 2
}
