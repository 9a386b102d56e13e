"""Outputs that are inputs or each other, links, devices, pipes; inputs that are no files; scratch folders."""
import itertools
import json
import os
import resource
import signal
import socket
import stat
import subprocess
import threading

import meshes
import program
from files import BAD_DATA, CANNOT_CREATE, IO, MOST_SECONDS, NO_RESOURCES, RANKS, USAGE, FilesTest


def limit_file_size():
    resource.setrlimit(resource.RLIMIT_FSIZE, (200000, 200000))


class Pairs(FilesTest):
    """Each option that names a file to write, against each other name of the command."""

    def setUp(self):
        super().setUp()
        os.mkdir(self.path("sub"))
        self.count = 0

    def spellings(self, name):
        """Other names of what lies, or will lie, under this one."""
        yield from (name, f"./{name}", f"sub/../{name}", self.path(name))
        self.count += 1
        links = [f"link{self.count}", f"sub/chain{self.count}"]
        os.symlink(name, self.path(links[0]))
        os.symlink(f"../{links[0]}", self.path(links[1]))
        yield from links
        if os.path.isfile(self.path(name)):
            os.link(self.path(name), self.path(f"hard{self.count}"))
            yield f"hard{self.count}"

    def build_arguments(self, names):
        return ["build", "in.ply", "@list.txt", *(word for option, name in names.items() for word in (option, name))]

    OUTPUTS = {"-o": "o.h5", "--scratch": "s", "--report": "r.json", "--status": "st.json"}

    def prepare_list(self):
        meshes.write_ply(self.path("member.ply"), meshes.tube(8, 6))
        self.write("list.txt", b"member.ply\n")

    def test_of_a_build_with_its_inputs(self):
        self.prepare_list()
        for option, thing in itertools.product(self.OUTPUTS, ("in.ply", "list.txt", "member.ply")):
            for spelling in self.spellings(thing):
                self.assert_spares(*self.build_arguments({**self.OUTPUTS, option: spelling}), texts=(option, thing))
        for option in self.OUTPUTS.keys() - {"--scratch"}:
            for thing in "in.ply", "list.txt", "member.ply":
                # Written as NAME.part, which is the input.
                os.link(self.path(thing), self.path(f"{thing}.copy.part"))
                self.assert_spares(*self.build_arguments({**self.OUTPUTS, option: f"{thing}.copy"}), texts=(thing,))
                os.remove(self.path(f"{thing}.copy.part"))

    def test_of_a_build_with_each_other(self):
        self.prepare_list()
        for has_files in False, True:
            for first, second in itertools.permutations(self.OUTPUTS, 2):
                name = self.OUTPUTS[first]
                if has_files and first != "--scratch":
                    self.write(name)
                for spelling in self.spellings(name):
                    self.assert_spares(*self.build_arguments({**self.OUTPUTS, second: spelling}), texts=(first, second))
                if first != "--scratch":
                    self.assert_spares(*self.build_arguments({**self.OUTPUTS, second: f"{name}.part"}))
                    for spelling in self.spellings(f"{name}.part"):
                        self.assert_spares(*self.build_arguments({**self.OUTPUTS, second: spelling}))

    def test_of_a_build_with_scratch(self):
        """What is the scratch folder, lies in it, or contains it."""
        self.prepare_list()
        default = {option: name for option, name in self.OUTPUTS.items() if option != "--scratch"}
        for option in "--report", "--status":
            self.assert_spares(*self.build_arguments({**default, option: "o.h5.scratch"}))
            self.assert_spares(*self.build_arguments({**self.OUTPUTS, option: "s/file"}))
        self.assert_spares(*self.build_arguments({**self.OUTPUTS, "-o": "s/o.h5"}))
        os.mkdir(self.path("s"))
        for option in default:
            for name in "s/file", "s/../s/file", "link/file":
                if not os.path.lexists(self.path("link")):
                    os.symlink("s", self.path("link"))
                self.assert_spares(*self.build_arguments({**self.OUTPUTS, option: name}))
        os.link(self.path("in.ply"), self.path("o.h5.scratch"))
        self.assert_spares("build", "in.ply", "-o", "o.h5")
        for folder in ".", "sub/..", self.folder, "/":
            self.assert_spares("build", "in.ply", "-o", "o.h5", "--scratch", folder)
            self.assert_spares("build", "in.ply", "-o", "o.h5", "--scratch", folder, "--resume")

    def test_of_a_build_on_several_ranks(self):
        self.prepare_list()
        for names in ({"-o": "in.ply"}, {"--status": "./list.txt"}, {"--report": "member.ply"}, {"--report": "o.h5.part"}):
            run = self.assert_spares(*self.build_arguments({**self.OUTPUTS, **names}), ranks=3)
            self.assertEqual(run.stderr.count(b"colossus: error"), 1, run.stderr)

    def test_of_the_other_commands(self):
        self.container()
        self.prepare_list()
        for name in self.spellings("c.h5"):
            self.assert_spares("extract", "c.h5", "--level", 0, "-o", name, texts=("the container", "-o"))
            self.assert_spares("extract", name, "--level", 0, "-o", "c.h5", texts=("the container", "-o"))
        os.link(self.path("c.h5"), self.path("x.part"))
        self.assert_spares("extract", "c.h5", "--level", 0, "-o", "x")
        for base, thing in (("in.ply", "in.ply"), ("@list.txt", "list.txt"), ("@list.txt", "member.ply")):
            for name in self.spellings(thing):
                self.assert_spares("synth", "--triangles", 10, "--base", base, "-o", name, texts=(thing, "-o"))
        os.link(self.path("in.ply"), self.path("y.part"))
        self.assert_spares("synth", "--triangles", 10, "--base", "in.ply", "-o", "y")
        for arguments in (["info", "c.h5"], ["info", "--json", "c.h5"], ["verify", "c.h5"],
                          ["verify", "c.h5", "--against", "in.ply"]):
            self.assert_spares(*arguments, status=program.OK)

    def test_a_pipe_of_the_shell_into_what_is_read(self):
        self.container()
        with open(self.path("c.h5"), "ab") as out:
            self.assert_spares("extract", "c.h5", "--level", 0, "-o", "/dev/stdout", stdout=out)


