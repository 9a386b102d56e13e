"""Inputs that break mesh programs, each with its expected result."""
import os

import numpy as np

import check_closed
import distances
import meshes
import program
from check_closed import Census, Mesh


class Nasty(program.ColossusTest):
    def run_through(self, mesh, *options, name="input.ply"):
        """Builds and verifies a container of the mesh; returns it and its `info`."""
        path = meshes.write_ply(self.path(name), mesh)
        container = self.build("nasty.h5", path, options=options)
        self.run_program("verify", container)
        return container, self.info(container)

    def assert_levels(self, container, info, is_closed=True, is_manifold=True, least_levels=2):
        """Every uniform cut is closed and manifold where the input is; returns the finest."""
        self.assertGreaterEqual(len(info["levels"]), least_levels)
        for level in info["levels"]:
            census = Census(self.extract(container, "--level", level["level"]))
            if is_closed:
                self.assertEqual(len(census.border), 0, f"level {level['level']}: {census}")
            if is_manifold:
                self.assertEqual(len(census.nonmanifold), 0, f"level {level['level']}: {census}")
        return census

    def assert_area(self, census, mesh):
        self.assertAlmostEqual(check_closed.area(census.mesh) / check_closed.area(mesh), 1.0, delta=1e-3)

    def test_boxes_on_lattice_planes(self):
        """Faces at 0, 1/4, 1/2, 3/4, 1 of the bounding box: on the planes of a careless hierarchy."""
        mesh = meshes.join(meshes.box(16, (0, 0, 0), (1, 1, 1)), meshes.box(12, (.25, .25, .25), (.5, .5, .5)),
                           meshes.box(12, (.5, .625, .625), (.75, .75, .75)))
        # At 12 bits a needle is thinner than a unit of weight, which roughens the area by a third of a percent.
        container, info = self.run_through(mesh, "--leaf-triangles", 300, "--position-bits", 16)
        self.assertEqual(info["counts"]["degenerate"], 0)
        self.assertEqual(info["counts"]["duplicate"], 0)
        self.assertEqual(info["counts"]["border_edges"], 0)
        finest = self.assert_levels(container, info, is_manifold=False)
        self.assert_area(finest, mesh)
        self.assertEqual(len(finest.nonmanifold), 0, str(finest))

    @staticmethod
    def sheets():
        """Nine across each of two axes."""
        sheets = [meshes.grid(16, (1, 0, 0), (0, 1, 0), (0, 0, k / 8)) for k in range(9)]
        sheets += [meshes.grid(16, (0, 1, 0), (0, 0, 1), (k / 8, 0, 0)) for k in range(9)]
        return meshes.snapped(meshes.join(*sheets))

    def test_sheets_on_lattice_planes(self):
        """They cross in non-manifold edges."""
        mesh = self.sheets()
        container, info = self.run_through(mesh, "--leaf-triangles", 300)
        before = Census(mesh)
        self.assertEqual(info["counts"]["border_edges"], len(before.border))
        self.assertEqual(info["counts"]["nonmanifold_edges"], len(before.nonmanifold))
        finest = Census(self.finest(container))
        self.assert_area(finest, mesh)
        self.assertLessEqual(len(finest.loops), len(before.loops))

    def test_sheets_within_their_stored_errors(self):
        """Coarse levels of flat sheets are exact but where vertices move by less than a unit of weight."""
        path = meshes.write_ply(self.path("sheets.ply"), self.sheets())
        container = self.build("sheets.h5", path, options=("--leaf-triangles", 1000))
        run = self.run_program("verify", container, "--against", path)
        self.assertIn("nothing found", run.stdout)
        self.assertIn("measured:", run.stdout)

    def test_slivers(self):
        """A closed needle-toothed torus: triangles a thousand times longer than wide."""
        mesh = meshes.tube(2000, 6, inner=0.5)
        # At 12 bits a needle is thinner than a unit of weight, which roughens the area by a third of a percent.
        container, info = self.run_through(mesh, "--leaf-triangles", 300, "--position-bits", 16)
        self.assertEqual(info["counts"]["degenerate"], 0)
        self.assert_area(self.assert_levels(container, info, is_manifold=False), mesh)

    def test_one_triangle_larger_than_the_roots_children(self):
        """Beside it a statue of a hundredth of its size; that is refined nevertheless."""
        large = Mesh([[-40, -40, 0], [50, -30, 1], [0, 60, 9]], [[0, 1, 2]])
        mesh = meshes.join(meshes.tube(80, 40, radius=0.4, inner=0.15), large)
        container, info = self.run_through(mesh, "--leaf-triangles", 300)
        self.assertEqual(info["counts"]["border_edges"], 3)
        self.assertEqual(info["counts"]["triangles"], 6401)
        self.assertGreater(info["nodes"], 20)
        census = Census(self.finest(container))
        self.assertEqual(len(census.loops), 1)
        self.assert_area(census, mesh)

    def test_coordinates_far_from_the_origin(self):
        """Map coordinates of 5e5 and 5e6 with millimetre detail: floats would lose it, so a cut has doubles."""
        mesh = meshes.tube(160, 80, radius=2.0, inner=0.8, noise=1e-3)
        mesh.points += (5e5, 5e6, 120.0)
        container, info = self.run_through(mesh, "--leaf-triangles", 1000)
        self.run_program("extract", container, "--level", 99, "-o", self.path("far.ply"))
        with open(self.path("far.ply"), "rb") as file:
            self.assertIn(b"property double x", file.read(400))
        reach = info["quantisation_error"] + info["lattice_error"]
        self.assertLess(reach, 1e-3, "less than a millimetre")
        after = self.assert_levels(container, info).mesh
        points = Mesh(after.points, np.repeat(np.arange(len(after.points))[:, None], 3, axis=1))
        self.assertTrue(np.isfinite(distances.to_mesh(mesh.points, points, reach)).all())
        self.assertTrue(np.isfinite(distances.to_mesh(after.points, mesh, reach)).all())

    def test_two_scans_that_interpenetrate(self):
        one, other = meshes.tube(120, 60), meshes.tube(100, 50)
        other.points = other.points[:, [1, 2, 0]] + (0.9, 0.1, 0.05)
        meshes.write_ply(self.path("one.ply"), one)
        meshes.write_ply(self.path("other.ply"), other)
        with open(self.path("list.txt"), "w", encoding="utf-8") as file:
            file.write("one.ply\nother.ply\n")
        container = self.build("both.h5", "@" + self.path("list.txt"), options=("--leaf-triangles", 500))
        self.run_program("verify", container)
        info = self.info(container)
        self.assertEqual([entry["name"] for entry in info["inputs"]], ["one.ply", "other.ply"])
        self.assertEqual(info["counts"]["triangles"], len(one.triangles) + len(other.triangles))
        self.assert_area(self.assert_levels(container, info), meshes.join(one, other))

    def test_copies_of_one_triangle(self):
        mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0.5]], np.tile([[0, 1, 2]], (100_000, 1)))
        mesh.triangles[1::2] = [1, 2, 0]
        container, info = self.run_through(mesh)
        self.assertEqual(info["counts"]["triangles"], 100_000)
        self.assertEqual(info["counts"]["duplicate"], 99_999)
        census = Census(self.finest(container))
        self.assert_area(census, Mesh(mesh.points, [[0, 1, 2]]))
        self.assertEqual(len(census.loops), 1)

    def test_fan_at_one_vertex(self):
        """No bisection thins out the triangles at the middle: a leaf stays above the limit, and is counted."""
        mesh = meshes.fan(100_000)
        container, info = self.run_through(mesh)
        self.assertGreater(info["above_limit"], 0)
        self.assertEqual(info["above_limit"], info["counts"]["leaves_above_limit"])
        census = Census(self.finest(container))
        self.assertEqual(len(census.loops), 1)
        # Nothing is lost; but 10^5 spokes lie closer together than the bits can tell, which roughens the surface.
        self.assertGreater(check_closed.area(census.mesh) / check_closed.area(mesh), 0.99)

    def test_three_sheets_on_one_edge(self):
        sheet = [meshes.grid(40, (1, 0, 0), b) for b in ((0, 1, 0), (0, -.5, .8), (0, -.5, -.8))]
        mesh = meshes.snapped(meshes.join(*sheet))
        container, info = self.run_through(mesh, "--leaf-triangles", 300)
        self.assertEqual(info["counts"]["nonmanifold_edges"], 40)
        finest = Census(self.finest(container))
        self.assert_area(finest, mesh)
        on_axis = np.abs(finest.mesh.points[finest.nonmanifold][:, :, 1:]).max(axis=(1, 2)) < 1e-3
        length = np.abs(np.diff(finest.mesh.points[finest.nonmanifold][on_axis][:, :, 0], axis=1)).sum()
        self.assertAlmostEqual(length, 1.0, delta=1e-3, msg="the common edge is there as a whole")
        for level in info["levels"]:
            census = Census(self.extract(container, "--level", level["level"]))
            self.assertAlmostEqual(check_closed.area(census.mesh) / check_closed.area(mesh), 1.0, delta=5e-3)
            self.assertEqual(len(census.loops), 1, f"level {level['level']}: {census}")

    def test_separate_tetrahedra(self):
        """Nothing is lost, however small: all of them are there in the finest cut. Since nothing of them can be
        simplified, nodes grow large, and many corners and edges fall together."""
        mesh = meshes.tetrahedra(60_000, 0.004)
        container, info = self.run_through(mesh)
        self.assertEqual(info["counts"]["border_edges"], 0)
        census = self.assert_levels(container, info)
        self.assert_area(census, mesh)
        parts = check_closed.loops(check_closed.edges(census.mesh)[0])
        self.assertGreaterEqual(len(parts), 59_900, "parts of the surface; some touch after quantisation")
        reach = info["quantisation_error"] + info["lattice_error"]
        points = Mesh(census.mesh.points, np.repeat(np.arange(len(census.mesh.points))[:, None], 3, axis=1))
        self.assertTrue(np.isfinite(distances.to_mesh(mesh.points, points, reach)).all(), "a corner is missing")

    def test_separate_tetrahedra_of_few_bits(self):
        """A unit of weight in the root is as large as one of them: still closed and manifold."""
        container, info = self.run_through(meshes.tetrahedra(60_000, 0.004), "--position-bits", 8)
        self.assert_levels(container, info)

    def test_slivers_of_few_bits(self):
        """The same needles, but thinner than a unit of weight."""
        container, info = self.run_through(meshes.tube(2000, 6, inner=0.5), "--leaf-triangles", 300, "--position-bits", 8)
        self.assert_levels(container, info)

    def test_crumbs_beside_a_statue(self):
        """Crumbs beside a statue that is refined: a unit of weight of coarse nodes is larger than they are, but something is
        left of them, since nothing else is near."""
        crumbs = meshes.tetrahedra(40, 1e-5)
        crumbs.points = crumbs.points * 0.8 + (2.2, 2.2, 2.2)
        mesh = meshes.join(meshes.tube(80, 40, radius=0.8, inner=0.3), crumbs)
        container, info = self.run_through(mesh, "--leaf-triangles", 300, "--position-bits", 8)
        self.assert_levels(container, info)
        try:
            import h5py
        except ImportError as error:
            self.skipTest(f"whether nodes are empty: {error}; install python3-h5py")
        with h5py.File(container) as file:
            self.assertEqual(sum(file["nodes"]["triangles"] == 0), 0)

    def test_hole_with_a_straight_border(self):
        """A square hole whose border is parallel to the axes, at fractions of the bounding box, in every direction."""
        sheets = []
        for a, b in (((1, 0, 0), (0, 1, 0)), ((0, 1, 0), (0, 0, 1)), ((0, 0, 1), (1, 0, 0))):
            sheet = meshes.grid(32, a, b)
            u = sheet.points[sheet.triangles].mean(axis=1)
            hole = ((u > 0.25) & (u < 0.5)).sum(axis=1) == 2
            sheets.append(Mesh(sheet.points + 0.5 * np.cross(a, b), sheet.triangles[~hole]))
        for sheet in sheets:
            before = Census(sheet)
            self.assertEqual(len(before.loops), 2)
            container, info = self.run_through(sheet, "--leaf-triangles", 200)
            self.assertEqual(info["counts"]["border_edges"], len(before.border))
            for level in info["levels"]:
                census = Census(self.extract(container, "--level", level["level"]))
                self.assertLessEqual(len(census.loops), 2, f"level {level['level']}: {census}")
            self.assert_area(census, sheet)
            self.assertEqual(len(census.loops), 2)

    def test_polygons(self):
        """The sides of a box as quadrilaterals, and two of them with more corners."""
        points = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)] + [[0.5, 0, 0]]
        faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 8, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4, 8], [1, 5, 7, 3]]
        path = meshes.write_ply(self.path("box.ply"), Mesh(points, []), faces=faces)
        container = self.build("box.h5", path)
        self.run_program("verify", container)
        counts = self.info(container)["counts"]
        self.assertEqual((counts["polygons"], counts["triangles"], counts["border_edges"]), (6, 14, 0))
        census = Census(self.finest(container))
        self.assertTrue(census.is_closed)
        self.assertAlmostEqual(check_closed.area(census.mesh), 6.0, delta=6e-3)

    def test_mixed_orientation(self):
        """Every other triangle turned over: closed all the same, nothing cancels."""
        mesh = meshes.tube(60, 30)
        mesh.triangles[::2] = mesh.triangles[::2, ::-1]
        container, info = self.run_through(mesh, "--leaf-triangles", 300)
        self.assertEqual(info["counts"]["border_edges"], 0)
        self.assertEqual(info["counts"]["duplicate"], 0)
        self.assert_area(self.assert_levels(container, info), mesh)

    def test_degenerate_triangles_among_others(self):
        mesh = meshes.tube(40, 20)
        mesh.triangles = np.concatenate([mesh.triangles, [[5, 5, 6], [7, 7, 7]], mesh.triangles[:3]])
        _, info = self.run_through(mesh)
        self.assertEqual(info["counts"]["degenerate"], 2)
        self.assertEqual(info["counts"]["duplicate"], 3)


