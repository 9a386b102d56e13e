"""Cuts of closed scans are closed and manifold, cuts of open ones no more open than the input, and the finest cut is
the input: told by check_closed.py, which shares no code with Colossus."""
import numpy as np

import check_closed
import distances
import meshes
import program


class Cuts(program.ColossusTest):
    def cuts(self, container):
        """Every level, errors between the finest and the root's, triangle counts: (name, options, error) of each cut.
        The error is an upper bound of its nodes' errors."""
        info = self.info(container)
        levels = info["levels"]
        errors = [level["error"] for level in levels]
        for i, level in enumerate(levels):
            # Leaves above the level are in the cut as well.
            bound = max([errors[i]] + [errors[k] for k in range(i) if levels[k]["leaves"]])
            yield f"level {level['level']}", ("--level", level["level"]), bound
        finest = max(errors[k] for k in range(len(levels)) if levels[k]["leaves"])
        for share in (0.02, 0.1, 0.3, 0.7):
            error = share * errors[0]
            yield f"error {error}", ("--error", error), max(error, finest)
        for share in (0.07, 0.2, 0.5, 0.9):
            count = int(share * info["counts"]["triangles"])
            yield f"{count} triangles", ("--triangles", count), errors[0]

    def assert_closed(self, scan, *options):
        """All cuts of a container of the scan have no border and no more non-manifold edges than the scan."""
        container = self.build("scan.h5", scan, options=options)
        before = check_closed.Census(check_closed.read_ply(scan))
        self.assertTrue(before.is_closed, f"the input: {before}")
        for name, cut, _ in self.cuts(container):
            census = check_closed.Census(self.extract(container, *cut))
            self.assertGreater(len(census.mesh.triangles), 0, name)
            self.assertEqual(len(census.border), 0, f"{name}: {census}")
            if len(before.nonmanifold) == 0:
                self.assertEqual(len(census.nonmanifold), 0, f"{name}: {census}")
        self.run_program("verify", container)
        return container

    def assert_no_more_open(self, scan, *options):
        """All cuts have at most as many border loops as the scan, each within the cut's error of one of its loops."""
        container = self.build("scan.h5", scan, options=options)
        before = check_closed.Census(check_closed.read_ply(scan))
        self.assertGreater(len(before.loops), 0)
        ends = [(before.mesh.points[loop[:, 0]], before.mesh.points[loop[:, 1]]) for loop in before.loops]
        for name, cut, error in self.cuts(container):
            census = check_closed.Census(self.extract(container, *cut))
            self.assertLessEqual(len(census.loops), len(before.loops), f"{name}: {census}")
            for loop in census.loops:
                a, b = census.mesh.points[loop[:, 0]], census.mesh.points[loop[:, 1]]
                points = np.concatenate([a, a + (b - a) / 3, a + (b - a) * 2 / 3])
                nearest = min(distances.to_segments(points, *loop_ends).max() for loop_ends in ends)
                self.assertLessEqual(nearest, error, f"{name}: a border loop of {len(loop)} edges is far from all loops")
            if len(before.nonmanifold) == 0:
                self.assertEqual(len(census.nonmanifold), 0, f"{name}: {census}")
        self.run_program("verify", container)
        return container

    def assert_is_input(self, scan, container, area=1e-3):
        """The finest cut: every input vertex within the reported quantisation error of an output vertex, every output
        vertex within it of the input's surface (cut vertices lie inside its triangles), the area within 0.1 %."""
        info = self.info(container)
        reach = info["quantisation_error"] + info["lattice_error"]
        before, after = check_closed.weld(check_closed.read_ply(scan)), check_closed.weld(self.finest(container))
        used = np.unique(before.triangles)
        as_points = check_closed.Mesh(after.points, np.repeat(np.arange(len(after.points))[:, None], 3, axis=1))
        self.assertTrue(np.isfinite(distances.to_mesh(before.points[used], as_points, reach)).all(),
                        "an input vertex has no output vertex near it")
        self.assertTrue(np.isfinite(distances.to_mesh(after.points, before, reach)).all(),
                        "an output vertex is not on the input's surface")
        self.assertAlmostEqual(check_closed.area(after) / check_closed.area(before), 1.0, delta=area)

    def test_closed_statue(self):
        statue = self.path("statue.ply")
        self.run_program("synth", "-o", statue, "--triangles", 120000)
        container = self.assert_closed(statue, "--leaf-triangles", 1000)
        self.assertGreaterEqual(self.info(container)["nodes"], 50)
        self.assert_is_input(statue, container)
        self.run_program("verify", container, "--against", statue)

    def test_closed_torus_of_few_bits(self):
        torus = meshes.write_ply(self.path("torus.ply"), meshes.tube(120, 60, noise=0.01))
        container = self.assert_closed(torus, "--leaf-triangles", 400, "--position-bits", 9)
        # So few bits roughen the surface.
        self.assert_is_input(torus, container, area=1e-2)

    def test_open_sheet(self):
        sheet = meshes.grid(90, (1, 0, 0), (0.2, 1, 0))
        sheet.points[:, 2] = 0.05 * np.sin(9 * sheet.points[:, 0]) * np.sin(7 * sheet.points[:, 1])
        center = sheet.points[sheet.triangles].mean(axis=1)
        hole = np.linalg.norm(center[:, :2] - (0.5, 0.4), axis=1) < 0.15
        sheet.triangles = sheet.triangles[~hole]
        path = meshes.write_ply(self.path("sheet.ply"), sheet)
        container = self.assert_no_more_open(path, "--leaf-triangles", 500)
        self.assert_is_input(path, container)

    def test_tolerance_is_kept(self):
        torus = meshes.write_ply(self.path("torus.ply"), meshes.tube(120, 60, noise=0.01))
        for tolerance in (1e-3, 1e-4):
            info = self.info(self.build("torus.h5", torus, options=("--leaf-triangles", 400, "--tolerance", tolerance)))
            self.assertLessEqual(info["quantisation_error"], tolerance)
            self.assertGreater(info["position_bits"], 7)

    def test_armadillo(self):
        scan = self.shared_scan("armadillo.ply")
        container = self.assert_closed(scan, "--leaf-triangles", 2000)
        self.assert_is_input(scan, container)
        self.run_program("verify", container, "--against", scan)

    def test_beast(self):
        scan = self.shared_scan("beast.ply")
        mesh = check_closed.read_ply(scan)
        self.assertTrue(check_closed.Census(mesh).is_closed)
        # Two pairs of opposite triangles lie in its plane of symmetry: the first of each stays, and is open.
        _, first = np.unique(np.sort(mesh.triangles, axis=1), axis=0, return_index=True)
        self.assertEqual(len(first), len(mesh.triangles) - 2)
        single = meshes.write_ply(self.path("single.ply"), check_closed.Mesh(mesh.points, mesh.triangles[np.sort(first)]))
        self.assert_no_more_open(single, "--leaf-triangles", 2000)
        container = self.build("scan.h5", scan, options=("--leaf-triangles", 2000))
        counts = self.info(container)["counts"]
        self.assertEqual((counts["opposite"], counts["nonmanifold_edges"]), (2, 2))
        # How many the finest cut has is open: cutting divides them, and rounding can part sheets that touch there.
        self.assert_is_input(scan, container)

    def test_gargo(self):
        """Its normals and colours come through: each input vertex's colour is that of the output vertex near it."""
        scan = self.shared_scan("gargo.ply")
        before = check_closed.read_ply(scan)
        container = self.build("gargo.h5", scan, options=("--leaf-triangles", 2000))
        info = self.info(container)
        self.assertEqual(info["attributes"], {"normals": True, "colors": True})
        after = self.finest(container)
        self.assertTrue({"nx", "ny", "nz", "red", "green", "blue", "alpha"} <= set(after.attributes))
        reach = info["quantisation_error"] + info["lattice_error"]
        sample = np.arange(0, len(before.points), 97)
        same = 0
        for i in sample:
            nearest = int(np.argmin(((after.points - before.points[i]) ** 2).sum(axis=1)))
            self.assertLessEqual(np.linalg.norm(after.points[nearest] - before.points[i]), reach)
            normals = [np.array([m.attributes[n][k] for n in ("nx", "ny", "nz")], float)
                       for m, k in ((before, i), (after, nearest))]
            colors = [[m.attributes[n][k] for n in ("red", "green", "blue", "alpha")]
                      for m, k in ((before, i), (after, nearest))]
            cosine = normals[0] @ normals[1] / max(np.linalg.norm(normals[0]) * np.linalg.norm(normals[1]), 1e-30)
            same += cosine > 0.99 and colors[0] == colors[1]
        # Cut vertices with mixed attributes can be as near as the vertex itself.
        self.assertGreater(same, 0.97 * len(sample))
        self.assert_is_input(scan, container)
        self.run_program("verify", container, "--against", scan)

    def test_gargo_cuts(self):
        scan = self.shared_scan("gargo.ply")
        if check_closed.Census(check_closed.read_ply(scan)).is_closed:
            self.assert_closed(scan, "--leaf-triangles", 2000)
        else:
            self.assert_no_more_open(scan, "--leaf-triangles", 2000)

    def test_stanford_bunny(self):
        scan = self.shared_scan("stanford-bunny.ply")
        container = self.assert_no_more_open(scan, "--leaf-triangles", 2000)
        self.assertEqual(self.info(container)["counts"]["border_edges"], 223)
        self.assert_is_input(scan, container)


if __name__ == "__main__":
    program.main()