class Outputs(FilesTest):
    def test_links_are_followed(self):
        os.mkdir(self.path("far"))
        for name in "o.h5", "r.json", "st.json":
            os.symlink(f"far/{name}", self.path(name))
        os.symlink("o.h5", self.path("again.h5"))
        for ranks in RANKS:
            self.run_in_folder("build", "in.ply", "-o", "again.h5", "--report", "r.json", "--status", "st.json", ranks=ranks)
            self.assertEqual(sorted(os.listdir(self.path("far"))), ["o.h5", "r.json", "st.json"])
            self.assertTrue(all(os.path.islink(self.path(name)) for name in ("o.h5", "r.json", "st.json", "again.h5")))
        os.symlink("far/cut.ply", self.path("cut.ply"))
        self.run_in_folder("extract", "again.h5", "--level", 0, "-o", "cut.ply")
        os.symlink(self.path("far/synth.ply"), self.path("synth.ply"))
        self.run_in_folder("synth", "--triangles", 20, "-o", "synth.ply")
        self.assertEqual(len(os.listdir(self.path("far"))), 5)
        os.symlink("circle", self.path("circle"))
        for arguments in self.commands_that_write("circle"):
            self.assert_spares(*arguments, status=CANNOT_CREATE, texts=("circle",))

    def commands_that_write(self, name):
        return (["build", "in.ply", "-o", name], ["build", "in.ply", "-o", "o", "--scratch", name],
                ["build", "in.ply", "-o", "o", "--status", name], ["build", "in.ply", "-o", "o", "--report", name],
                ["extract", self.path("far/o.h5"), "--level", 0, "-o", name], ["synth", "--triangles", 20, "-o", name])

    def test_a_part_that_others_see_is_left_to_them(self):
        """An old NAME.part is replaced; what it leads to under other names is not."""
        names = ("o.h5", "r.json", "st.json", "cut.ply", "synth.ply")
        for name in names:
            self.write(f"other {name}")
            os.link(self.path(f"other {name}"), self.path(f"{name}.part"))
        self.run_in_folder("build", "in.ply", "-o", "o.h5", "--report", "r.json", "--status", "st.json")
        self.run_in_folder("extract", "o.h5", "--level", 0, "-o", "cut.ply")
        self.run_in_folder("synth", "--triangles", 20, "-o", "synth.ply")
        for name in names:
            self.assertEqual(self.tree()[self.path(f"other {name}")][1], b"precious", name)
        self.assertFalse([name for name in os.listdir(self.folder) if name.endswith(".part")])

    def test_names_that_cannot_be(self):
        os.mkdir(self.path("far"))
        self.container("far/o.h5")
        os.mkdir(self.path("folder"))
        self.write("folder/file")
        for name in "folder", "folder/", ".", "none/file", "in.ply/file", "n" * 252, "n" * 300, "d/" * 2500:
            for arguments in self.commands_that_write(name):
                if "--scratch" in arguments and name in (".", "n" * 252):
                    continue  # contains the input; is short enough
                self.assert_spares(*arguments, status=CANNOT_CREATE)
        os.mkdir(self.path("folder.part"))
        self.assert_spares("build", "in.ply", "-o", "folder.part/../folder", status=CANNOT_CREATE)
        os.mkdir(self.path("x.part"))
        for arguments in self.commands_that_write("x"):
            if "--scratch" not in arguments:
                self.assert_spares(*arguments, status=CANNOT_CREATE, texts=("x.part", "a folder"))
        self.run_in_folder("build", "in.ply", "-o", "n" * 247)
        for arguments in self.commands_that_write(""):
            self.assert_spares(*arguments, status=USAGE)

    def test_devices(self):
        null, full = self.make_device("null", 3), self.make_device("full", 7)
        self.container()
        # Where a regular file is needed.
        os.mkfifo(self.path("pipe"))
        with socket.socket(socket.AF_UNIX) as server:
            server.bind(self.path("socket"))
            for name in null, "pipe", "socket":
                for option in ["-o"], ["-o", "o.h5", "--status"], ["-o", "o.h5", "--scratch"]:
                    self.assert_spares("build", "in.ply", *option, name, texts=(name,))
                self.assert_spares("synth", "--triangles", 20, "-o", name, texts=(name,))
            self.assert_spares("extract", "c.h5", "--level", 0, "-o", "socket")
            self.assert_spares("build", "in.ply", "-o", "o.h5", "--report", "socket")
        # Where it may be written to.
        before = self.tree()
        self.run_in_folder("extract", "c.h5", "--level", 0, "-o", null)
        run = self.run_in_folder("extract", "c.h5", "--level", 0, "-o", full, status=NO_RESOURCES)
        self.assertIn(b"No space left", run.stderr)
        self.assertEqual(self.tree(), before)
        for ranks in RANKS:
            self.run_in_folder("build", "in.ply", "-o", "o.h5", "--report", null, ranks=ranks)
            run = self.run_in_folder("build", "in.ply", "-o", "o.h5", "--report", full, ranks=ranks, status=NO_RESOURCES)
            self.assertIn(b"the build itself is done", run.stderr)
            self.assertEqual({**self.tree(), self.path("o.h5"): None}, {**before, self.path("o.h5"): None})
        # What went wrong first counts.
        self.write("bad.ply", b"ply\n")
        self.run_in_folder("build", "bad.ply", "-o", "p.h5", "--report", full, status=BAD_DATA)

    def read_pipe(self, name):
        """A thread that reads the pipe to its end, and a list that gets what it has read."""
        found = []

        def read():
            with open(self.path(name), "rb") as file:
                found.append(file.read())

        thread = threading.Thread(target=read)
        thread.start()
        return thread, found

    def test_pipes(self):
        self.container()
        os.mkfifo(self.path("pipe"))
        self.run_in_folder("extract", "c.h5", "--level", 0, "-o", "cut.ply")
        thread, found = self.read_pipe("pipe")
        self.run_in_folder("extract", "c.h5", "--level", 0, "-o", "pipe")
        thread.join()
        self.assertEqual(found[0], self.tree()[self.path("cut.ply")][1])
        for ranks in RANKS:
            thread, found = self.read_pipe("pipe")
            self.run_in_folder("build", "in.ply", "-o", "o.h5", "--report", "pipe", ranks=ranks)
            thread.join()
            self.assertEqual(json.loads(found[0])["state"], "done")
        self.assertTrue(stat.S_ISFIFO(os.stat(self.path("pipe")).st_mode))

    def test_a_report_that_nobody_reads(self):
        """The build waits for a reader, and hears a request to stop."""
        os.mkfifo(self.path("pipe"))
        for sent in signal.SIGTERM, signal.SIGUSR1:
            with subprocess.Popen(self.command("build", "in.ply", "-o", "o.h5", "--report", "pipe"), cwd=self.folder,
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE) as run:
                while b"waiting for a reader" not in run.stdout.readline():
                    self.assertIsNone(run.poll())
                run.send_signal(sent)
                _, errors = run.communicate(timeout=MOST_SECONDS)
                self.assertEqual(run.returncode, IO, errors)
                self.assertIn(b"asked to stop", errors)
        self.assertEqual(sorted(os.listdir(self.folder)), ["in.ply", "o.h5", "pipe"])

    def test_stdout(self):
        self.container()
        self.run_in_folder("extract", "c.h5", "--level", 0, "-o", "cut.ply")
        cut = self.tree()[self.path("cut.ply")][1]
        for name in "/dev/stdout", "/proc/self/fd/1", "/dev/fd/1":
            run = self.run_in_folder("extract", "c.h5", "--level", 0, "-o", name)
            self.assertEqual(run.stdout, cut)
            self.assertIn(b"vertices", run.stderr)
            with open(self.path("all"), "wb") as out:  # as in { echo before; colossus ...; } > all
                out.write(b"before\n")
                out.flush()
                self.run_in_folder("extract", "c.h5", "--level", 0, "-o", name, stdout=out)
            self.assertEqual(self.tree()[self.path("all")][1], b"before\n" + cut)
        report = self.run_in_folder("build", "in.ply", "-o", "o.h5", "--report", "/dev/stdout").stdout
        self.assertEqual(json.loads(report)["state"], "done")
        for arguments in (["build", "in.ply", "-o", "/dev/stdout"], ["synth", "-o", "/dev/stdout"],
                          ["build", "in.ply", "-o", "p.h5", "--status", "/dev/fd/1"]):
            with open(self.path("all"), "ab") as out:
                self.assert_spares(*arguments, stdout=out)
        for name in "/dev/fd/0", "/dev/fd/77", "/proc/x":
            with open(self.path("in.ply"), "rb") as file:
                self.assert_spares("extract", "c.h5", "--level", 0, "-o", name, status=CANNOT_CREATE, stdin=file)

    def test_a_reader_that_goes_away(self):
        self.container()
        for arguments in (["extract", "c.h5", "--level", 0, "-o", "/dev/stdout"], ["info", "c.h5"], ["verify", "c.h5"],
                          ["build", "in.ply", "-o", "o.h5", "--report", "/dev/stdout"]):
            read_end, write_end = os.pipe()
            os.close(read_end)
            run = self.run_in_folder(*arguments, status=IO, stdout=write_end)
            os.close(write_end)
            self.assertIn(b"Broken pipe", run.stderr)


