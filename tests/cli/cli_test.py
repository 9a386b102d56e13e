"""The program's exit statuses and messages, and faults planted into containers."""
import math
import os
import re
import shutil

import meshes
import program


class CommandLine(program.ColossusTest):
    def torus(self):
        return meshes.write_ply(self.path("torus.ply"), meshes.tube(60, 30))

    def test_usage_errors(self):
        torus, output = self.torus(), self.path("torus.h5")
        for arguments in ([], ["carve"], ["build"], ["build", torus], ["build", "-o", output],
                          ["build", torus, "-o", output, "--no-such-option"],
                          ["build", torus, "-o", output, "--leaf-triangles", "many"],
                          ["build", torus, "-o", output, "--leaf-triangles", 3],
                          ["build", torus, "-o", output, "--position-bits", 7],
                          ["build", torus, "-o", output, "--position-bits", 17],
                          ["build", torus, "-o", output, "--tolerance", 0],
                          ["build", torus, "-o", output, "--tolerance", 0.1, "--position-bits", 9],
                          ["info"], ["verify"], ["extract", output], ["extract", output, "-o", self.path("cut.ply")],
                          ["extract", output, "-o", self.path("cut.ply"), "--level", 1, "--error", 2],
                          ["extract", output, "-o", self.path("cut.ply"), "--level", -1],
                          ["extract", output, "-o", self.path("cut.ply"), "--error", -1],
                          ["synth"], ["synth", "-o", self.path("statue.ply"), "--triangles", 0]):
            run = self.run_program(*arguments, status=program.USAGE)
            self.assertNotEqual(run.stderr + run.stdout, "", arguments)
        self.assertEqual(os.listdir(self.folder), ["torus.ply"], "nothing is left behind")

    def test_usage_errors_of_eyes(self):
        torus, view = self.torus(), self.path("view.ply")
        for scheme, kappas in (("diamonds", (0, -1, "nan", "inf")), ("blocks", (0, 1, -1, "nan", "inf"))):
            container = self.build(f"{scheme}.h5", torus, options=("--scheme", scheme, "--leaf-triangles", 300))
            for arguments in (["--eye=0,0"], ["--eye=0,0,0,0"], ["--eye=0,0,near"], ["--kappa", 2],
                              ["--eye=0,0,0", "--level", 1], ["--eye=nan,0,0"], ["--eye=0,0,inf"],
                              *(["--eye=0,0,0", f"--kappa={kappa}"] for kappa in kappas)):
                run = self.run_program("extract", container, "-o", view, *arguments, status=program.USAGE)
                self.assertNotEqual(run.stderr + run.stdout, "", arguments)
        self.assertEqual(sorted(os.listdir(self.folder)), ["blocks.h5", "diamonds.h5", "torus.ply"])

    def test_too_small_a_kappa_of_blocks_prints_the_smallest_legal_one(self):
        container = self.build("blocks.h5", self.torus(), options=("--scheme", "blocks", "--leaf-triangles", 300))
        look = ("extract", container, "-o", self.path("view.ply"), "--eye=0,0,0", "--kappa")
        sigma = self.info(container)["parameters"]["sigma0"]
        run = self.run_program(*look, repr(1 + 3 * sigma), status=program.USAGE)
        least = float(re.search(r"1 \+ 3 sigma0, that is at least ([0-9.]+)", run.stderr)[1])
        self.assertEqual(least, math.nextafter(1 + 3 * sigma, math.inf))
        self.run_program(*look, repr(least))

    def test_help_and_version(self):
        self.assertIn("build", self.run_program("--help").stdout)
        self.assertRegex(self.run_program("--version").stdout, r"^\d+\.\d+\.\d+\n$")
        for command in ("build", "info", "verify", "extract", "synth"):
            self.assertIn("--help", self.run_program(command, "--help").stdout)

    def test_output_that_cannot_be_created(self):
        torus = self.torus()
        for ranks in (0, 3):
            run = self.run_program("build", torus, "-o", self.path("no/such/folder/torus.h5"), ranks=ranks,
                                   status=program.CANNOT_CREATE)
            self.assertIn("no/such/folder", run.stderr)
        container = self.build("torus.h5", torus)
        self.run_program("extract", container, "--level", 0, "-o", self.path("no/cut.ply"), status=program.CANNOT_CREATE)
        self.run_program("synth", "-o", self.path("no/statue.ply"), status=program.CANNOT_CREATE)
        os.mkdir(self.path("folder.h5"))
        self.run_program("build", torus, "-o", self.path("folder.h5"), status=program.CANNOT_CREATE)
        self.assertEqual(sorted(os.listdir(self.folder)), ["folder.h5", "torus.h5", "torus.ply"])

    def test_missing_and_foreign_containers(self):
        torus = self.torus()
        for path in (self.path("missing.h5"), torus, self.folder):
            for command in (["info"], ["verify"], ["extract", "--level", 0, "-o", self.path("cut.ply")]):
                run = self.run_program(command[0], path, *command[1:], status=program.BAD_DATA)
                self.assertIn(path, run.stderr)
        self.assertEqual(os.listdir(self.folder), ["torus.ply"])

    def test_textures_are_refused_unless_dropped(self):
        with open(self.path("textured.obj"), "w", encoding="utf-8") as file:
            file.write("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n")
        run = self.run_program("build", self.path("textured.obj"), "-o", self.path("out.h5"), status=program.BAD_DATA)
        self.assertIn("--drop-textures", run.stderr)
        self.build("out.h5", self.path("textured.obj"), options=("--drop-textures",))

    def test_too_few_triangles_asked_for_gives_the_root_with_a_warning(self):
        container = self.build("torus.h5", self.torus(), options=("--leaf-triangles", 300))
        run = self.run_program("extract", container, "--triangles", 1, "-o", self.path("cut.ply"))
        self.assertIn("warning", run.stderr)

    def test_a_second_build_replaces_the_first(self):
        first = self.build("torus.h5", self.torus())
        size = os.path.getsize(first)
        self.build("torus.h5", self.torus(), options=("--position-bits", 8))
        self.assertNotEqual(os.path.getsize(first), size)
        self.assertEqual(sorted(os.listdir(self.folder)), ["torus.h5", "torus.ply"])


