"""Runs the colossus program for the tests. From the environment: COLOSSUS_PROGRAM, and where tests need them
COLOSSUS_OTHER_PROGRAM (of another build type), COLOSSUS_MPIEXEC (a list with semicolons), COLOSSUS_SHARED_DATA."""
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import unittest

try:
    import numpy  # noqa: F401
except ImportError as error:
    print(f"skipped: {error}; install python3-numpy")
    sys.exit(77)

import check_closed

# A run that does not end, or fills the disk, is a failed test and no more.
MOST_SECONDS, MOST_FILE_BYTES = 240, 4 << 30
OK, USAGE, BAD_DATA, CANNOT_CREATE = 0, 2, 65, 73
PROGRAM = os.environ["COLOSSUS_PROGRAM"]


def limit_files(open_files=None):
    resource.setrlimit(resource.RLIMIT_FSIZE, (MOST_FILE_BYTES, MOST_FILE_BYTES))
    if open_files:
        resource.setrlimit(resource.RLIMIT_NOFILE, (open_files, open_files))


class ColossusTest(unittest.TestCase):
    """Each test in a folder of its own."""

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="colossus-test-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def path(self, name):
        return os.path.join(self.folder, name)

    def run_program(self, *arguments, ranks=0, status=OK, program=PROGRAM, open_files=None):
        """Runs `colossus ARGUMENTS...`, under mpirun if ranks > 0, and expects the exit status. `open_files`: ulimit -n."""
        launcher = os.environ["COLOSSUS_MPIEXEC"].split(";") + [str(ranks)] if ranks else []
        run = subprocess.run([*launcher, program, *map(str, arguments)], capture_output=True, text=True, errors="replace",
                             check=False,
                             timeout=MOST_SECONDS, preexec_fn=lambda: limit_files(open_files))
        self.assertEqual(run.returncode, status, f"colossus {' '.join(map(str, arguments))}\n{run.stdout}{run.stderr}")
        return run

    def build(self, name, *inputs, options=(), ranks=0, program=PROGRAM):
        output = self.path(name)
        self.run_program("build", *inputs, "-o", output, *options, ranks=ranks, program=program)
        return output

    def info(self, container):
        return json.loads(self.run_program("info", "--json", container).stdout)

    def extract(self, container, *cut):
        output = self.path("cut.ply")
        self.run_program("extract", container, "-o", output, *cut)
        return check_closed.read_ply(output)

    def finest(self, container):
        return self.extract(container, "--level", 99)

    def shared_scan(self, name):
        """A scan of ../shared/data. Where it is absent, the test is skipped by name."""
        path = os.path.join(os.environ.get("COLOSSUS_SHARED_DATA", ""), name)
        if not os.path.isfile(path):
            self.skipTest(f"{name} is not in COLOSSUS_SHARED_DATA={os.environ.get('COLOSSUS_SHARED_DATA', '')}")
        return path


def main():
    """Runs the tests named on the command line; 77, ctest's skip, when every one of them was skipped."""
    result = unittest.main(module="__main__", exit=False, verbosity=2).result
    if not result.wasSuccessful():
        sys.exit(1)
    sys.exit(77 if result.skipped and len(result.skipped) == result.testsRun else 0)
