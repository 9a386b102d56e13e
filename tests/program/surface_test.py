"""Nothing of the surface is lost in silence: opposite triangles, things thinner than the lattice, crumbs and wires, far
corners, tolerances, collinear triangles, dust. What a build cannot keep it refuses, and says why."""
import os
import re

import numpy as np

import check_closed
import distances
import meshes
import program
from check_closed import Census, Mesh

SCHEMES = ("diamonds", "blocks")


def turned_over(mesh):
    return Mesh(mesh.points, mesh.triangles[:, ::-1])


def soup(mesh):
    """Three vertices for every triangle."""
    return Mesh(mesh.points[mesh.triangles].reshape(-1, 3), np.arange(3 * len(mesh.triangles)).reshape(-1, 3))


def plate(cells, thickness):
    """A closed square plate: two sheets and their rims."""
    below = turned_over(meshes.grid(cells, (1, 0, 0), (0, 1, 0)))
    above = meshes.grid(cells, (1, 0, 0), (0, 1, 0), (0, 0, thickness))
    count = len(below.points)
    row = lambda i, j: i * (cells + 1) + j
    rim = ([row(0, j) for j in range(cells)] + [row(i, cells) for i in range(cells)]
           + [row(cells, j) for j in range(cells, 0, -1)] + [row(i, 0) for i in range(cells, 0, -1)])
    sides = [t for a, b in zip(rim, rim[1:] + rim[:1]) for t in ((a, b, b + count), (a, b + count, a + count))]
    both = meshes.join(below, above)
    return Mesh(both.points, np.concatenate([both.triangles, sides]))


def wire(steps, radius, length=3.0):
    """A closed tube of four sides along a wave."""
    at = lambda i, j: 4 * i + j % 4
    points = [(x, 2 + .3 * np.sin(2 * x) + radius * np.cos(j * np.pi / 2), radius * np.sin(j * np.pi / 2))
              for x in np.linspace(0, length, steps + 1) for j in range(4)]
    sides = [t for i in range(steps) for j in range(4)
             for t in ((at(i, j), at(i + 1, j), at(i + 1, j + 1)), (at(i, j), at(i + 1, j + 1), at(i, j + 1)))]
    ends = [(at(0, 0), at(0, 1), at(0, 2)), (at(0, 0), at(0, 2), at(0, 3)),
            (at(steps, 0), at(steps, 2), at(steps, 1)), (at(steps, 0), at(steps, 3), at(steps, 2))]
    return Mesh(points, sides + ends)


def prism(sides, steps, length):
    """An open tube of long triangles along z."""
    at = lambda i, j: sides * i + j % sides
    points = [(np.cos(a), np.sin(a), z) for z in np.linspace(0, length, steps + 1)
              for a in np.arange(sides) * 2 * np.pi / sides]
    return Mesh(points, [t for i in range(steps) for j in range(sides)
                         for t in ((at(i, j), at(i, j + 1), at(i + 1, j + 1)), (at(i, j), at(i + 1, j + 1), at(i + 1, j)))])


def crumbs(size, at):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    sides = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    return Mesh((np.asarray(at, float)[:, None] + size * corners).reshape(-1, 3),
                (sides + 4 * np.arange(len(at))[:, None, None]).reshape(-1, 3))


