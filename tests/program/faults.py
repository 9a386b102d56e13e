"""Builds that fail, stop or are killed at a moment that is counted in progress, and go on with --resume. See
fault_shim.cpp for how: COLOSSUS_FAULT_SHIM is that library. The seed of what is drawn is COLOSSUS_TEST_SEED, or
random; it is printed."""
import dataclasses
import errno
import filecmp
import os
import random
import select
import shutil
import signal
import struct
import subprocess

import program

NO_RESOURCES, IO, STOPPED = 69, 74, 75
SHIM = os.environ["COLOSSUS_FAULT_SHIM"]
MOST_SECONDS = 60  # of one build, all of which take less than one
SIZE_OF_STATE = 4096


def seed_of_the_day():
    seed = int(os.environ.get("COLOSSUS_TEST_SEED") or struct.unpack("<I", os.urandom(4))[0])
    print(f"COLOSSUS_TEST_SEED={seed}", flush=True)
    return random.Random(seed)


@dataclasses.dataclass
class Fault:
    event: str  # as in fault_shim.cpp
    n: int
    when: str
    action: str  # "short", "late", an errno or minus a signal
    target: str = "self"

    def __str__(self):
        return f"{self.event} {self.n} {self.when} {self.action} {self.target}"


@dataclasses.dataclass
class Run:
    """How a build ended, or not yet."""
    process: subprocess.Popen
    folder: str

    def wait(self):
        self.status = self.process.wait(timeout=MOST_SECONDS)
        return self

    @property
    def pids(self):
        return [pid for pid in self._state()[3:] if pid > 0]

    @property
    def events(self):
        return self._state()[0]

    def _state(self):
        with open(os.path.join(self.folder, "state"), "rb") as file:
            return struct.unpack("<67i", file.read(4 * 67))

    def text(self, name):
        with open(os.path.join(self.folder, name), encoding="utf-8", errors="replace") as file:
            return file.read()

    @property
    def errors(self):
        """Messages of the program, without what mpirun adds."""
        return [line for line in self.text("stderr").splitlines() if line.startswith("colossus: error")]

    @property
    def warnings(self):
        return [line for line in self.text("stderr").splitlines() if line.startswith("colossus: warning")]

    def trace(self):
        """(operation, file, kind, phase) of each operation on scratch and output, in order."""
        return [tuple(line.split(" ")) for line in self.text("trace").splitlines()]

    def __str__(self):
        return f"status {self.process.returncode}\n{self.text('stdout')}{self.text('stderr')}"


def is_alive(pid):
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
            return file.read().rsplit(")", 1)[1].split()[0] not in "ZX"
    except OSError:
        return False


def outlives(pid, seconds=60):
    """Whether the process is there for so long still: mpirun may end while its last ranks are being torn down."""
    try:
        handle = os.pidfd_open(pid)
    except OSError:
        return False
    try:
        return is_alive(pid) and not select.select([handle], [], [], seconds)[0]
    finally:
        os.close(handle)


