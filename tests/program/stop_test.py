"""Builds that are asked to stop, by a signal to a rank or by a time limit, in every phase; builds whose scratch or input is
not what it was; and builds that another one has overtaken."""
import json
import os
import shutil
import signal
import time

import faults
import meshes
import program
from faults import Fault

SIGNALS = (signal.SIGUSR1, signal.SIGUSR2, signal.SIGTERM)
SCHEMES = {"diamonds": ("--scheme", "diamonds", "--leaf-triangles", 700),
           "blocks": ("--scheme", "blocks", "--leaf-triangles", 300)}
MOST_PATIENCE = 30  # seconds to wait for a state that is sure to come


def wait_until(condition):
    end = time.monotonic() + MOST_PATIENCE
    while not condition():
        if time.monotonic() > end:
            raise AssertionError("a state that was sure to come did not")
        time.sleep(0.005)


def ignore_hangup():
    signal.signal(signal.SIGHUP, signal.SIG_IGN)


def state_of(pid):
    with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
        return file.read().rsplit(")", 1)[1].split()[0]


class Stop(faults.FaultTest):
    def check_stop(self, builder, fault, what, ranks, *options):
        run = builder.run("--resume", *options, ranks=ranks, fault=fault)
        self.assertEqual(run.status, faults.STOPPED, f"{what}: {run}")
        self.assertEqual(run.errors, [], what)
        self.assertFalse(os.path.exists(builder.output), what)
        self.assertFalse([pid for pid in run.pids if faults.outlives(pid)], f"{what}: ranks are left")
        lines = [line for line in run.text("stdout").splitlines() if "  stopped" in line]
        self.assertEqual(len(lines), 1, f"{what}: {run}")
        self.assertIn("run the same command with --resume to continue", lines[0])
        return lines[0]

    def check_every_phase(self, scheme):
        builder = self.builder(scheme, [self.statue(20000)], SCHEMES[scheme])
        events = faults.moments_of(self.make_reference(builder))
        phases = [event for event in events if event.endswith(".task")] + ["part"]
        self.assertGreater(len(phases), 10)
        # Each phase is the end of one attempt and where the next one begins.
        for number, event in enumerate(phases):
            ranks = self.random.choice([0, 2, 3, 4])
            sent = self.random.choice(SIGNALS)
            n, when = self.random.randint(1, max(1, events[event] // 2)), self.random.choice(["before", "after"])
            target = self.random.choice(["self", "ranks", str(self.random.randrange(4))])
            fault = Fault(event, n, when, str(-sent), target)
            line = self.check_stop(builder, fault, f"{event} on {ranks} ranks: {fault}", ranks)
            self.assertRegex(line, f"stopped by {sent.name} to rank [0-3]")
            if number % 4 == 3:
                self.assert_resumes(builder, event, self.random.choice([0, 2, 3]))
                builder.clear()
        if os.path.exists(builder.scratch):
            self.assert_resumes(builder, "the last")

    def test_by_signals_in_every_phase_of_diamonds(self):
        self.check_every_phase("diamonds")

    def test_by_signals_in_every_phase_of_blocks(self):
        self.check_every_phase("blocks")

    def test_while_a_resumed_build_looks_at_scratch(self):
        builder = self.builder("look", [self.statue(20000)], SCHEMES["diamonds"])
        self.make_reference(builder)
        self.check_stop(builder, Fault("9.task", 1, "after", str(-signal.SIGTERM)), "the first attempt", 0)
        for ranks in (0, 3):
            what = f"on {ranks} ranks"
            self.check_stop(builder, Fault("0.start", 1, "after", str(-signal.SIGUSR1)), what, ranks)
        run = self.assert_resumes(builder, "after all")
        self.assertIn("resume: attempt 4", run.text("stdout"))

    def test_by_a_time_limit(self):
        builder = self.builder("limit", [self.statue(20000)], SCHEMES["diamonds"])
        events = faults.moments_of(self.make_reference(builder))
        for ranks in (0, 3):
            for event in self.random.sample([event for event in events if event.endswith(".task")], 3) + ["part"]:
                what = f"{event} on {ranks} ranks"
                line = self.check_stop(builder, Fault(event, 1, "after", "late"), what, ranks, "--time-limit", "12h")
                self.assertIn("stopped: the time limit is reached", line, what)
                self.assert_resumes(builder, what)
                builder.clear()


class Damage(faults.FaultTest):
    """Of what a build that was killed has left."""

    def stopped(self, scheme):
        """A builder that was killed when it had come two thirds of the way, whose scratch is kept in self.kept."""
        builder = self.builder(scheme, [self.statue(20000)], SCHEMES[scheme])
        phases = [event for event in faults.moments_of(self.make_reference(builder)) if event.endswith(".task")]
        run = builder.run(fault=Fault(phases[len(phases) * 2 // 3], 1, "half", "-9"))
        self.assertEqual(run.status, -signal.SIGKILL)
        self.kept = self.path("kept")
        shutil.copytree(builder.scratch, self.kept)
        return builder

    def check_damaged(self, builder, name, damage, what):
        """Resumes with the file of scratch damaged: the right bytes, or a refusal that says what to do."""
        shutil.rmtree(os.path.dirname(builder.output))
        shutil.copytree(self.kept, builder.scratch)
        path = os.path.join(builder.scratch, name)
        with open(path, "rb") as file:
            content = bytearray(file.read())
        with open(path, "wb") as file:
            file.write(damage(content))
        run = builder.run("--resume")
        self.assert_right_or_nothing(builder, what)
        if run.status == program.OK:
            self.assertTrue(self.is_right(builder), what)
            return True
        self.assertIn(run.status, (program.CANNOT_CREATE, faults.IO), f"{what}: {run}")
        self.assertEqual(len(run.errors), 1, f"{what}: {run}")
        self.assertIn("remove", run.errors[0], what)
        return False

    def flip_and_cut(self, builder, names, flips, cuts):
        redone = refused = 0
        for name in names:
            size = os.path.getsize(os.path.join(self.kept, name))
            for i in range(flips):
                at, bit = (size * i + self.random.randrange(size)) // flips, self.random.randrange(8)

                def flip(content, at=at, bit=bit):
                    content[at] ^= 1 << bit
                    return content
                done = self.check_damaged(builder, name, flip, f"{name}: bit {bit} of byte {at} of {size} flipped")
                redone, refused = redone + done, refused + (not done)
            for i in range(cuts):
                length = (size * i + self.random.randrange(size)) // cuts
                done = self.check_damaged(builder, name, lambda content, length=length: content[:length],
                                          f"{name}: cut from {size} to {length}")
                redone, refused = redone + done, refused + (not done)
        print(f"{redone} went on, {refused} were refused")
        return redone, refused

    def names(self, ending):
        return [os.path.relpath(os.path.join(folder, name), self.kept)
                for folder, _, names in os.walk(self.kept) for name in names if name.endswith(ending)]

    def check(self, scheme):
        builder = self.stopped(scheme)
        self.assertEqual(self.flip_and_cut(builder, self.names(".journal"), 15, 10)[1], 0)
        spools = self.names(".spool")
        self.assertGreater(len(spools), 1)
        self.assertEqual(self.flip_and_cut(builder, spools, 2, 1)[1], 0)

    def test_of_diamonds(self):
        self.check("diamonds")

    def test_of_blocks(self):
        self.check("blocks")

    def test_of_the_manifest(self):
        builder = self.stopped("diamonds")
        redone, refused = self.flip_and_cut(builder, self.names("manifest"), 10, 10)
        self.assertEqual(redone, 0, "a manifest that is damaged was trusted")
        self.assertEqual(refused, 20)


    def test_while_the_build_goes_on(self):
        """Scratch is flipped or cut under a build that hangs at the first record of a phase: what it reads then is not
        taken for what was written."""
        for scheme, options in SCHEMES.items():
            builder = self.builder(scheme, [self.statue(20000)], options)
            events = faults.moments_of(self.make_reference(builder))
            found = 0
            phases = [event for event in events if event.endswith(".task")]
            for number, event in enumerate(["part", *self.random.sample(phases, 8)]):
                what = f"{scheme}: {event}"
                run = builder.start(fault=Fault(event, 1, "after", str(-signal.SIGSTOP)))
                wait_until(lambda run=run: state_of(run.process.pid) == "T")
                self.damage_spools(builder.scratch, is_cut=number % 2 == 1)
                run.process.send_signal(signal.SIGCONT)
                if run.wait().status == program.OK:
                    self.assertTrue(self.is_right(builder), what)
                else:
                    found += 1
                    self.assertEqual(run.status, faults.IO, f"{what}: {run}")
                    self.assertEqual(len(run.errors), 1, f"{what}: {run}")
                    self.assertRegex(run.errors[0], "spool: damaged scratch record at byte [0-9]+: expected ", what)
                    self.assertFalse(os.path.exists(builder.output), what)
                    self.assert_resumes(builder, what)
                builder.clear()
            self.assertGreater(found, 3, scheme)

    def damage_spools(self, scratch, is_cut):
        for folder, _, names in os.walk(scratch):
            for path in (os.path.join(folder, name) for name in names if name.endswith(".spool")):
                size = os.path.getsize(path)
                if is_cut:
                    os.truncate(path, size // 2)
                    continue
                with open(path, "r+b") as file:
                    file.seek(size // 2)
                    byte = file.read(1)
                    file.seek(size // 2)
                    file.write(bytes([byte[0] ^ 1]))


class Stale(faults.FaultTest):
    def test_scratch_of_another_build_is_refused(self):
        statue = self.statue(2000)
        builder = self.builder("other", [statue], SCHEMES["diamonds"])
        self.make_reference(builder)
        self.assertEqual(builder.run(fault=Fault("5.task", 1, "after", "-9")).status, -signal.SIGKILL)

        def check(status, texts, *options, **arguments):
            run = builder.run(*options, **arguments)
            self.assertEqual(run.status, status, str(run))
            self.assertEqual(len(run.errors), 1, str(run))
            for text in (builder.scratch, *texts):
                self.assertIn(text, run.errors[0])

        check(program.CANNOT_CREATE, ["continue it with --resume, or remove it"])
        check(program.USAGE, ["position_bits is 12 there, and 9 here", "repeat the command of that build, or remove"],
              "--resume", "--position-bits", 9)
        other = meshes.write_ply(self.path("other.ply"), meshes.tube(12, 8))
        check(program.USAGE, ["input 1 is ", "other.ply", "repeat the command"], "--resume", inputs=[other], ranks=2)
        with open(statue, "ab") as file:
            file.write(b" ")
        check(program.USAGE, ["input 1 is ", "bytes modified at", "repeat the command"], "--resume")

    def test_scratch_of_other_sources_is_refused(self):
        """A program whose name for its sources is another one: a copy, with that text changed."""
        builder = self.builder("sources", [self.statue(2000)], SCHEMES["diamonds"])
        reference = self.make_reference(builder)
        self.assertTrue(reference)
        report = self.path("report.json")
        self.assertEqual(builder.run("--report", report, fault=Fault("5.task", 1, "after", "-9")).status, -signal.SIGKILL)
        with open(report, encoding="utf-8") as file:
            told = json.load(file)["program"]
        self.assertIn(told["commit"], told["build"])
        with open(program.PROGRAM, "rb") as file:
            content = file.read()
        self.assertEqual(content.count(told["build"].encode()), 1)
        other = told["build"][:-4] + ("0000" if told["build"][-4:] != "0000" else "1111")
        with open(self.path("colossus"), "wb") as file:
            file.write(content.replace(told["build"].encode(), other.encode()))
        os.chmod(self.path("colossus"), 0o755)
        run = builder.run("--resume", program_file=self.path("colossus"))
        self.assertEqual(run.status, program.USAGE, str(run))
        self.assertEqual(len(run.errors), 1, str(run))
        for text in builder.scratch, f"build is {told['build']} there, and {other} here", "repeat the command of that build, or remove":
            self.assertIn(text, run.errors[0])
        self.assert_resumes(builder, "by the program that began it")

    def test_a_resumed_build_keeps_scratch_that_is_of_use(self):
        statue = self.statue(2000)
        builder = self.builder("kept", [statue], SCHEMES["blocks"])
        self.make_reference(builder)
        self.assertEqual(builder.run(fault=Fault("5.task", 1, "after", "-9")).status, -signal.SIGKILL)
        run = builder.run("--resume", "--dry-run")
        self.assertEqual(run.status, program.OK, str(run))
        os.rename(statue, statue + ".away")
        run = builder.run("--resume")
        self.assertEqual(run.status, program.BAD_DATA, str(run))
        os.rename(statue + ".away", statue)
        run = self.assert_resumes(builder, "the input is back")
        self.assertRegex(run.text("stdout"), "resume: requests: [1-9]")

    def test_of_two_that_resume_at_once_one_does(self):
        builder = self.builder("two", [self.statue(2000)], SCHEMES["diamonds"])
        self.make_reference(builder)
        self.assertEqual(builder.run(fault=Fault("5.task", 1, "after", "-9")).status, -signal.SIGKILL)
        # Its first rename is that of the folder which it takes over.
        first = builder.start("--resume", fault=Fault("rename", 1, "before", str(-signal.SIGSTOP)))
        wait_until(lambda: state_of(first.process.pid) == "T")
        second = builder.start("--resume", fault=Fault("8.task", 1, "after", str(-signal.SIGSTOP)))
        wait_until(lambda: state_of(second.process.pid) == "T")
        first.process.send_signal(signal.SIGCONT)
        self.assertEqual(first.wait().status, program.CANNOT_CREATE, str(first))
        self.assertIn("another build has just begun to use the scratch directory", first.errors[0])
        second.process.send_signal(signal.SIGCONT)
        self.assertEqual(second.wait().status, program.OK, str(second))
        self.assertTrue(self.is_right(builder))

    def test_scratch_that_vanishes_since_the_first_attempt_comes_to_its_end(self):
        builder = self.builder("vanishes", [self.statue(2000)], SCHEMES["diamonds"])
        self.make_reference(builder)
        first = builder.start(fault=Fault("8.task", 1, "after", str(-signal.SIGSTOP)))
        wait_until(lambda: state_of(first.process.pid) == "T")
        second = builder.start("--resume", fault=Fault("rename", 1, "before", str(-signal.SIGSTOP)))
        wait_until(lambda: state_of(second.process.pid) == "T")
        first.process.send_signal(signal.SIGCONT)
        self.assertEqual(first.wait().status, program.OK, str(first))
        second.process.send_signal(signal.SIGCONT)
        self.assertEqual(second.wait().status, program.OK, str(second))
        self.assertTrue(self.is_right(builder))
        self.assertEqual(os.listdir(os.path.dirname(builder.output)), ["statue.h5"])

    def test_an_input_that_changes_while_it_is_read(self):
        changes = {"grows": lambda size: size + 1, "shrinks": lambda size: size // 2, "is emptied": lambda size: 0}
        for what, new_size in changes.items():
            for event, n in (("1.task", 1), ("1.task", 2)):
                with self.subTest(what=what, event=event, n=n):
                    statue = self.statue(2000)
                    builder = self.builder(f"{what}_{n}", [statue], SCHEMES["diamonds"])
                    run = builder.start(fault=Fault(event, n, "before", str(-signal.SIGSTOP)))
                    wait_until(lambda run=run: state_of(run.process.pid) == "T")
                    os.truncate(statue, new_size(os.path.getsize(statue)))
                    run.process.send_signal(signal.SIGCONT)
                    run.wait()
                    self.assertEqual(run.status, program.BAD_DATA, str(run))
                    self.assertEqual(len(run.errors), 1, str(run))
                    self.assertIn(statue, run.errors[0])
                    self.assertEqual(os.listdir(os.path.dirname(builder.output)), [])

    def test_a_build_that_was_overtaken_spoils_nothing(self):
        """One that hangs, as on a file system, anywhere; the next attempt takes over; then the first one goes on: while
        the next one is at work, or after it has finished."""
        for scheme, options in SCHEMES.items():
            builder = self.builder(scheme, [self.statue(20000)], options)
            events = faults.moments_of(self.make_reference(builder))
            for event in self.random.sample(list(events), 12):
                fault = Fault(event, self.random.randint(1, events[event]), self.random.choice(["before", "half", "after"]),
                              str(-signal.SIGSTOP))
                self.check_overtaken(builder, fault, f"{scheme}: {fault}", list(events)[len(events) // 2])
                builder.clear()

    def test_ranks_that_outlive_mpirun_spoil_nothing(self):
        """mpirun is killed while all its ranks are stopped; they wake up while the next attempt is at work."""
        for scheme, options in SCHEMES.items():
            builder = self.builder(scheme, [self.statue(20000)], options)
            events = faults.moments_of(self.make_reference(builder))
            for event in self.random.sample([event for event in events if event != "rmdir"], 4):
                fault = Fault(event, self.random.randint(1, events[event]), self.random.choice(["before", "half", "after"]),
                              str(-signal.SIGSTOP), "ranks")
                what = f"{scheme}: {fault}"
                # The kernel would end ranks that are stopped and have lost their parent, but for this.
                first = builder.start(ranks=3, fault=fault, preexec=ignore_hangup)
                wait_until(lambda first=first: len(first.pids) == 3 and all(state_of(pid) == "T" for pid in first.pids))
                first.process.kill()
                first.wait()
                second = builder.start("--resume", fault=Fault("rename", 1, "before", str(-signal.SIGSTOP)))
                wait_until(lambda second=second: state_of(second.process.pid) == "T")
                for pid in first.pids:
                    if faults.is_alive(pid):
                        os.kill(pid, signal.SIGCONT)
                wait_until(lambda first=first: not any(map(faults.is_alive, first.pids)))
                self.assert_right_or_nothing(builder, what)
                second.process.send_signal(signal.SIGCONT)
                self.assertEqual(second.wait().status, program.OK, f"{what}: {second}")
                self.assertTrue(self.is_right(builder), what)
                builder.clear()

    def check_overtaken(self, builder, fault, what, middle):
        first = builder.start(fault=fault)
        wait_until(lambda: state_of(first.process.pid) == "T")
        second = builder.start("--resume", fault=Fault(middle, 1, "before", str(-signal.SIGSTOP)))
        wait_until(lambda: state_of(second.process.pid) in "TZ")
        is_before = self.random.random() < 0.5
        runs = [first, second] if is_before else [second, first]
        for run in runs:
            run.process.send_signal(signal.SIGCONT)
            run.wait()
            self.assert_right_or_nothing(builder, f"{what}; after {run}")
        self.assertEqual(second.status, program.OK, f"{what}: {second}")
        self.assertTrue(self.is_right(builder), what)
        if first.status != program.OK:
            self.assertEqual(first.status, faults.IO, f"{what}: {first}")
            self.assertEqual(len(first.errors), 1, f"{what}: {first}")
        self.assertEqual(os.listdir(os.path.dirname(builder.output)), ["statue.h5"], what)


if __name__ == "__main__":
    program.main()
