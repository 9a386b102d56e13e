"""The blocks scheme: views from any eye are closed, levels shrink to a quarter, the parent map is what it must be."""
import os
import random
import re

import check_closed
import eyes
import meshes
import program

EYES = int(os.environ.get("COLOSSUS_EYES", "16"))


class Blocks(program.ColossusTest):
    def blocks(self, scan, *options):
        container = self.build("blocks.h5", scan, options=("--scheme", "blocks", *options))
        self.assert_no_clefts(self.run_program("verify", container).stdout)
        return container

    def assert_no_clefts(self, report):
        """Density of triangles near borders of blocks, over the rest, of levels with enough triangles to tell."""
        for line in report.splitlines():
            level = re.fullmatch(r" *\d+ +\d+ +(\d+) +\d+ +\d+ +(\S+) +(\S+)", line)
            if level and int(level[1]) >= 5000:
                locked, earlier = (0.0 if cell == "-" else float(cell) for cell in level.groups()[1:])
                self.assertLess(locked, 1.8, report)
                self.assertLess(earlier, 1.15, report)

    def view(self, container, eye, kappa):
        output = self.path("view.ply")
        run = self.run_program("extract", container, "-o", output, "--eye=" + ",".join(repr(float(x)) for x in eye),
                               "--kappa", kappa)
        return check_closed.read_ply(output), run.stdout + run.stderr

    def least_kappa(self, container):
        """The usage error for a value that is too small prints the smallest legal one."""
        run = self.run_program("extract", container, "-o", self.path("view.ply"), "--eye=0,0,0", "--kappa", 1.0,
                               status=program.USAGE)
        return float(re.findall(r"[0-9]+\.[0-9]+", run.stderr)[-1])

    def assert_views_closed(self, scan, *options, seed):
        container = self.blocks(scan, *options)
        mesh = check_closed.weld(check_closed.read_ply(scan))
        least = self.least_kappa(container)
        self.assertLess(least, 2.0)
        mixed = 0
        print(f"seed {seed}")
        for eye in eyes.positions(mesh.points, eyes.mean_edge(mesh), EYES, random.Random(seed)):
            for kappa in (least, 2.0, 3.5):
                cut, said = self.view(container, eye, kappa)
                census = check_closed.Census(cut)
                self.assertGreater(len(census.mesh.triangles), 0)
                self.assertTrue(census.is_closed, f"eye {eye}, kappa {kappa}: {census}")
                mixed += kappa == 2.0 and eyes.holds_several_levels(said)
        print(f"{mixed} of {EYES} views at kappa 2 hold several levels")
        self.assertGreater(2 * mixed, EYES)
        return container

    def assert_levels(self, container, scan_triangles):
        levels = self.info(container)["levels"]
        for level in levels:
            self.assertTrue(check_closed.Census(self.extract(container, "--level", level["level"])).is_closed)
        self.assertLess(sum(level["triangles"] for level in levels), 1.4 * scan_triangles)

    def test_statue(self):
        statue = self.path("statue.ply")
        self.run_program("synth", "-o", statue, "--triangles", 150000, "--seed", 5)
        container = self.assert_views_closed(statue, "--leaf-triangles", 1000, seed=1)
        self.assert_levels(container, 150000)
        self.run_program("verify", container, "--against", statue)

    def test_long_edges(self):
        """A box among a fine torus: its edges are longer than the cubes allow."""
        box = meshes.tube(4, 4)
        torus = meshes.tube(300, 150, noise=0.003)
        box.points[:] = 5 + 2 * box.points
        scan = meshes.write_ply(self.path("scan.ply"), meshes.join(box, torus))
        container = self.blocks(scan, "--leaf-triangles", 1000)
        info = self.info(container)
        self.assertGreater(info["counts"]["split_edges"], 0)
        self.assertTrue(check_closed.Census(self.extract(container, "--level", 99)).is_closed)
        # Middles are rounded once more; where bits are few, this is what a leaf's error must know.
        self.run_program("verify", self.blocks(scan, "--leaf-triangles", 1000, "--position-bits", 8), "--against", scan)

    def test_options(self):
        torus = meshes.write_ply(self.path("torus.ply"), meshes.tube(60, 40, noise=0.01))
        self.assertEqual(len(self.info(self.blocks(torus, "--levels", 3))["levels"]), 4)
        self.blocks(torus, "--levels", 4, "--block-size", 8, "--position-bits", 8)
        for wrong in (("--scheme", "tiles"), ("--scheme", "blocks", "--block-size", 6), ("--levels", 2),
                      ("--scheme", "blocks", "--levels", 15), ("--color-weight", 1),
                      *(("--scheme", "blocks", f"--color-weight={weight}") for weight in (-1, "nan", "inf"))):
            self.run_program("build", torus, "-o", self.path("no.h5"), *wrong, status=program.USAGE)
            self.assertFalse(os.path.exists(self.path("no.h5")))

    def test_scans(self):
        for name, seed in (("armadillo.ply", 2), ("gargo.ply", 3)):
            scan = self.shared_scan(name)
            container = self.assert_views_closed(scan, "--leaf-triangles", 1000, seed=seed)
            self.run_program("verify", container, "--against", scan)


if __name__ == "__main__":
    program.main()
