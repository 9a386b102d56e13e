"""Lets every operation of a small build that changes files fail, one at a time: with a full disk, with a device that
fails, by coming short. The build says so with one message and the right status and leaves no container under the final
name, or it has overcome the fault; --resume then makes the bytes of a build without one. COLOSSUS_FAULT_RANKS: on so
many ranks; else without mpirun."""
import concurrent.futures
import errno
import os
import shutil

import faults
import program
from faults import Fault

RANKS = int(os.environ.get("COLOSSUS_FAULT_RANKS", 0))
WORKERS = 2
# What fails is no write, and may be of no consequence: a file that is closed after it was flushed, or scratch that cannot
# be removed after the container is complete.
MAY_BE_OVERCOME = ("close", "unlink", "rmdir")


class WriteFaults(faults.FaultTest):
    def faults_of(self, n, operation):
        """What may happen to the n-th operation of this name: (fault, the statuses that are right)."""
        full, broken = (str(errno.ENOSPC), faults.NO_RESOURCES), (str(errno.EIO), faults.IO)
        if operation in MAY_BE_OVERCOME:
            return [(Fault(operation, n, "before", broken[0]), (program.OK, faults.IO))]
        found = [(Fault(operation, n, "before", error), (status,)) for error, status in (full, broken)]
        if operation == "pwrite":
            found.append((Fault(operation, n, "half", "short"), (program.OK,)))
            # As it mostly happens: the last bytes that there is room for are written.
            found[0] = (Fault(operation, n, self.random.choice(["before", "half"]), full[0]), (full[1],))
        return found

    def check(self, scheme, *options, is_resumed=False):
        options = ["--scheme", scheme, *options]
        statue = self.statue(400)
        builder = self.builder("reference", [statue], options)
        trace = self.make_reference(builder)
        if is_resumed:
            trace = self.kill_and_resume(builder, trace)
        writes = [operation for operation, *_ in trace]
        self.assertGreater(writes.count("pwrite"), 20)
        print(f"{scheme}: {len(writes)} operations, {writes.count('pwrite')} of them writes")
        cases = [(fault, statuses, trace[i]) for i, operation in enumerate(writes)
                 for fault, statuses in self.faults_of(writes[:i + 1].count(operation), operation)]

        failures = []

        def check_case(case):
            number, (fault, statuses, operation) = case
            builder = self.builder(f"case_{number}", [statue], options)
            if is_resumed:
                shutil.copytree(self.kept, builder.scratch)
            try:
                self.check_fault(builder, fault, statuses, f"{scheme}: {' '.join(operation)}: {fault}")
            except AssertionError as failure:
                failures.append(str(failure))
            builder.end_ranks()
            shutil.rmtree(builder.folder)

        with concurrent.futures.ThreadPoolExecutor(WORKERS) as pool:
            list(pool.map(check_case, enumerate(cases)))
        self.assertFalse(failures, f"{len(failures)} of {len(cases)} faults\n" + "\n".join(failures[:10]))

    def kill_and_resume(self, builder, trace):
        """Keeps in self.kept what a build leaves that is killed half way. Returns the trace of the next attempt."""
        phases = [event for event in faults.moments_of(trace) if event.endswith(".task")]
        builder.run(fault=Fault(phases[len(phases) // 2], 1, "half", "-9"))
        self.kept = self.path("kept")
        shutil.copytree(builder.scratch, self.kept)
        return self.assert_resumes(builder, "without a fault").trace()

    def check_fault(self, builder, fault, statuses, what):
        run = builder.run("--resume", ranks=RANKS, fault=fault)
        if RANKS == 0 or fault.event not in (*MAY_BE_OVERCOME, "create"):  # of which several ranks have other numbers
            self.assertGreaterEqual(run.events, fault.n, f"{what}: the operation was not reached\n{run}")
            self.assertIn(run.status, statuses, f"{what}: {run}")
        self.assert_right_or_nothing(builder, what)
        self.assertFalse(os.path.exists(builder.output + ".part"), f"{what}: the part is left")
        if run.status == program.OK:
            self.assertTrue(self.is_right(builder), what)
            self.assertFalse(run.errors, f"{what}: {run}")
            if os.path.exists(builder.scratch):
                self.assertEqual(len(run.warnings), 1, f"{what}: scratch is left in silence: {run}")
                self.assertIn(builder.scratch, run.warnings[0], what)
        else:
            self.assertEqual(len(run.errors), 1, f"{what}: {run}")
            self.assertIn(run.status, statuses, f"{what}: {run}")
            self.assertIn(builder.output, run.errors[0], f"{what}: the message names no file")
            self.assertIn(os.strerror(int(fault.action)), run.errors[0], what)
        self.assert_resumes(builder, what, RANKS)

    def test_folders_that_cannot_be_written(self):
        options = ["--leaf-triangles", 300]
        statue = self.statue(400)
        trace = self.make_reference(self.builder("reference", [statue], options))
        for name in "mkdir", "create", "rename":
            for n in range(1, sum(operation == name for operation, *_ in trace) + 1):
                builder = self.builder(f"{name}_{n}", [statue], options)
                fault = Fault(name, n, "before", str(self.random.choice([errno.EACCES, errno.EROFS])))
                self.check_fault(builder, fault, (program.CANNOT_CREATE,), str(fault))

    def test_diamonds(self):
        self.check("diamonds", "--leaf-triangles", 300)

    def test_diamonds_resumed(self):
        self.check("diamonds", "--leaf-triangles", 300, is_resumed=True)

    def test_blocks(self):
        self.check("blocks", "--leaf-triangles", 200, "--levels", 1)


if __name__ == "__main__":
    program.main()