class Builder:
    """Builds one container in a folder of its own, again and again."""

    def __init__(self, folder, inputs, options):
        self.folder, self.inputs, self.options = folder, list(inputs), list(map(str, options))
        self.output = os.path.join(folder, "out", "statue.h5")
        self.scratch = self.output + ".scratch"
        self.runs = []
        os.makedirs(os.path.dirname(self.output))

    def start(self, *options, ranks=0, fault=None, inputs=None, preexec=None, program_file=program.PROGRAM):
        run_folder = os.path.join(self.folder, f"run_{len(self.runs)}")
        os.makedirs(run_folder)
        for name in "state", "trace":
            with open(os.path.join(run_folder, name), "wb") as file:
                file.write(bytes(SIZE_OF_STATE if name == "state" else 0))
        # mpirun ends the other ranks of one that was killed at once, not after a second.
        environment = dict(os.environ, OMPI_MCA_odls_base_sigkill_timeout="0",
                           COLOSSUS_SHIM_FOLDERS=os.path.dirname(self.output),
                           COLOSSUS_SHIM_STATE=os.path.join(run_folder, "state"),
                           COLOSSUS_SHIM_TRACE=os.path.join(run_folder, "trace"), COLOSSUS_SHIM_FAULT=str(fault or ""))
        # Only the program itself gets the library, not mpirun.
        launcher = os.environ["COLOSSUS_MPIEXEC"].split(";") + [str(ranks)] if ranks else []
        command = [*launcher, "env", f"LD_PRELOAD={SHIM}", program_file, "build", *(inputs or self.inputs),
                   "-o", self.output, *self.options, *map(str, options)]
        # Ranks may outlive mpirun, and would hold pipes open.
        with open(os.path.join(run_folder, "stdout"), "wb") as out, \
             open(os.path.join(run_folder, "stderr"), "wb") as err:
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out, stderr=err, env=environment,
                                       preexec_fn=preexec)
        self.runs.append(Run(process, run_folder))
        return self.runs[-1]

    def run(self, *options, **arguments):
        return self.start(*options, **arguments).wait()

    def clear(self):
        """As before the first build; ranks that still live have no say in it any more."""
        self.end_ranks()
        shutil.rmtree(os.path.dirname(self.output))
        os.makedirs(os.path.dirname(self.output))

    def end_ranks(self):
        for run in self.runs:
            for pid in [*run.pids, run.process.pid]:
                if is_alive(pid):
                    os.kill(pid, signal.SIGKILL)
            run.process.wait()
            shutil.rmtree(run.folder)
        self.runs = []


class FaultTest(program.ColossusTest):
    def setUp(self):
        super().setUp()
        self.random = seed_of_the_day()
        self.reference = {}

    def statue(self, triangles):
        path = self.path("statue.ply")
        self.run_program("synth", "-o", path, "--triangles", triangles, "--seed", 3)
        return path

    def builder(self, name, inputs, options):
        builder = Builder(self.path(name), inputs, options)
        self.addCleanup(builder.end_ranks)
        return builder

    def make_reference(self, builder):
        """Builds without a fault; keeps the bytes. Returns the trace."""
        run = builder.run()
        self.assertEqual(run.status, program.OK, str(run))
        self.assertEqual(os.listdir(os.path.dirname(builder.output)), ["statue.h5"])
        kept = self.path(f"reference_{len(self.reference)}.h5")
        self.reference[tuple(builder.options)] = kept
        os.rename(builder.output, kept)
        trace = run.trace()
        builder.clear()
        return trace

    def is_right(self, builder):
        return filecmp.cmp(builder.output, self.reference[tuple(builder.options)], shallow=False)

    def assert_right_or_nothing(self, builder, what):
        if os.path.exists(builder.output):
            self.assertTrue(self.is_right(builder), f"{what}: a wrong container under its final name")

    def assert_resumes(self, builder, what, ranks=0):
        run = builder.run("--resume", ranks=ranks)
        self.assertEqual(run.status, program.OK, f"{what}: {run}")
        self.assertTrue(self.is_right(builder), f"{what}: the resumed build made other bytes")
        self.assertFalse(os.path.exists(builder.scratch), f"{what}: scratch is left")
        return run


def moments_of(trace):
    """What a build does, in order, as events of fault_shim.cpp with how often each occurs: the start, the tasks of each
    phase, the release of scratch, the writes of the container, its rename, the removal of scratch."""
    counts = {}
    for operation, file, kind, phase in trace:
        if kind in ("start", "task", "release"):
            event = f"{phase}.{kind}"
        elif file.endswith(".part") and operation == "pwrite":
            event = "part"
        elif operation in ("rename", "unlink", "rmdir"):
            event = operation
        else:
            continue
        counts[event] = counts.get(event, 0) + 1
    return counts


def name_of(error):
    return errno.errorcode[error]
