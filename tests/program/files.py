"""Runs the program beside files that it must spare. See files_test.py and files_names_test.py."""
import os
import stat
import subprocess

import meshes
import program

USAGE, BAD_DATA, NO_RESOURCES, CANNOT_CREATE, IO = 2, 65, 69, 73, 74
MOST_SECONDS = 60
RANKS = (0, 3)


class FilesTest(program.ColossusTest):
    def setUp(self):
        super().setUp()
        meshes.write_ply(self.path("in.ply"), meshes.tube(12, 8))

    def command(self, *arguments, ranks=0):
        launcher = os.environ["COLOSSUS_MPIEXEC"].split(";") + [str(ranks)] if ranks else []
        return [*launcher, program.PROGRAM, *(a if isinstance(a, bytes) else str(a) for a in arguments)]

    def run_in_folder(self, *arguments, ranks=0, status=program.OK, stdout=subprocess.PIPE, environment=None, **more):
        """Names are relative to the test's folder; stdout and stderr are bytes. Any of several statuses is right."""
        run = subprocess.run(self.command(*arguments, ranks=ranks), cwd=self.folder, stdout=stdout,
                             stderr=subprocess.PIPE, check=False, timeout=MOST_SECONDS,
                             env=dict(os.environ, **(environment or {})), **{"stdin": subprocess.DEVNULL, **more})
        statuses = status if isinstance(status, tuple) else (status,)
        self.assertIn(run.returncode, statuses, f"{arguments}\n{run.stdout}{run.stderr}")
        return run

    def tree(self):
        """All that lies in the test's folder: kind, and bytes or the target of a link."""
        found = {}
        for folder, folders, files in os.walk(self.folder):
            for name in folders + files:
                path = os.path.join(folder, name)
                mode = os.lstat(path).st_mode
                content = None
                if stat.S_ISLNK(mode):
                    content = os.readlink(path)
                elif stat.S_ISREG(mode):
                    with open(path, "rb") as file:
                        content = file.read()
                found[path] = (stat.S_IFMT(mode), content)
        return found

    def assert_spares(self, *arguments, status=USAGE, texts=(), **more):
        before = self.tree()
        run = self.run_in_folder(*arguments, status=status, **more)
        after = self.tree()
        self.assertEqual(sorted(after), sorted(before), f"{arguments}: {run.stderr}")
        self.assertEqual(after, before, f"{arguments}: {run.stderr}")
        for text in texts:
            self.assertIn(text, run.stderr.decode(), arguments)
        return run

    def write(self, name, data=b"precious"):
        with open(self.path(name), "wb") as file:
            file.write(data)
        return name

    def container(self, name="c.h5"):
        self.run_in_folder("build", "in.ply", "-o", name)
        return name

    def make_device(self, name, minor):
        try:
            os.mknod(self.path(name), 0o666 | stat.S_IFCHR, os.makedev(1, minor))
            os.close(os.open(self.path(name), os.O_WRONLY))
        except OSError as error:
            self.skipTest(f"a device node cannot be made here: {error}")
        return name