class BadData(program.ColossusTest):
    """Status 65, a message that names the file, the element and its number, and nothing left behind."""

    def assert_refused(self, path, *words, ranks=(0, 3)):
        for count in ranks:
            before = sorted(os.listdir(self.folder))
            run = self.run_program("build", path, "-o", self.path("bad.h5"), ranks=count, status=program.BAD_DATA)
            for word in (os.path.basename(path), *words):
                self.assertIn(word, run.stderr)
            self.assertEqual(sorted(os.listdir(self.folder)), before, "something is left behind")

    def torus(self, **options):
        return meshes.write_ply(self.path("torus.ply"), meshes.tube(40, 20), **options)

    def test_not_a_number(self):
        for value in (np.nan, np.inf, -np.inf):
            mesh = meshes.tube(40, 20)
            mesh.points[321, 1] = value
            self.assert_refused(meshes.write_ply(self.path("nan.ply"), mesh), "vertex 321")

    def test_truncated(self):
        with open(self.torus(), "rb") as file:
            data = file.read()
        header = data.index(b"end_header\n") + len("end_header\n")
        for size, words in ((header // 2, ("header",)), (header + 24 * 500 + 7, ("vertex", "800")), (len(data) - 1, ("face 1599",))):
            with open(self.path("short.ply"), "wb") as file:
                file.write(data[:size])
            self.assert_refused(self.path("short.ply"), *words)

    def test_index_out_of_range(self):
        for index in (800, -1):
            mesh = meshes.tube(40, 20)
            mesh.triangles[77, 1] = index
            self.assert_refused(meshes.write_ply(self.path("index.ply"), mesh), "face 77", str(index))

    def test_index_out_of_range_in_text(self):
        mesh = meshes.tube(40, 20)
        mesh.triangles[77, 1] = 4321
        self.assert_refused(meshes.write_ply(self.path("index.ply"), mesh, text=True), "face 77", "4321")

    def test_header_that_lies(self):
        with open(self.torus(), "rb") as file:
            data = file.read()
        for word, lie in ((b"face 1600", b"face 1700"), (b"vertex 800", b"vertex 2000000000"),
                          (b"face 1600", b"face 99999999999999")):
            with open(self.path("lie.ply"), "wb") as file:
                file.write(data.replace(word, lie))
            self.assert_refused(self.path("lie.ply"), lie.split()[0].decode())

    def test_no_triangles(self):
        self.assert_refused(meshes.write_ply(self.path("cloud.ply"), Mesh(np.eye(3), [])), "no triangles")

    def test_only_degenerate_triangles(self):
        self.assert_refused(meshes.write_ply(self.path("flat.ply"), Mesh(np.eye(3), [[0, 0, 1], [2, 2, 2]])), "2", "degenerate")

    def test_missing_and_foreign(self):
        self.assert_refused(self.path("missing.ply"))
        with open(self.path("notes.ply"), "w", encoding="utf-8") as file:
            file.write("these are notes\n")
        self.assert_refused(self.path("notes.ply"))

    def test_bad_file_among_good_ones(self):
        mesh = meshes.tube(40, 20)
        mesh.triangles[5, 0] = 1000
        bad = meshes.write_ply(self.path("bad.ply"), mesh)
        run = self.run_program("build", self.torus(), bad, "-o", self.path("out.h5"), status=program.BAD_DATA, ranks=2)
        self.assertIn("bad.ply", run.stderr)
        self.assertEqual(sorted(os.listdir(self.folder)), ["bad.ply", "torus.ply"])

    def test_an_older_output_survives(self):
        with open(self.path("bad.h5"), "wb") as file:
            file.write(b"an older container")
        self.assert_refused(self.path("missing.ply"))
        with open(self.path("bad.h5"), "rb") as file:
            self.assertEqual(file.read(), b"an older container")


if __name__ == "__main__":
    program.main()
