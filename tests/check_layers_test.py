#!/usr/bin/env python3
"""Plants violations into a copy of src/ and expects scripts/check_layers.py to find each, and nothing in src/ itself.

check_layers_test.py CHECKER SOURCE_FOLDER
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

# (file, line added to it, what the checker must say)
PLANTED = [
    ("core/error.hpp", '#include "mesh/mesh.hpp"', "core may not include mesh/mesh.hpp"),
    ("simplify/region.hpp", '  #  include "codec/codec.hpp"', "simplify may not include codec/codec.hpp"),
    ("pipeline/build.cpp", "#include <mpi.h>", "pipeline may not include mpi.h"),
    ("scratch/spool.cpp", '#include "mpi.h"', "scratch may not include mpi.h"),
    ("reader/open.cpp", "#include <hdf5.h>", "reader may not include hdf5.h"),
    ("reader/diamonds/statue.cpp", "#include <hdf5/serial/H5public.h>",
     "reader/diamonds may not include hdf5/serial/H5public.h"),
    ("codec/node_codec.cpp", "#include <fstream>", "codec may not include fstream"),
    ("hierarchy/diamond.cpp", '#include "core/file.hpp"', "hierarchy may not include core/file.hpp"),
    ("pipeline/build.cpp", '#include "cluster/mpi_calls.hpp"', "is private to cluster"),
    ("pipeline/build.cpp", '#include "../mesh/mesh.hpp"', "should start with a folder of src/"),
    ("container/table.cpp", '#include "geometry/point.hpp"', "does not link colossus::geometry"),
    ("mesh/CMakeLists.txt", "target_link_libraries(colossus_mesh PUBLIC colossus::codec)",
     "mesh may not link colossus::codec"),
    ("novel/novel.cpp", "int x;", "does not know the folder novel"),
    # Folders within folders.
    ("pipeline/facts/catalog.hpp", '#include "pipeline/run/phase.hpp"',
     "pipeline/facts may not include pipeline/run/phase.hpp"),
    ("pipeline/run/phase.cpp", '#include "pipeline/ingest/join.hpp"', "pipeline/run may not include"),
    ("pipeline/blocks/node.cpp", '#include "pipeline/diamonds/node.hpp"', "pipeline/blocks may not include"),
    ("pipeline/buckets/buckets.cpp", '#include "pipeline/build.hpp"', "pipeline/buckets may not include"),
    ("reader/blocks/statue.cpp", '#include "reader/diamonds/statue.hpp"', "reader/blocks may not include"),
    ("reader/access/statue.cpp", '#include "verify/verify.hpp"', "reader/access may not include"),
    ("verify/measure/finest.cpp", '#include "reader/blocks/statue.hpp"', "verify/measure may not include"),
    ("codec/coded/places.cpp", '#include "codec/codec.hpp"', "codec/coded may not include codec/codec.hpp"),
    ("pipeline/buckets/CMakeLists.txt", "target_link_libraries(colossus_pipeline_buckets PUBLIC colossus::pipeline)",
     "pipeline/buckets may not link colossus::pipeline"),
    ("pipeline/novel/novel.cpp", "int x;", "does not know the folder pipeline/novel"),
    ("pipeline/run/memory.cpp", "namespace colossus::pipeline {}", "expected namespace colossus::pipeline::run"),
    ("mesh/novel.cpp", "int x;", "expected namespace colossus::mesh, found none"),
    ("pipeline/novel.h", "#include <mpi.h>", "expected a name that ends in .cpp or .hpp"),
    ("pipeline/estimate.cpp", '#include "pipeline/blocks/scheme.hpp"', "is of one scheme"),
    ("cli/reader_commands.cpp", '#include "reader/diamonds/statue.hpp"', "cli may not include"),
    ("verify/blocks/checks.cpp", '#include "reader/diamonds/statue.hpp"', "verify/blocks may not include"),
    ("../tests/mesh/mesh_test.cpp", "int x;", "expected tests in"),  # and in no other folder
]


def run(checker, source):
    done = subprocess.run([sys.executable, checker, source], capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


def main():
    checker, source = sys.argv[1:3]
    failures = []
    status, output = run(checker, source)
    if status != 0:
        failures.append(f"{source} as it is: status {status}\n{output}")
    for name, line, expected in PLANTED:
        with tempfile.TemporaryDirectory() as folder:
            copy = pathlib.Path(folder) / "src"
            shutil.copytree(source, copy)
            if not (copy / name).exists() and "novel" not in name and ".." not in name:
                failures.append(f"{name}: expected a file of src/ to plant a violation in, found none")
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            with open(copy / name, "a") as file:
                file.write(f"\n{line}\n")
            status, output = run(checker, copy)
            if status != 1 or expected not in output:
                failures.append(f"{name} with {line!r}: expected {expected!r}, found status {status}\n{output}")
    print("\n".join(failures) if failures else f"{len(PLANTED)} planted violations found")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