class Inputs(FilesTest):
    def assert_refused(self, name, text, **more):
        """As each kind of input, without anything left."""
        self.write("list.txt", os.fsencode(name) + b"\nin.ply\n")
        for arguments in (["build", name, "-o", "o.h5"], ["build", "in.ply", name, "-o", "o.h5"],
                          ["build", f"@{name}", "-o", "o.h5"], ["build", "@list.txt", "-o", "o.h5"],
                          ["info", name], ["verify", name], ["extract", name, "--level", 0, "-o", "cut.ply"],
                          ["verify", "c.h5", "--against", name], ["synth", "--triangles", 20, "--base", name, "-o", "s.ply"]):
            run = self.assert_spares(*arguments, status=BAD_DATA, **more)
            self.assertIn(text, run.stderr.decode(), arguments)

    def test_other_than_regular_files(self):
        self.container()
        os.mkfifo(self.path("pipe.ply"))
        os.mkdir(self.path("folder.ply"))
        os.symlink("pipe.ply", self.path("link.ply"))
        os.symlink("nothing", self.path("dangling.ply"))
        os.symlink("circle.ply", self.path("circle.ply"))
        with socket.socket(socket.AF_UNIX) as server:
            server.bind(self.path("socket.ply"))
            for name, text in (("pipe.ply", "is a pipe"), ("link.ply", "is a pipe"), ("folder.ply", "is a folder"),
                               ("socket.ply", "is a socket"), ("dangling.ply", "No such file"),
                               ("circle.ply", "Too many levels")):
                self.assert_refused(name, text)
        for ranks in RANKS:
            self.assert_spares("build", "pipe.ply", "-o", "o.h5", ranks=ranks, status=BAD_DATA)

    def test_devices(self):
        self.container()
        self.assert_refused(self.make_device("null", 3), "is a device")

    def test_descriptors(self):
        """Even where they are a regular file: another rank has another stdin."""
        self.container()
        os.symlink("/dev/stdin", self.path("link.ply"))
        for name in "/dev/stdin", "/dev/fd/0", "/proc/self/fd/0", "link.ply":
            with open(self.path("in.ply"), "rb") as file:
                self.assert_refused(name, "descriptor", stdin=file)


