"""Tests scripts/read_container.py. Arguments: the program sample_container, the script, and the folders of golden
payloads and of golden containers."""
import importlib.util
import itertools
import os
import struct
import subprocess
import sys
import tempfile
import unittest

try:
    import h5py  # noqa: F401
    import numpy
    import zstandard  # noqa: F401
except ImportError as error:
    print(f"skipped: {error}; install python3-h5py, python3-numpy and python3-zstandard")
    sys.exit(77)

SAMPLE, SCRIPT, GOLDEN, GOLDEN_CONTAINERS = sys.argv[1:5]
CODECS = ("zstd", "paper")
spec = importlib.util.spec_from_file_location("read_container", SCRIPT)
sys.dont_write_bytecode = True
rc = importlib.util.module_from_spec(spec)
spec.loader.exec_module(rc)


def run(*arguments):
    return subprocess.run([sys.executable, SCRIPT, *arguments], capture_output=True, text=True, check=False)


def read_ply(path):
    data = open(path, "rb").read()
    header, body = data.split(b"end_header\n", 1)
    lines = header.decode().split("\n")
    count = {line.split()[1]: int(line.split()[2]) for line in lines if line.startswith("element")}
    size = 3 * 8 + 3 * 4 + 4
    vertices = [struct.unpack_from("<3d3f4B", body, i * size) for i in range(count["vertex"])]
    start = count["vertex"] * size
    faces = [struct.unpack_from("<B3i", body, start + i * 13) for i in range(count["face"])]
    assert len(body) == start + 13 * count["face"]
    return vertices, faces