class Surface(program.ColossusTest):
    def built(self, mesh, *options, name="input.ply", ranks=0):
        """A container of the mesh that verify finds nothing in, and its info."""
        path = meshes.write_ply(self.path(name), mesh)
        container = self.build("surface.h5", path, options=options, ranks=ranks)
        self.run_program("verify", container, "--against", path)
        return container, self.info(container)

    def assert_there(self, container, info, mesh):
        """Every corner and middle of the input's triangles is within the finest level's error of it."""
        error = info["quantisation_error"]
        corners = mesh.points[np.unique(mesh.triangles)]
        points = np.concatenate([corners, mesh.points[mesh.triangles].mean(axis=1)])
        self.assertTrue(np.isfinite(distances.to_mesh(points, self.finest(container), error * (1 + 1e-9))).all(),
                        f"something is farther than {error} away")

    def assert_area(self, container, mesh, delta=1e-3):
        self.assertAlmostEqual(check_closed.area(self.finest(container)) / check_closed.area(mesh), 1.0, delta=delta)

    def test_two_sided(self):
        """Every triangle a second time, turned over: the first of each pair stays, and the others are counted."""
        torus = meshes.tube(48, 24)
        back = turned_over(torus)
        half = Mesh(torus.points, torus.triangles[::2, ::-1])
        shared = lambda *parts: Mesh(torus.points, np.concatenate([p.triangles for p in parts]))
        for name, mesh, opposite, duplicate in (
                ("shared vertices", shared(torus, back), 2304, 0),
                ("vertices of their own", meshes.join(torus, back), 2304, 0),
                ("soup", soup(meshes.join(torus, back)), 2304, 0),
                ("half of them", shared(torus, half), 1152, 0),
                ("the back first", shared(back, torus), 2304, 0),
                ("thrice", shared(torus, back, torus), 2304, 2304)):
            for scheme in SCHEMES:
                with self.subTest(name, scheme=scheme):
                    container, info = self.built(mesh, "--scheme", scheme, "--leaf-triangles", 500, "--position-bits", 16,
                                                 ranks=3 if name == "soup" else 0)
                    self.assertEqual(info["counts"]["opposite"], opposite)
                    self.assertEqual(info["counts"]["duplicate"], duplicate)
                    self.assertEqual(info["counts"]["border_edges"], 0)
                    self.assert_area(container, torus)
                    self.assertTrue(Census(self.finest(container)).is_closed)

    def test_things_thinner_than_the_lattice(self):
        """Both sides of a plate coincide on the lattice, or when they are rounded: neither is a copy of the other."""
        torus = meshes.tube(48, 24)
        for thickness in (1e-10, 1e-7, 1e-5):
            thin = plate(20, thickness)
            mesh = meshes.join(torus, Mesh(thin.points + (2, 0, 0), thin.triangles))
            for scheme in SCHEMES:
                with self.subTest(thickness=thickness, scheme=scheme):
                    container, info = self.built(mesh, "--scheme", scheme, "--leaf-triangles", 500)
                    self.assertEqual(info["counts"]["opposite"], 0)
                    self.assertEqual(info["counts"]["finest_border_edges"], 0)
                    self.assert_area(container, mesh)
                    self.assert_there(container, info, mesh)

    def test_cuts_of_long_triangles(self):
        """Long tubes of few triangles between thin plates: where cuts fall together, and where a coarser level lays both
        sides onto each other, edges are non-manifold; the container says so, and verify allows it."""
        found = 0
        for seed in (1, 2, 3):
            random = np.random.default_rng(seed)
            parts = [meshes.tube(30, 20)]
            for sides, steps in ((30, 2), (7, 1), (20, 3)):
                parts.append(prism(sides, steps, random.uniform(1, 10)))
            for cells in (3, 20):
                turn = np.linalg.qr(random.standard_normal((3, 3)))[0]
                thin = plate(cells, 10 ** random.uniform(-4, -1))
                parts.append(Mesh(random.uniform(.3, 3) * thin.points @ turn + random.uniform(-2, 2, 3), thin.triangles))
            mesh = meshes.join(*parts)
            for options in (("--leaf-triangles", 100), ("--position-bits", 8)):
                with self.subTest(seed=seed, options=options):
                    found += self.built(mesh, *options)[1]["counts"]["finest_nonmanifold_edges"]
        self.assertGreater(found, 0)

    def test_wires_and_crumbs(self):
        """Of what is smaller than a unit something stays, in the finest level and where the error asks for it."""
        torus = meshes.tube(48, 24)
        far = [(2 + .1 * i, 2, 2 - .05 * i) for i in range(20)]
        for name, small in (("wire", wire(40, 1e-6)), ("thin wire", wire(40, 1e-9)), ("crumbs", crumbs(1e-6, far)),
                            ("dust", crumbs(1e-9, far)), ("needles", Mesh(
                                [p for x, y, z in far for p in ((x, y, z), (x, y + 2, z), (x + 1e-6, y + 1, z))],
                                np.arange(60).reshape(-1, 3)))):
            mesh = meshes.join(torus, small)
            for scheme in SCHEMES:
                for bits in (8, 12):
                    with self.subTest(name, scheme=scheme, bits=bits):
                        container, info = self.built(mesh, "--scheme", scheme, "--leaf-triangles", 500,
                                                     "--position-bits", bits)
                        self.assert_there(container, info, mesh)

    def test_a_far_corner(self):
        """Named with file and number where it costs much; the build ends where it costs the triangles."""
        torus = meshes.tube(48, 24)
        count = len(torus.points)
        with_corner = lambda x: Mesh(np.concatenate([torus.points, [[x, 0, 0]]]),
                                     np.concatenate([torus.triangles, [[0, 1, count]]]))
        near = meshes.write_ply(self.path("near.ply"), meshes.tube(30, 20))
        for x in (1e7, -1e30, 1e300):
            far = meshes.write_ply(self.path("far.ply"), with_corner(x))
            for scheme in SCHEMES:
                run = self.run_program("build", near, far, "-o", self.path("far.h5"), "--scheme", scheme, ranks=2,
                                       status=program.BAD_DATA)
                self.assertIn(f"far.ply: vertex {count}", run.stderr)
                self.assertIn("--keep-outliers", run.stderr)
                self.assertFalse(os.path.exists(self.path("far.h5")) or os.path.exists(self.path("far.h5.scratch")))
        # Half of the surface must be there even then.
        run = self.run_program("build", far, "-o", self.path("far.h5"), "--keep-outliers", status=program.BAD_DATA)
        self.assertIn(f"far.ply: vertex {count}", run.stderr)
        # A hundred times as far as the torus is wide: dear, but the triangles are there.
        path = meshes.write_ply(self.path("dear.ply"), with_corner(300.0))
        for scheme in SCHEMES:
            run = self.run_program("build", path, "-o", self.path("dear.h5"), "--scheme", scheme, "--leaf-triangles", 300,
                                   "--position-bits", 16)
            self.assertRegex(run.stderr, f"warning: dear.ply: vertex {count}, a corner at 300 ")
            self.run_program("verify", self.path("dear.h5"), "--against", path)
        # Nine times: no word.
        path = meshes.write_ply(self.path("near.ply"), with_corner(23.8))
        self.assertNotIn("far from", self.run_program("build", path, "-o", self.path("near.h5")).stderr)

    def test_vertices_that_no_triangle_uses(self):
        """They have no influence on the lattice, wherever they are."""
        torus = meshes.tube(48, 24)
        points = np.concatenate([[[-1e20, 3, 5]], torus.points, [[1e300, 0, 0]]])
        for scheme in SCHEMES:
            expected = self.built(torus, "--scheme", scheme)[1]
            found = self.built(Mesh(points, torus.triangles + 1), "--scheme", scheme)[1]
            self.assertEqual(found["lattice"], expected["lattice"])
            self.assertEqual(found["measures"], expected["measures"])
            self.assertEqual(found["counts"]["vertices"], expected["counts"]["vertices"] + 2)

    def test_a_negative_zero_is_a_zero(self):
        """Which of the two is seen first depends on the ranks, so bounds have the positive one."""
        corners = [[0, 0, 0], [-0.0, 1, 0], [1, 0, -0.0], [1, 1, 1]]
        sides = [[0, 1, 2], [1, 3, 2], [0, 2, 3], [0, 3, 1]]
        for turn in (corners, corners[1:] + corners[:1]):
            for scheme in SCHEMES:
                measures = self.built(Mesh(turn, sides), "--scheme", scheme)[1]["measures"]
                self.assertEqual([str(measures[f"min_{axis}"]) for axis in "xyz"], ["0.0", "0.0", "0.0"])

    def test_coordinates_that_overflow(self):
        torus = meshes.tube(24, 12)
        for scale in (5e306, 1e300, 1e-280):
            for scheme in SCHEMES:
                mesh = Mesh(torus.points * scale, torus.triangles)
                self.built(mesh, "--scheme", scheme)
        for scale in (5e307, 1.2e308):
            path = meshes.write_ply(self.path("large.ply"), Mesh(torus.points * scale, torus.triangles))
            run = self.run_program("build", path, "-o", self.path("large.h5"), status=program.BAD_DATA)
            self.assertIn("too large", run.stderr)

    def test_a_tolerance_is_a_promise(self):
        torus = meshes.write_ply(self.path("torus.ply"), meshes.tube(60, 40, noise=0.01))
        for scheme in SCHEMES:
            for tolerance in (1e-2, 1e-3):
                container = self.build("kept.h5", torus, options=("--scheme", scheme, "--tolerance", tolerance))
                self.assertLessEqual(self.info(container)["quantisation_error"], tolerance)
            run = self.run_program("build", torus, "-o", self.path("no.h5"), "--scheme", scheme, "--tolerance", 1e-12,
                                   ranks=2, status=program.USAGE)
            self.assertFalse(os.path.exists(self.path("no.h5")) or os.path.exists(self.path("no.h5.scratch")))
            least = float(re.search(r"the least that can is ([0-9.e-]+)", run.stderr)[1])
            container = self.build("least.h5", torus, options=("--scheme", scheme, "--tolerance", 1.0001 * least))
            self.assertLessEqual(self.info(container)["quantisation_error"], 1.0001 * least)

    def test_collinear_triangles(self):
        """They stay, since without them T-junctions open; but of nothing else there is nothing to build."""
        junction = Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 1, 0], [1, -1, 0]],
                        [[0, 2, 3], [0, 4, 1], [1, 4, 2], [0, 1, 2]])
        # Across the line y = 0, on one side of which the middle is missing.
        for scheme in SCHEMES:
            container, info = self.built(junction, "--scheme", scheme)
            self.assertEqual(info["counts"]["collinear"], 1)
            self.assertEqual(info["counts"]["border_edges"], 4)
            self.assertEqual(len(Census(self.finest(container)).loops), 1)
            for line in ((1, 2, 3), (.1, .2, .3), (1, 0, 0)):
                points = np.arange(100)[:, None] * np.array([line], float)
                path = meshes.write_ply(self.path("line.ply"), Mesh(points, [[i, i + 1, i + 2] for i in range(98)]))
                run = self.run_program("build", path, "-o", self.path("line.h5"), "--scheme", scheme, status=program.BAD_DATA)
                self.assertIn("line.ply: no triangle with an area", run.stderr)
                self.assertIn("collinear", run.stderr)

    def test_levels_that_do_not_shrink(self):
        """Dust says so, in the log and in info; beside a statue it goes once the statue's error reaches it."""
        random = np.random.default_rng(7)
        at = random.normal(size=(4000, 3))
        dust = crumbs(0.004, at / np.linalg.norm(at, axis=1)[:, None])
        torus = meshes.tube(192, 96, noise=0.002)
        sown = torus.points[random.integers(0, len(torus.points), 3000)] * 1.0005
        for scheme in SCHEMES:
            path = meshes.write_ply(self.path("dust.ply"), dust)
            run = self.run_program("build", path, "-o", self.path("dust.h5"), "--scheme", scheme, "--leaf-triangles", 500)
            self.assertRegex(run.stderr, "warning: level 0 does not shrink as it should: [0-9]+ triangles are left of")
            self.assertIn("level 0 does not shrink", self.run_program("info", self.path("dust.h5")).stdout)
            self.run_program("verify", self.path("dust.h5"), "--against", path)
            _, alone = self.built(torus, "--scheme", scheme, "--leaf-triangles", 1000)
            _, info = self.built(meshes.join(torus, crumbs(1e-4, sown)), "--scheme", scheme, "--leaf-triangles", 1000)
            self.assertLess(info["levels"][0]["triangles"], 2 * alone["levels"][0]["triangles"] + 100)

    def test_the_same_geometry_for_every_codec(self):
        """Errors, counts and every level's triangles, whatever the codec's order."""
        scan = meshes.write_ply(self.path("scan.ply"), meshes.tube(120, 80, noise=0.01))
        for scheme in SCHEMES:
            described = {}
            for codec in ("predict", "zstd", "paper"):
                container = self.build("twin.h5", scan, options=("--scheme", scheme, "--codec", codec, "--leaf-triangles", 500))
                levels = self.info(container)["levels"]
                rows = [{key: level[key] for key in ("nodes", "triangles", "vertices", "error")} for level in levels]
                cuts = []
                for level in levels:
                    cut = self.extract(container, "--level", level["level"])
                    corners = cut.points[cut.triangles]
                    first = np.lexsort(corners.transpose(2, 0, 1)[::-1])[:, :1]
                    turned = np.take_along_axis(corners, ((first + np.arange(3)) % 3)[..., None], axis=1)
                    cuts.append(np.unique(turned.reshape(-1, 9), axis=0).tobytes())
                described[codec] = (rows, cuts)
            self.assertEqual(described["zstd"], described["predict"], scheme)
            self.assertEqual(described["paper"], described["predict"], scheme)

    def test_pairs_of_the_beast(self):
        """Two pairs of triangles in its plane of symmetry: one of each is there."""
        scan = self.shared_scan("beast.ply")
        mesh = check_closed.read_ply(scan)
        for scheme in SCHEMES:
            container = self.build("beast.h5", scan, options=("--scheme", scheme, "--leaf-triangles", 1000))
            self.run_program("verify", container, "--against", scan)
            info = self.info(container)
            self.assertEqual(info["counts"]["opposite"], 2)
            self.assert_there(container, info, mesh)


if __name__ == "__main__":
    program.main()