class Scratch(FilesTest):
    def test_an_empty_folder_is_used_and_kept(self):
        for ranks in RANKS:
            for name, options in (("s", ["--scratch", "s"]), ("s", ["--scratch", "s", "--resume"]), ("o.h5.scratch", [])):
                os.mkdir(self.path(name), 0o700)
                inode = os.stat(self.path(name)).st_ino
                self.run_in_folder("build", "in.ply", "-o", "o.h5", *options, ranks=ranks)
                self.assertEqual(os.stat(self.path(name)).st_ino, inode)
                os.rmdir(self.path(name))  # it is empty

    def test_after_it_was_resumed(self):
        self.run_program("synth", "--triangles", 20000, "-o", self.path("statue.ply"))
        for is_there, ranks in itertools.product((True, False), RANKS):
            if is_there:
                os.mkdir(self.path("s"))
            build = ["build", "statue.ply", "-o", "o.h5", "--scratch", "s", "--leaf-triangles", 1000]
            for options in [], ["--resume"]:
                self.run_in_folder(*build, *options, preexec_fn=limit_file_size, status=NO_RESOURCES)
                self.assertTrue(os.listdir(self.path("s")))
            self.run_in_folder(*build, status=CANNOT_CREATE)
            self.run_in_folder(*build, "--resume", ranks=ranks)
            self.assertEqual(os.path.isdir(self.path("s")), is_there)
            if is_there:
                os.rmdir(self.path("s"))

    def test_a_build_that_fails_empties_it(self):
        self.write("bad.ply", b"ply\n")
        os.mkdir(self.path("s"))
        self.assert_spares("build", "bad.ply", "-o", "o.h5", "--scratch", "s", status=BAD_DATA)

    def test_a_folder_with_something_in_it_is_refused(self):
        os.mkdir(self.path("s"))
        self.write("s/file")
        for options in [], ["--resume"]:
            self.assert_spares("build", "in.ply", "-o", "o.h5", "--scratch", "s", *options, status=CANNOT_CREATE)


if __name__ == "__main__":
    program.main()