class Hierarchy(unittest.TestCase):
    def test_diamonds_are_those_of_longest_edge_bisection(self):
        """An independent construction: bisect the root's tetrahedra at their longest edges, group by that edge."""
        bits, levels = 5, 9
        side = 2**bits
        current = set()
        for axes in itertools.permutations(range(3)):
            corner, corners = [0, 0, 0], [(0, 0, 0)]
            for a in axes:
                corner[a] += side
                corners.append(tuple(corner))
            current.add(tuple(sorted(corners)))
        for level in range(levels):
            if len(current) > 3000:  # one corner of the cube is enough of the finer levels
                current = {t for t in current if all(max(c) <= side // 2 for c in t)}
            diamonds, children = {}, set()
            for t in current:
                p, q = max(itertools.combinations(t, 2), key=lambda e: sum((a - b)**2 for a, b in zip(*e)))
                middle = tuple((a + b) // 2 for a, b in zip(p, q))
                diamonds.setdefault(middle, set()).add(t)
                for end in (p, q):
                    children.add(tuple(sorted(set(t) - {end} | {middle})))
            for center, expected in diamonds.items():
                found = [tuple(tuple(int(x) for x in c) for c in t) for t in rc.diamond(level, center, bits)]
                self.assertEqual(found, sorted(found), "places are in lexicographic order")
                self.assertEqual(len(set(found)), (6, 4, 8)[level % 3])
                self.assertLessEqual(expected, set(found), (level, center))
                # Nothing else of the diamond lies in the root cube; the subset of the finer levels loses some.
                inside = {t for t in found if all(0 <= x <= side for c in t for x in c)}
                if len(current) <= 3000 and level < 6:
                    self.assertEqual(inside, expected, (level, center))
            current = children

    def test_a_place_that_is_no_centre_is_refused(self):
        with self.assertRaises(rc.BadContainer):
            rc.diamond(1, (16, 16, 16), 5)


class Payload(unittest.TestCase):
    def test_index_types_follow_the_vertex_count(self):
        self.assertEqual([rc.narrowest(n) for n in (255, 256, 65535, 65536)], ["<u1", "<u2", "<u2", "<u4"])

    def test_corners(self):
        codes = numpy.array([0, 0, 0, 1, 3, 0], dtype="<u1")
        self.assertEqual(rc.decode_corners(codes, 4).tolist(), [0, 1, 2, 2, 0, 3])
        self.assertEqual(rc.decode_corners(codes, 9).tolist(), [0, 1, 2, 2, 0, 3])
        with self.assertRaises(rc.BadContainer):
            rc.decode_corners(codes, 3)
        with self.assertRaises(rc.BadContainer):
            rc.decode_corners(numpy.array([0, 2], dtype="<u1"), 1)

    def test_normals_have_unit_length_and_fold(self):
        grid = numpy.arange(256)
        u, v = (a.ravel() for a in numpy.meshgrid(grid, grid))
        normals = rc.decode_normals(u, v)
        self.assertLess(abs((normals**2).sum(axis=1) - 1).max(), 1e-14)
        corner = rc.decode_normals(numpy.array([0, 255, 0]), numpy.array([0, 255, 255]))
        self.assertTrue(numpy.array_equal(corner, numpy.array([[0, 0, -1.0]] * 3)))
        axis = rc.decode_normals(numpy.array([255]), numpy.array([127]))
        self.assertGreater(axis[0, 0], 0.999)

    def test_truncation_at_every_length_is_refused(self):
        for codec, shape in itertools.product(CODECS, ("0", "blocks")):
            with tempfile.TemporaryDirectory() as folder:
                path = os.path.join(folder, "a.h5")
                subprocess.run([SAMPLE, path, shape, codec], check=True)
                payload = rc.Container(path).payload(1)
            rc.decode_payload(payload)
            for size in range(len(payload)):
                with self.assertRaises(rc.BadContainer):
                    rc.decode_payload(payload[:size])


class Golden(unittest.TestCase):
    """The golden payloads of all codecs were made of the same meshes."""

    def golden(self, codec_and_version, scheme):
        with open(os.path.join(GOLDEN, f"{codec_and_version}_{scheme}"), "rb") as file:
            return rc.decode_payload(file.read())

    @staticmethod
    def meshes(part):
        """Whatever the order: vertices, and triangles as their corners' positions from the least on."""
        names = [n for n in ("normals", "colors", "parents") if part[n] is not None]
        columns = [part["positions"]] + [part[n].reshape(len(part["positions"]), -1) for n in names]
        corners = part["positions"][part["triangles"]].tolist()
        return (sorted(numpy.hstack(columns).tolist()),
                sorted(t[t.index(min(t)):] + t[:t.index(min(t))] for t in corners))

    def test_all_say_the_same(self):
        for scheme, places in (("diamonds", [1, 4]), ("blocks", [0])):
            one = self.golden("zstd_1", scheme)
            self.assertEqual([p["place"] for p in one["parts"]], places)
            for other in ("paper_1", "predict_1", "predict_2"):
                self.assertEqual([self.meshes(p) for p in one["parts"]],
                                 [self.meshes(p) for p in self.golden(other, scheme)["parts"]], other)

    def test_truncation_of_predict_is_refused(self):
        for version in (1, 2):
            with open(os.path.join(GOLDEN, f"predict_{version}_diamonds"), "rb") as file:
                payload = file.read()
            for size in range(0, len(payload), 11):
                with self.assertRaises(rc.BadContainer):
                    rc.decode_payload(payload[:size])


    def test_containers_of_all_versions_are_decoded(self):
        names = sorted(name for name in os.listdir(GOLDEN_CONTAINERS) if name.endswith(".h5"))
        self.assertLessEqual({"blocks_1_1.h5", "diamonds_1_1.h5"}, set(names))
        for name in names:
            container = rc.Container(os.path.join(GOLDEN_CONTAINERS, name))
            self.assertEqual(name, f"{container.scheme}_{container.version[0]}_{container.version[1]}.h5")
            for i, node in enumerate(container.nodes):
                self.assertEqual(len(rc.decode_node(container, i)[3]), node["triangles"], name)


class Copies(unittest.TestCase):
    """Made by h5py: where offsets do not hold, the chunk index says where frames are."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = os.path.join(self.folder.name, "a.h5")
        self.copy = os.path.join(self.folder.name, "copy.h5")
        subprocess.run([SAMPLE, self.path, "30", "zstd"], check=True)

    def check_same(self):
        one, other = rc.Container(self.path), rc.Container(self.copy)
        self.assertEqual(len(one.nodes), len(other.nodes))
        for i in range(len(one.nodes)):
            self.assertEqual(one.payload(i), other.payload(i))

    def test_a_group_of_another_file_is_read(self):
        with h5py.File(self.path) as source, h5py.File(self.copy, "w") as target:
            target.create_group("something else")
            target.copy(source["/"], "statue")
        self.check_same()
        with h5py.File(self.path) as source, h5py.File(self.copy, "a") as target:
            target.copy(source["/"], "another")
        self.assertIn("expected one container", run(self.copy).stderr)

    def test_objects_with_the_roots_attributes_are_read(self):
        with h5py.File(self.path) as source, h5py.File(self.copy, "w") as target:
            for name in source:
                source.copy(name, target)
        self.assertIn("attributes of its root group", run(self.copy).stderr)
        with h5py.File(self.path) as source, h5py.File(self.copy, "a") as target:
            for name, value in source.attrs.items():
                target.attrs[name] = value
        self.check_same()

    def test_chunks_encoded_anew_are_read(self):
        with h5py.File(self.path) as source, h5py.File(self.copy, "w") as target:
            target.copy(source["/"], "statue")
            container = rc.Container(self.path)
            for name in list(target["statue/chunks"]):
                size = source[f"chunks/{name}"].shape[0]
                data = numpy.zeros(size, dtype="u1")
                capacity = source[f"chunks/{name}"].chunks[0]
                for i, node in enumerate(container.nodes):
                    if f"class_{node['chunk_class']}" == name:
                        payload = numpy.frombuffer(container.payload(i), dtype="u1")
                        start = int(node["chunk_index"]) * capacity
                        data[start:start + len(payload)] = payload
                del target[f"statue/chunks/{name}"]
                target.create_dataset(f"statue/chunks/{name}", data=data, chunks=(capacity,), compression="gzip")
        self.check_same()


class Program(unittest.TestCase):
    codec = "zstd"

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = os.path.join(self.folder.name, "a.h5")
        self.ply = os.path.join(self.folder.name, "out.ply")
        subprocess.run([SAMPLE, self.path, "0", self.codec], check=True)

    def test_lists_levels_and_nodes(self):
        result = run(self.path)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("schema 1.2, scheme diamonds, 2 nodes", result.stdout)
        result = run(self.path, "--nodes")
        self.assertIn("level  1 centre (512, 512, 0) triangles 6 vertices 12", result.stdout)

    def check_root(self, vertices, faces):
        # By hand: the Kuhn simplices of the cube of side 1024 in lexicographic order of their corners are
        # 0: 000 00S 0SS SSS, 1: 000 00S S0S SSS, 2: 000 0S0 0SS SSS, 3: 000 0S0 SS0 SSS.
        s = 1024
        corners = [[(0, 0, 0), (0, 0, s), (0, s, s), (s, s, s)], [(0, 0, 0), (0, s, 0), (s, s, 0), (s, s, s)]]
        for t, tetrahedron in enumerate(corners):
            lattice = list(tetrahedron) + [(s / 2, s / 2, s / 2)]
            w = (1, 2, 3, 4090)
            lattice.append(tuple(sum(w[i] * tetrahedron[i][a] for i in range(4)) / 4096 for a in range(3)))
            for v, point in enumerate(lattice):
                world = tuple(o + 0.25 * p for o, p in zip((10, -20, 0.5), point))
                self.assertEqual(vertices[6 * t + v][:3], world, (t, v))
                self.assertEqual(vertices[6 * t + v][6:], (v, 10 + v, 20 + v, 30 + v))
            self.assertEqual([f[1:] for f in faces[3 * t:3 * t + 3]],
                             [tuple(6 * t + i for i in f) for f in ((0, 1, 2), (3, 4, 5), (2, 0, 5))])
        self.assertEqual(vertices[1][3:6], (0, 0, -1))

    def test_decodes_a_level(self):
        result = run(self.path, "--level", "0", "-o", self.ply)
        self.assertEqual(result.returncode, 0, result.stderr)
        vertices, faces = read_ply(self.ply)
        self.assertEqual((len(vertices), len(faces)), (12, 6))
        self.check_root(vertices, faces)

    def test_decodes_leaves_and_chosen_nodes(self):
        for arguments in (["--finest"], ["--node", "1"]):
            self.assertEqual(run(self.path, *arguments, "-o", self.ply).returncode, 0)
            vertices, _ = read_ply(self.ply)
            # Place 1 of the diamond with centre (512, 512, 0): corners 000, 0S0, (S/2, S/2, S/2), SS0.
            expected = [(0, 0, 0), (0, 1024, 0), (512, 512, 512), (1024, 1024, 0)]
            self.assertEqual([v[:3] for v in vertices[:4]],
                             [tuple(o + 0.25 * p for o, p in zip((10, -20, 0.5), c)) for c in expected])
        self.assertEqual(run(self.path, "--node", "0", "--node", "1", "-o", self.ply).returncode, 0)
        vertices, faces = read_ply(self.ply)
        self.assertEqual((len(vertices), len(faces)), (24, 12))
        self.check_root(vertices, faces)

    def test_decodes_a_thousand_nodes(self):
        subprocess.run([SAMPLE, self.path, "1000", "zstd"], check=True)
        result = run(self.path, "--level", "15", "-o", self.ply)
        self.assertIn("1000 nodes, 36000 vertices, 18000 triangles", result.stdout)

    def test_damage_is_named(self):
        with h5py.File(self.path) as file:
            offset = int(file["nodes"]["offset"][1])
        with open(self.path, "r+b") as file:
            file.seek(offset)
            file.write(b"\0\0\0\0")
        result = run(self.path, "--node", "1", "-o", self.ply)
        self.assertEqual(result.returncode, 65)
        self.assertIn("read_container.py: ", result.stderr)
        self.assertNotIn("Traceback", result.stderr)

    def test_foreign_files_are_refused(self):
        with h5py.File(os.path.join(self.folder.name, "b.h5"), "w"):
            pass
        self.assertIn("no Colossus container", run(os.path.join(self.folder.name, "b.h5")).stderr)
        self.assertEqual(run(os.path.join(self.folder.name, "missing.h5")).returncode, 65)


class Blocks(unittest.TestCase):
    """The root cube of side 2^9 and its child at the origin, laid out by hand in sample_container.cpp."""
    codec = "zstd"

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = os.path.join(self.folder.name, "a.h5")
        self.ply = os.path.join(self.folder.name, "out.ply")
        subprocess.run([SAMPLE, self.path, "blocks", self.codec], check=True)

    def test_lists_scheme_and_parameters(self):
        result = run(self.path)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("scheme blocks, 2 nodes", result.stdout)
        self.assertIn("parameter sigma0 = 0.25", result.stdout)
        self.assertIn("parameter block_size = 4", result.stdout)

    def test_decodes_a_level(self):
        # The root has two vertices and no triangle, the child a fourth vertex that no triangle uses.
        for level, lattice, triangles in ((0, [], []),
                                          (1, [(5, 20, 300), (10, 21, 0), (261, 20, 0)], [(0, 1, 2), (2, 1, 0)])):
            result = run(self.path, "--level", str(level), "-o", self.ply)
            self.assertEqual(result.returncode, 0, result.stderr)
            vertices, faces = read_ply(self.ply)
            self.assertEqual([v[:3] for v in vertices],
                             [tuple(o + 0.25 * p for o, p in zip((10, -20, 0.5), point)) for point in lattice])
            self.assertEqual([f[1:] for f in faces], triangles)
            if level == 1:
                self.assertEqual([v[6:] for v in vertices], [(v, 10 + v, 20 + v, 30 + v) for v in range(3)])

    def test_parents_are_vertices_of_the_parent_cube(self):
        container = rc.Container(self.path)
        root, child = (rc.decode_payload(container.payload(i))["parts"][0] for i in range(2))
        self.assertIsNone(root["parents"])
        self.assertEqual(child["parents"].tolist(), [0, 1, 1, 0])
        self.assertEqual(root["positions"][child["parents"]].tolist(),
                         [[0, 0, 300], [256, 0, 0], [256, 0, 0], [0, 0, 300]])
        self.assertEqual((rc.used_vertices(child["triangles"]), len(child["positions"])), (3, 4))


class ProgramForPaper(Program):
    codec = "paper"


class BlocksForPaper(Blocks):
    codec = "paper"


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