class PlantedFaults(program.ColossusTest):
    def test_any_changed_byte_of_a_chunk_is_found(self):
        import h5py  # the offsets of chunks, told by a program that is not ours

        torus = meshes.write_ply(self.path("torus.ply"), meshes.tube(120, 60, noise=0.01))
        container = self.build("torus.h5", torus, options=("--leaf-triangles", 500))
        with h5py.File(container) as file:
            nodes = file["nodes"][:]
        self.assertGreater(len(nodes), 10)
        damaged = self.path("damaged.h5")
        for node in nodes[:: max(1, len(nodes) // 12)]:
            for share in (0.0, 0.4, 0.999):
                shutil.copyfile(container, damaged)
                offset = int(node["offset"]) + int(share * int(node["stored_bytes"]))
                with open(damaged, "r+b") as file:
                    file.seek(offset)
                    byte = file.read(1)[0]
                    file.seek(offset)
                    file.write(bytes([byte ^ 0x10]))
                run = self.run_program("verify", damaged, status=program.BAD_DATA)
                self.assertIn(f"level {node['level']}", run.stdout + run.stderr)

    def test_truncated_containers_are_refused(self):
        container = self.build("torus.h5", meshes.write_ply(self.path("torus.ply"), meshes.tube(40, 20)))
        with open(container, "rb") as file:
            data = file.read()
        for size in (0, 7, 100, 2000, len(data) // 2, len(data) - 1):
            with open(self.path("cut.h5"), "wb") as file:
                file.write(data[:size])
            for command in (("info",), ("verify",), ("extract", "--level", 9, "-o", self.path("cut.ply"))):
                self.run_program(command[0], self.path("cut.h5"), *command[1:], status=program.BAD_DATA)


if __name__ == "__main__":
    program.main()
