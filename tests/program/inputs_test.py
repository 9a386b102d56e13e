"""Inputs as they occur: colours of every scale and place, polygons that are not convex, and files that differ from the letter
of their format. Whatever is read must come out, and whatever is not kept must be said; anything else is refused by name."""
import bz2
import gzip
import io
import lzma
import os
import re
import signal
import zipfile

import numpy as np

import check_closed
import faults
import meshes
import program
from check_closed import Census, Mesh
from writers import RGB, columns, obj, off, ply, stl_binary, stl_text, word

SCHEMES = ("diamonds", "blocks")
BUILD = ("--leaf-triangles", 500, "--position-bits", 16)
WHITE = 255.0


def torus(around=24, along=12, at=(0, 0, 0)):
    mesh = meshes.tube(around, along)
    return Mesh(mesh.points + at, mesh.triangles)


def shades(mesh, top=240):
    """A colour for every vertex, without a sudden change: whole numbers up to `top`, which occurs."""
    x, y, z = (mesh.points - mesh.points.mean(axis=0)).T
    wave = np.stack([1 + np.sin(x), 1 + np.sin(2 * y + 1), 1 + np.cos(z + y)], 1) / 2
    return np.rint(wave / wave.max() * top).astype(int)


def volume(mesh):
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def mean_color(mesh, colors):
    """Over the surface."""
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return (np.asarray(colors, float)[mesh.triangles].mean(axis=1) * areas[:, None]).sum(axis=0) / areas.sum()


class Expected:
    """What must come out. volume: None for what is open; color: None if there are none."""

    def __init__(self, area, volume, points, triangles, color=None):
        self.area, self.volume, self.triangles, self.color = area, volume, triangles, color
        self.low, self.high = np.min(points, axis=0), np.max(points, axis=0)


def expected(mesh, colors=None, closed=True):
    used = mesh.points[np.unique(mesh.triangles)]
    return Expected(check_closed.area(mesh), volume(mesh) if closed else None, used, len(mesh.triangles),
                    None if colors is None else mean_color(mesh, colors))


def counted(name, count, first=None, about=""):
    """A line about a file, with a count and the number of the first vertex, in any order."""
    of_first = "" if first is None else rf"(?=.*\bvertex {first}\b)"
    return rf"(?i){re.escape(name)}(?=.*\b{count}\b){of_first}(?=.*{about})"


def skipped(name, what):
    return rf"(?i)input \S*{re.escape(name)}: [^\n]*(?:{what})[^\n]* (?:is|are) skipped"


class InputTest(program.ColossusTest):
    cases = 0  # of a test

    def put(self, name, data):
        with open(self.path(name), "wb") as file:
            file.write(data)
        return self.path(name)

    def next_run(self):
        """A scheme, and a number of ranks: in turn."""
        self.cases += 1
        return SCHEMES[self.cases % 2], 3 if self.cases % 9 == 4 else 0

    def read(self, inputs, want, *options, warns=(), says=(), never=(), may_warn=(), both=False):
        """Builds, verifies, extracts. Of the warnings each must match one of `warns` or `may_warn`, and each of `warns` one of
        them; `says` must be in what is printed, `never` must not. Returns the finest level."""
        inputs = [inputs] if isinstance(inputs, str) else inputs
        scheme, ranks = self.next_run()
        for scheme in SCHEMES if both else (scheme,):
            output = self.path("out.h5")
            run = self.run_program("build", *inputs, "-o", output, "--scheme", scheme, *BUILD, *options, ranks=ranks)
            warnings = [line for line in run.stderr.splitlines() if line.startswith("colossus: warning: ")
                        and not re.search("level [0-9]+ does not shrink", line)]  # so small are these
            for warning in warnings:
                self.assertTrue(any(re.search(w, warning) for w in (*warns, *may_warn)), f"unexpected: {warning}")
            for pattern in warns:
                self.assertTrue(any(re.search(pattern, w) for w in warnings), f"no warning {pattern!r} in {warnings}")
            for pattern in says:
                self.assertRegex(run.stdout + run.stderr, pattern)
            for pattern in never:
                self.assertNotRegex(run.stdout + run.stderr, pattern)
            same = [o for o in options if o in ("--lenient", "--drop-textures")]
            self.run_program("verify", output, "--against", *inputs, *same)
            cut = self.check(output, want)
        return cut

    def check(self, output, want):
        info = self.info(output)
        self.assertEqual(info["counts"]["triangles"], want.triangles)
        cut = self.finest(output)
        self.assertGreater(len(cut.triangles), 0)
        if want.area is not None:
            self.assertAlmostEqual(check_closed.area(cut) / want.area, 1, delta=5e-4)
        reach = 2 * (info["quantisation_error"] + info["lattice_error"])
        self.assertLess(reach, 1e-3 * np.max(want.high - want.low))
        used = cut.points[np.unique(cut.triangles)]
        self.assertLessEqual(np.abs(used.min(axis=0) - want.low).max(), reach)
        self.assertLessEqual(np.abs(used.max(axis=0) - want.high).max(), reach)
        if want.volume is not None:
            self.assertTrue(Census(cut).is_closed, str(Census(cut)))
            self.assertAlmostEqual(volume(cut) / want.volume, 1, delta=2e-3)
        self.assertEqual(info["attributes"]["colors"], want.color is not None)
        if want.color is not None:
            found = mean_color(cut, np.stack([cut.attributes[name] for name in RGB], 1))
            self.assertLess(np.abs(found - want.color).max(), 1.5, f"{found} instead of {want.color}")
        return cut

    def refuse(self, path, *patterns, options=(), ranks=None):
        """Status 65, an error that names the file and matches all patterns, and nothing left behind."""
        scheme, some_ranks = self.next_run()
        before = sorted(os.listdir(self.folder))
        run = self.run_program("build", path, "-o", self.path("bad.h5"), "--scheme", scheme, *options,
                               ranks=some_ranks if ranks is None else ranks, status=program.BAD_DATA)
        errors = [line for line in run.stderr.splitlines() if line.startswith("colossus: error: ")]
        self.assertTrue(errors, run.stderr)
        for pattern in (re.escape(os.path.basename(path)), *patterns):
            self.assertTrue(any(re.search(pattern, e) for e in errors), f"{pattern!r} is not in {errors}")
        self.assertEqual(sorted(os.listdir(self.folder)), before, "something is left behind")


def numbers(colors):
    return lambda i: "".join(" " + word(x) for x in colors[i])


class Colors(InputTest):
    def test_scale_of_floats(self):
        mesh = torus()
        whole = shades(mesh, 255)
        unit = whole / 255.0
        more = np.concatenate([whole, np.full((len(whole), 1), 255)], 1)
        over, barely = unit.copy(), unit.copy()
        over[17, 1], barely[-1, 2] = 1.003922, 1.02
        dark = unit.copy()
        dark[5, 0] = 1.03  # so it cannot be a unit
        single = np.zeros_like(unit)
        single[-1, 0] = 254.0
        black = np.zeros_like(unit)
        ones = (np.arange(len(unit))[:, None] % [2, 3, 5] == 0).astype(int)
        rgb = lambda kind, values: columns(RGB, kind, values)
        clamp = lambda values: np.clip(values * 255, 0, 255)
        one, all_ = "colours from 0 to 1(?![0-9])", "colours from 0 to 255"
        for name, data, colors, says in (
                ("a.ply", ply(mesh, True, rgb("double", unit)), whole, one),
                ("b.ply", ply(mesh, False, rgb("float", unit)), whole, one),
                ("c.ply", ply(mesh, False, rgb("double", barely)), clamp(barely), one),
                ("d.ply", ply(mesh, False, rgb("float", whole)), whole, all_),
                ("e.ply", ply(mesh, True, rgb("double", whole.astype(float))), whole, all_),
                ("f.ply", ply(mesh, False, rgb("float", dark), order=">"), dark, all_),
                ("g.ply", ply(mesh, False, rgb("double", single)), single, all_),
                ("h.ply", ply(mesh, True, rgb("float", black)), black, one),
                ("i.ply", ply(mesh, False, columns((*RGB, "alpha"), "double", more / 255.0)), whole, one),
                ("j.ply", ply(mesh, False, columns((*RGB, "alpha"), "float", more)), whole, all_),
                ("k.obj", obj(mesh, behind=numbers(unit)), whole, one),
                ("l.obj", obj(mesh, behind=numbers(over)), clamp(over), one),
                ("m.obj", obj(mesh, behind=numbers(whole)), whole, all_),
                ("n.obj", obj(mesh, behind=numbers(dark)), dark, all_),
                ("o.off", off(mesh, "COFF\n", behind=numbers(more / 255.0)), whole, one),
                ("p.off", off(mesh, "COFF\n", behind=numbers(whole)), whole, all_),
                ("q.off", off(mesh, "COFF\n", behind=numbers(ones)), ones * 255, one),
                ("r.off", off(mesh, "COFF\n", behind=numbers(whole.astype(float))), whole, all_)):
            with self.subTest(name):
                self.read(self.put(name, data), expected(mesh, colors), says=(rf"input \S*{re.escape(name)}.*{says}",),
                          never=(all_ if says == one else one,))
        for name, make in (("s.ply", lambda v: ply(mesh, True, rgb("double", v))),
                           ("t.ply", lambda v: ply(mesh, False, rgb("float", v))),
                           ("u.obj", lambda v: obj(mesh, behind=numbers(v))),
                           ("v.off", lambda v: off(mesh, "COFF\n", behind=numbers(v)))):
            for greatest in (256.0, 65535.0):
                with self.subTest(name, greatest=greatest):
                    values = unit.copy()
                    values[200, 1] = greatest
                    self.refuse(self.put(name, make(values)), "colour", str(int(greatest)))

    def test_integers(self):
        mesh = torus()
        whole = shades(mesh, 255)
        dim = (whole > 128).astype(int)
        wild = whole * 3 - 200
        for kind, values, colors in (("uchar", whole, whole), ("uchar", dim, dim), ("ushort", whole * 257, whole),
                                     ("ushort", dim * 257, dim), ("short", wild, np.clip(wild, 0, 255)),
                                     ("int", whole, whole),
                                     ("int", wild * 1000, np.clip(wild * 1000, 0, 255)),
                                     ("uint", whole * 2, np.minimum(whole * 2, 255)),
                                     ("char", whole // 2 - 40, np.maximum(whole // 2 - 40, 0)), ("uint", dim, dim)):
            for text in (False, True):
                with self.subTest(kind=kind, text=text):
                    path = self.put("in.ply", ply(mesh, text, columns(RGB, kind, values)))
                    self.read(path, expected(mesh, colors), never=("colours from 0 to",))

    def test_that_are_no_numbers(self):
        mesh = torus()
        whole = shades(mesh)
        unit = whole / 255.0
        at = [31, 77, 200]
        white = whole.copy()
        white[at] = 255
        holes = unit.copy()
        holes[at, 1] = np.nan
        for name, data in (("a.ply", ply(mesh, False, columns(RGB, "float", holes))),
                           ("b.ply", ply(mesh, False, columns(RGB, "double", holes), order=">")),
                           ("c.ply", ply(mesh, True, columns(RGB, "float", holes))),
                           ("d.obj", obj(mesh, behind=numbers(holes))),
                           ("e.off", off(mesh, "COFF\n", behind=numbers(holes)))):
            with self.subTest(name):
                self.read(self.put(name, data), expected(mesh, white), warns=(counted(name, 3, 31, "colou?r"),),
                          says=("colours from 0 to 1(?![0-9])",))
        for words in ("nan", "NaN", "-nan", "-nan(ind)", "-1.#IND", "1.#QNAN", "nan(snan)"):
            with self.subTest(words):
                rows = [[words] * 3 if i in at else list(c) for i, c in enumerate(unit)]
                self.read(self.put("w.ply", ply(mesh, True, columns(RGB, "float", rows))), expected(mesh, white),
                          warns=(counted("w.ply", 3, 31, "colou?r"),))

    def test_normals_that_are_no_numbers(self):
        mesh = torus()
        ring = mesh.points * (1, 1, 0)
        right = mesh.points - ring / np.linalg.norm(ring, axis=1)[:, None]
        right /= np.linalg.norm(right, axis=1)[:, None]
        at = [40, 41, 90, 287]
        names = ("nx", "ny", "nz")
        holes = right.copy()
        holes[at] = np.nan
        files = [(f"{kind}{order == '<'}.ply", ply(mesh, False, columns(names, kind, holes), order=order))
                 for kind in ("float", "double") for order in "<>"]
        for number, words in enumerate(("nan", "-1.#IND", "1.#QNAN", "-nan(ind)", "-1.#IND00", "NAN")):
            rows = [[words] * 3 if i in at else list(n) for i, n in enumerate(right)]
            files.append((f"{number}.ply", ply(mesh, True, columns(names, "float", rows))))
        data = "".join("vn " + " ".join(map(word, n)) + "\n" for n in holes).encode()
        faces = "".join("f " + " ".join(f"{v + 1}//{v + 1}" for v in f) + "\n" for f in mesh.triangles)
        files.append(("n.obj", obj(mesh, faces=[]) + data + faces.encode()))
        files.append(("n.off", off(mesh, "NOFF\n", behind=numbers(holes))))
        for name, data in files:
            with self.subTest(name):
                cut = self.read(self.put(name, data), expected(mesh), warns=(counted(name, 4, 40, "normal"),))
                found = np.stack([cut.attributes[n] for n in names], 1)
                self.assertTrue(np.isfinite(found).all())
                ring = cut.points * (1, 1, 0)
                outward = cut.points - ring / np.linalg.norm(ring, axis=1)[:, None]
                self.assertGreater((outward * found).sum(axis=1).min(), 0.2)

    def test_some_files_have_none(self):
        left, right = torus(), torus(at=(3, 0, 0))
        colors = shades(left)
        none = np.full_like(colors, 255)
        both = meshes.join(left, right)
        with_, without = columns(RGB, "uchar", colors), ()
        for name, first, second, all_colors, bare in (
                ("ply", ("a.ply", ply(left, False, with_)), ("b.ply", ply(right)), (colors, none), ["b.ply"]),
                ("the other way", ("c.ply", ply(left)), ("d.ply", ply(right, False, with_)), (none, colors), ["c.ply"]),
                ("obj", ("e.obj", obj(left, behind=numbers(colors / 255.0))), ("f.obj", obj(right)), (colors, none),
                 ["f.obj"]),
                ("stl", ("g.ply", ply(left, False, with_)), ("h.stl", stl_binary(right)), (colors, none), ["h.stl"]),
                ("off", ("i.off", off(left, "COFF\n", behind=numbers(colors))), ("j.off", off(right)), (colors, none),
                 ["j.off"]),
                ("stl in text", ("k.stl", stl_text(left, normal="0 0 0")), ("l.ply", ply(right, True, with_)),
                 (none, colors), ["k.stl"])):
            with self.subTest(name):
                paths = [self.put(*first), self.put(*second)]
                self.read(paths, expected(both, np.concatenate(all_colors)), warns=[rf"{b}.*(?i:colou?r)" for b in bare],
                          never=[rf"warning: [^\n]*{b}" for b in (first[0], second[0]) if b not in bare])
        with self.subTest("none has any"):
            self.read([self.put("m.ply", ply(left)), self.put("n.ply", ply(right))], expected(both))
        with self.subTest("three"):
            third = torus(at=(0, 3, 0))
            paths = [self.put("o.ply", ply(left)), self.put("p.obj", obj(right)),
                     self.put("q.ply", ply(third, False, with_))]
            self.read(paths, expected(meshes.join(both, third), np.concatenate([none, none, colors])),
                      warns=("o.ply.*colou?r", "p.obj.*colou?r"))

    def test_some_vertices_of_an_obj_have_none(self):
        mesh = torus()
        whole = shades(mesh, 255)
        for name, has, scale in (("the first object", np.arange(288) < 100, 1),
                                 ("the second object", np.arange(288) >= 200, 255),
                                 ("every third", np.arange(288) % 3 == 0, 1), ("all but the last", np.arange(288) < 287, 1),
                                 ("one", np.arange(288) == 42, 255)):
            with self.subTest(name):
                values = whole / 255.0 if scale == 1 else whole
                data = obj(mesh, behind=lambda i: numbers(values)(i) if has[i] else "")
                colors = np.where(has[:, None], whole, 255)
                self.read(self.put("in.obj", data), expected(mesh, colors),
                          warns=(counted("in.obj", int((~has).sum()), None, "colou?r")
                          + f"|in.obj.*{int(has.sum())} of 288.*colou?r|in.obj.*colou?r.*{int(has.sum())} of 288",))

    def test_of_faces(self):
        """They become those of the vertices."""
        near, far = torus(), torus(at=(3, 0, 0))
        mesh = meshes.join(near, far)
        count = len(near.triangles)
        two = np.where(np.arange(2 * count)[:, None] < count, (200, 60, 30), (10, 20, 250))
        halves = np.where(np.arange(2 * count)[:, None] % (count // 2) < count // 4, (255, 0, 90), (0, 140, 255))
        for name, values in (("one", np.full((2 * count, 3), (12, 180, 77))), ("two", two), ("halves", halves)):
            colors, averaged = self.around_vertices(mesh, values)
            says = [rf"(?i)\b{averaged}\b[^\n]*averag|averag[^\n]*\b{averaged}\b"] if averaged else []
            never = [] if averaged else ["(?i)averag"]
            paint = lambda kind, v: columns(RGB, kind, v)
            for data, file in ((ply(mesh, True, face=paint("uchar", values)), "a.ply"),
                               (ply(mesh, False, face=paint("uchar", values)), "b.ply"),
                               (ply(mesh, False, face=paint("float", values / 255.0), order=">"), "c.ply"),
                               (ply(mesh, True, face=paint("double", values / 255.0)), "d.ply"),
                               (ply(mesh, False, face=paint("ushort", values * 257)), "e.ply"),
                               (off(mesh, face_behind=numbers(values)), "f.off"),
                               (off(mesh, face_behind=numbers(values / 255.0)), "g.off"),
                               (off(mesh, face_behind=lambda i: numbers(values)(i) + " 255"), "h.off")):
                with self.subTest(name, file=file):
                    self.read(self.put(file, data), expected(mesh, colors), says=says, never=never, may_warn=("(?i)averag",))
                    # Corners are no vertices that were there, and count as none.
                    self.assertEqual(self.info(self.path("out.h5"))["counts"]["merged_vertices"], 0)
        with self.subTest("quads"):
            quads = [[a, b, c, d] for (a, b, c), (_, _, d) in zip(near.triangles[:288].tolist(),
                                                                  near.triangles[288:].tolist())]
            values = np.where(np.arange(288)[:, None] < 100, (255, 0, 0), (0, 0, 255))
            colors, averaged = self.around_vertices(near, np.concatenate([values, values]))
            for file, data in (("q.ply", ply(near, True, faces=quads, face=columns(RGB, "uchar", values))),
                               ("q.off", off(near, faces=quads, face_behind=numbers(values)))):
                self.read(self.put(file, data), expected(near, colors), may_warn=("(?i)averag",),
                          says=[rf"(?i)\b{averaged}\b[^\n]*averag|averag[^\n]*\b{averaged}\b"])

    def test_of_faces_in_several_groups(self):
        """The same corners of the same vertices, once per group of 2^17 triangles, are different ones."""
        mesh = torus(512, 256)
        values = np.where(np.arange(1 << 18)[:, None] < 1 << 17, (255, 0, 90), (0, 140, 255))
        colors, _ = self.around_vertices(mesh, values)
        path = self.put("in.ply", ply(mesh, False, face=columns(RGB, "uchar", values)))
        cut = self.read(path, expected(mesh, colors), may_warn=("(?i)averag",))
        # Three triangles of each colour around every vertex.
        self.assertLessEqual(max(np.ptp(cut.attributes[name].astype(int)) for name in RGB), 1)

    def test_of_faces_that_are_read_again(self):
        """Since the last one is no triangle, and ends like padding: what had been found in parts of them counts once."""
        mesh = torus(400, 200)
        half = len(mesh.triangles) // 2
        faces = mesh.triangles.tolist()
        faces = faces[:half - 1] + faces[half:-1] + [faces[half - 1] + [faces[-1][2]]]
        values = np.full((len(faces), 3), 0.5)
        values[5] = np.nan
        values[-1, 2] = 0
        path = self.put("in.ply", ply(mesh, False, faces=faces, face=columns(RGB, "float", values)))
        for ranks in 0, 3:
            run = self.run_program("build", path, "-o", self.path("out.h5"), "--dry-run", ranks=ranks)
            self.assertRegex(run.stderr, "1 face with a colour that is not a number, .* the first is face 5")

    @staticmethod
    def around_vertices(mesh, of_faces):
        """The mean of the triangles around each vertex, and how many vertices have different ones."""
        total, uses = np.zeros((len(mesh.points), 3)), np.zeros(len(mesh.points))
        least, most = np.full((len(mesh.points), 3), 1e9), np.full((len(mesh.points), 3), -1e9)
        for k in range(3):
            at = mesh.triangles[:, k]
            np.add.at(total, at, of_faces)
            np.add.at(uses, at, 1)
            np.minimum.at(least, at, of_faces)
            np.maximum.at(most, at, of_faces)
        return total / uses[:, None], int((least != most).any(axis=1).sum())

    def test_of_binary_stl(self):
        near, far = torus(), torus(at=(3, 0, 0))
        mesh = meshes.join(near, far)
        count = len(near.triangles)
        half = np.arange(2 * count) < count
        five = lambda rgb: tuple(round(x * 31 / 255) for x in rgb)
        vis = lambda rgb: 0x8000 | five(rgb)[0] << 10 | five(rgb)[1] << 5 | five(rgb)[2]
        magics = lambda rgb: five(rgb)[0] | five(rgb)[1] << 5 | five(rgb)[2] << 10
        wide = lambda rgb: np.array([x * 255 / 31 for x in five(rgb)])
        red, blue, mixed = (255, 0, 0), (8, 24, 230), (90, 200, 140)
        head = b"made up COLOR=" + bytes((40, 170, 220, 255)) + b" MATERIAL=" + bytes(12)
        each = lambda a, b: np.repeat([a, b], [len(near.points), len(far.points)], axis=0)
        cases = [("viscam one", b"", np.full(2 * count, vis(mixed)), each(wide(mixed), wide(mixed))),
                 ("viscam red", b"solid is no text", np.full(2 * count, vis(red)), each(wide(red), wide(red))),
                 ("viscam two", b"", np.where(half, vis(blue), vis(mixed)), each(wide(blue), wide(mixed))),
                 ("viscam some", b"", np.where(half, vis(blue), 0), each(wide(blue), np.full(3, WHITE))),
                 ("magics two", head, np.where(half, magics(red), magics(mixed)), each(wide(red), wide(mixed))),
                 ("magics blue", head, np.full(2 * count, magics(blue)), each(wide(blue), wide(blue))),
                 ("magics of the header", head, np.full(2 * count, 0x8000), each((40, 170, 220), (40, 170, 220))),
                 ("magics of the header and a colour still", head, np.full(2 * count, 0x8000 | magics(red)),
                  each((40, 170, 220), (40, 170, 220))),
                 ("magics some of the header", head, np.where(half, 0x8000, magics(mixed)),
                  each((40, 170, 220), wide(mixed)))]
        for name, header, attributes, colors in cases:
            with self.subTest(name):
                self.read(self.put("in.stl", stl_binary(mesh, header, attributes)), expected(mesh, colors),
                          never=("(?i)averag",),
                          may_warn=("in.stl.*colou?r",) if "some" in name else ())
        with self.subTest("halves"):
            side = np.arange(2 * count) % (count // 2) < count // 4
            colors, averaged = self.around_vertices(mesh, np.where(side[:, None], wide(red), wide(blue)))
            self.read(self.put("in.stl", stl_binary(mesh, b"", np.where(side, vis(red), vis(blue)))), expected(mesh, colors),
                      may_warn=("(?i)averag",), says=[rf"(?i)\b{averaged}\b[^\n]*averag|averag[^\n]*\b{averaged}\b"],
                      both=True)
        with self.subTest("none"):
            self.read(self.put("in.stl", stl_binary(mesh, b"anything")), expected(mesh))

    def test_of_vertices_and_faces(self):
        """Those of the vertices stay."""
        mesh = torus()
        whole = shades(mesh)
        red = np.full((len(mesh.triangles), 3), (255, 0, 0))
        painted = columns(RGB, "uchar", red)
        for name, data, says in (
                ("a.ply", ply(mesh, True, columns(RGB, "uchar", whole), painted), r"face\.red"),
                ("b.ply", ply(mesh, False, columns(RGB, "float", whole / 255.0), painted), r"face\.blue"),
                ("c.ply", ply(mesh, True, columns(RGB, "float", whole / 255.0), columns(RGB, "float", red / 255.0)),
                 r"face\.green"),
                ("d.off", off(mesh, "COFF\n", behind=numbers(whole), face_behind=numbers(red)),
                 "face.*colou?r|colou?r.*face"),
                ("e.off", off(mesh, "COFF\n", behind=numbers(whole / 255.0), face_behind=lambda i: " 1.0 0.0 0.0 1.0"),
                 "face.*colou?r|colou?r.*face")):
            with self.subTest(name):
                self.read(self.put(name, data), expected(mesh, whole), says=(skipped(name, says),), never=("(?i)averag",))

    def test_what_is_not_kept_is_listed(self):
        mesh = torus()
        n, m = len(mesh.points), len(mesh.triangles)
        extra = [("quality", "float", [0.5] * n), ("confidence", "double", [1.0] * n), ("intensity", "uchar", [7] * n)]
        flags = [("flags", "int", [3] * m), ("material_index", "ushort", [1] * m)]
        element = ("element edge 2", "property int vertex1", "property int vertex2")
        behind = lambda data, rows: data.replace(b"end_header\n", "\n".join(element).encode() + b"\nend_header\n") + rows
        lines = "g left side\no a thing\ns 4\n"
        for name, data, what in (
                ("a.ply", ply(mesh, True, extra, flags), (r"vertex\.quality", r"vertex\.confidence", r"vertex\.intensity",
                                                          r"face\.flags", r"face\.material_index")),
                ("b.ply", ply(mesh, False, extra[:1], flags[:1]), (r"vertex\.quality", r"face\.flags")),
                ("c.ply", behind(ply(mesh, True), b"0 1\n1 2\n"), ("element edge",)),
                ("d.ply", behind(ply(mesh, False), bytes(16)), ("element edge",)),
                ("e.ply", ply(mesh, False, header=("obj_info num_cols 24", "comment nothing")), ("obj_info",)),
                ("f.ply", ply(mesh, True, header=("obj_info from a scanner",)), ("obj_info",)),
                ("g.stl", stl_text(mesh), ("facet normals",)),
                ("h.stl", stl_binary(mesh, normal=(0, 0.6, 0.8)), ("facet normals",)),
                ("i.obj", obj(mesh, between=lines), (r"\bg\b|group", r"\bo\b|object", r"\bs\b|smooth")),
                ("j.obj", obj(mesh, after="l 1 2 3\np 4\np 5\n"), (r"\bl\b", r"\bp\b")),
                ("k.obj", obj(mesh, before="g\n", after="vp 0.1 0.2\ncstype bezier\nlod 1\n"),
                 (r"\bg\b|group", r"\bvp\b", r"\bcstype\b", r"\blod\b")),
                ("l.off", off(mesh, behind=lambda i: " 0.25"), ("number|column",)),
                ("m.off", off(mesh, behind=lambda i: " 3 4"), ("number|column",))):
            with self.subTest(name):
                self.read(self.put(name, data), expected(mesh), says=[skipped(name, w) for w in what])
        with self.subTest("nothing"):
            self.read(self.put("z.ply", ply(mesh)), expected(mesh), never=("is skipped",))


# Outlines, from above against the clock; equal corners are one vertex.
def around(count, radius):
    return [(radius(i) * np.cos(2 * np.pi * i / count), radius(i) * np.sin(2 * np.pi * i / count)) for i in range(count)]


def band(count, turns):
    """A spiral, there and back."""
    there = [(1 + 4 * i / count, 2 * np.pi * turns * i / count) for i in range(count + 1)]
    back = [(r - 1.6 / turns, a) for r, a in reversed(there)]
    return [(r * np.cos(a), r * np.sin(a)) for r, a in there + back]


def comb(teeth):
    return [(0, -1), (2 * teeth,
                      -1)] + [p for i in reversed(range(teeth)) for p in ((2 * i + 2, 0), (2 * i + 1.5, 3 + i % 3),
                                                                          (2 * i + 1, 0))] + [(0, 0)]


SQUARE = [(0, 0), (6, 0), (6, 6), (0, 6)]
OUTLINES = {
    "chevron": [(0, 0), (2, 1), (4, 0), (2, 4)],
    "chevron of another corner": [(2, 4), (0, 0), (2, 1), (4, 0)],
    "L": [(0, 0), (4, 0), (4, 1), (1, 1), (1, 5), (0, 5)],
    "U": [(0, 0), (5, 0), (5, 4), (4, 4), (4, 1), (1, 1), (1, 4), (0, 4)],
    "T with flat corners": [(0, 4), (1, 4), (2, 4), (2, 2), (2, 0), (3, 0), (3, 2), (3, 4), (4, 4), (5, 4), (5, 5), (2.5, 5),
                            (0, 5)],
    "plus": [(1, 0), (2, 0), (2, 1), (3, 1), (3, 2), (2, 2), (2, 3), (1, 3), (1, 2), (0, 2), (0, 1), (1, 1)],
    "arrow": [(0, 0), (5, 2), (0, 4), (1, 2)],
    "star": around(10, lambda i: 3 if i % 2 == 0 else 1.1),
    "star of many": around(48, lambda i: 4 if i % 2 == 0 else 3.5 - i % 5 * 0.6),
    "crescent": around(40, lambda i: 3)[:31] + [(x * 0.7 + 0.4, y * 0.7 - 0.2) for x,
                                                y in reversed(around(40, lambda i: 3)[2:29])],
    "spiral": band(24, 2),
    "long spiral": band(60, 4),
    "comb": comb(5),
    "hole": [*SQUARE, (0, 0), (2, 2), (2, 4), (4, 4), (4, 2), (2, 2)],
    "two holes": [(0, 0), (6, 0), (6, 6), (5, 5), (5, 3), (3, 3), (3, 5), (5, 5), (6, 6), (0, 6),
                  (0, 0), (1, 1), (1, 2), (2, 2), (2, 1), (1, 1)],
}


class Piece:
    """Polygons over points, and what they measure."""

    def __init__(self, points, faces, area, volume):
        self.points, self.faces, self.area, self.volume = np.asarray(points, float), faces, area, volume

    def moved(self, turn, by):
        return Piece(self.points @ turn.T + by, self.faces, self.area, self.volume)

    def mesh(self):
        """The points only: what the writers need beside faces."""
        return Mesh(self.points, np.zeros((0, 3), int))

    def want(self):
        used = self.points[sorted({v for f in self.faces for v in f})]
        return Expected(self.area, self.volume, used, sum(len(f) - 2 for f in self.faces))


def together(pieces):
    faces, start = [], 0
    for piece in pieces:
        faces += [[v + start for v in f] for f in piece.faces]
        start += len(piece.points)
    return Piece(np.concatenate([p.points for p in pieces]), faces, sum(p.area for p in pieces),
                 None if pieces[0].volume is None else sum(p.volume for p in pieces))


def outline(corners, first=0):
    """The points, the corners as indices from the `first` on, area, and sides that are not run through twice."""
    points = list(dict.fromkeys((float(x), float(y)) for x, y in corners))
    index = [points.index((float(x), float(y))) for x, y in corners]
    index = index[first:] + index[:first]
    sides = list(zip(index, index[1:] + index[:1]))
    area = sum(points[a][0] * points[b][1] - points[b][0] * points[a][1] for a, b in sides) / 2
    if area < 0:
        index, sides, area = index[::-1], [(b, a) for a, b in sides], -area
    return np.array(points), index, area, [(a, b) for a, b in sides if (b, a) not in sides]


def plate(corners, first=0):
    """An open sheet: one polygon."""
    points, index, area, _ = outline(corners, first)
    return Piece(np.column_stack([points, 0 * points[:, 0]]), [index], area, None)


def solid(corners, height=1.5, first=0):
    """A closed prism."""
    points, index, area, sides = outline(corners, first)
    n = len(points)
    low, high = np.column_stack([points, 0 * points[:, 0]]), np.column_stack([points, 0 * points[:, 0] + height])
    walls = [[a, b, b + n, a + n] for a, b in sides]
    length = sum(np.linalg.norm(points[a] - points[b]) for a, b in sides)
    return Piece(np.concatenate([low, high]), [index[::-1], [v + n for v in index], *walls], 2 * area + height * length,
                 height * area)


def turn_of(seed):
    turn = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))[0]
    return turn * np.sign(np.linalg.det(turn))


WRITERS = {"text.ply": lambda p: ply(p.mesh(), True, faces=p.faces),
           "binary.ply": lambda p: ply(p.mesh(), False, faces=p.faces),
           "big.ply": lambda p: ply(p.mesh(), False, faces=p.faces, order=">", count="int", index="uint"),
           "in.obj": lambda p: obj(p.mesh(), faces=p.faces), "in.off": lambda p: off(p.mesh(), faces=p.faces)}


class Polygons(InputTest):
    def test_prisms(self):
        """Each stays closed, wherever its caps begin, and turned inside out too."""
        for number, (name, corners) in enumerate(OUTLINES.items()):
            file = list(WRITERS)[number % len(WRITERS)]
            for first in (0, 1 + number % (len(corners) - 1)):
                with self.subTest(name, first=first, file=file):
                    piece = solid(corners, first=first).moved(turn_of(number) if number % 3 else np.eye(3), (5, -7, 2))
                    if first % 2:
                        piece = Piece(piece.points, [f[::-1] for f in piece.faces], piece.area, -piece.volume)
                    self.read(self.put(file, WRITERS[file](piece)), piece.want(), both=number % 4 == 0)

    def test_sheets(self):
        """Every outline alone in its plane."""
        for number, (name, corners) in enumerate(OUTLINES.items()):
            file = list(WRITERS)[(number + 2) % len(WRITERS)]
            with self.subTest(name, file=file):
                piece = plate(corners, first=number % len(corners)).moved(turn_of(100 + number), (1, 2, 3))
                self.read(self.put(file, WRITERS[file](piece)), piece.want())

    def test_all_in_one(self):
        for seed, (file, write) in enumerate(WRITERS.items()):
            with self.subTest(file):
                solids = [solid(c, first=(k + seed) % len(c)).moved(turn_of(10 * seed + k),
                                                                    (15.0 * (k % 4), 15.0 * (k // 4), 0))
                          for k, c in enumerate(OUTLINES.values())]
                piece = together(solids)
                self.read(self.put(file, write(piece)), piece.want(), both=True)

    def test_in_several_files(self):
        pieces = [solid(OUTLINES["chevron"]).moved(np.eye(3), (10.0 * k, 0, 0)) for k in range(4)]
        paths = [self.put(f"{k}.ply", ply(piece.mesh(), False, faces=piece.faces)) for k, piece in enumerate(pieces)]
        self.read(paths, together(pieces).want(), both=True)

    def test_many_small_ones_far_away(self):
        """What the lattice rounds is neither warped nor crossing."""
        outlines = [OUTLINES[name] for name in ("chevron", "L", "U", "plus", "star", "hole")]
        pieces = [plate(outlines[k % len(outlines)]).moved(turn_of(k),
                                                           np.array([5e5 + 15 * (k % 20), 4e6 + 15 * (k // 20), 0]))
                  for k in range(400)]
        piece = together(pieces)
        for file in ("binary.ply", "in.obj"):
            with self.subTest(file):
                self.read(self.put(file, WRITERS[file](piece)), piece.want(), never=("(?i)warped|cross",))

    def test_of_many_corners(self):
        def gear(count):
            return around(count, lambda i: 3 if i % 2 == 0 else 2.7)
        for number, corners in enumerate((band(300, 7), gear(700), comb(50), around(100, lambda i: 3))):
            for file in ("text.ply", "big.ply", "in.obj", "in.off"):
                if file == "text.ply" and len(corners) > 255 or file == "in.off" and number % 2:
                    continue  # more than the counts of the first hold; and time
                with self.subTest(number, file=file):
                    piece = solid(corners, 2.0, first=number).moved(turn_of(number), (0, 0, 0))
                    self.read(self.put(file, WRITERS[file](piece)), piece.want())

    def test_warped_and_crossing_ones_are_counted(self):
        base = torus()
        square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
        bow_tie, uneven = square[[0, 2, 1, 3]], square[[0, 2, 1, 3]] * (1, .4,
                                                                        1) + np.array([(0, 0, 0), (0, .6, 0), (0, 0, 0), (0, 0, 0)])
        pentagram = np.array([(np.cos(4 * np.pi * i / 5), np.sin(4 * np.pi * i / 5), 0) for i in range(5)])
        saddle = square + [(0, 0, h) for h in (0, .5, 0, .5)]
        hexagon = np.array([(np.cos(i * np.pi / 3), np.sin(i * np.pi / 3), .3 * (-1) ** i) for i in range(6)])
        gentle = square + [(0, 0, h) for h in (0, .03, 0, .03)]  # fewer than a twentieth
        for number, (crossing, warped) in enumerate(((4, 7), (3, 0), (0, 6))):
            shapes = [(bow_tie, uneven,
                       pentagram)[k % 3] for k in range(crossing)] + [(saddle, hexagon)[k % 2] for k in range(warped)]
            shapes += [gentle] * 5
            pieces = [Piece(base.points, base.triangles.tolist(), 0, None)]
            for k, shape in enumerate(shapes):
                by = np.array([3.0 + 3 * (k % 5), 3.0 * (k // 5), 0])
                pieces.append(Piece(shape @ turn_of(k).T + by, [list(range(len(shape)))], 0, None))
            piece = together(pieces)
            want = piece.want()
            want.area = None
            for file, write in WRITERS.items():
                with self.subTest(crossing=crossing, warped=warped, file=file):
                    warns = [rf"(?i){file}(?=.*\b{count}\b[^,;]*{what}|.*{what}[^,;]*\b{count}\b)"
                             for count, what in ((crossing, "cross"), (warped, "warp")) if count]
                    never = [f"(?i){what}" for count, what in ((crossing, "crossing|cross (?:each|them)"),
                                                               (warped, "warp")) if not count]
                    self.read(self.put(file, write(piece)), want, warns=warns, never=never)


def float32(mesh):
    return Mesh(mesh.points.astype(np.float32).astype(float), mesh.triangles)


def rewrap(data, *lengths):
    """The words of a text in lines of `lengths` words, in turn."""
    words, lines, k = data.decode().split(), [], 0
    while words:
        lines.append(" ".join(words[:lengths[k % len(lengths)]]))
        words = words[lengths[k % len(lengths)]:]
        k += 1
    return ("\n".join(lines) + "\n").encode()


BOM = b"\xef\xbb\xbf"


class Formats(InputTest):
    def test_stl_in_text(self):
        mesh = float32(torus())
        data = stl_text(mesh)
        cases = {"capitals.stl": data.upper(), "title.stl": data.title(),
                 "mixed.stl": data.replace(b"solid", b"sOlId").replace(b"vertex", b"Vertex"),
                 "blanks.stl": b"   \t " + data, "lines.stl": b"\n\n\r\n" + data, "mark.stl": BOM + data,
                 "mark_and_lines.stl": BOM + b"\n \n" + data,
                 "in.txt": data, "in.ply": data, "in.obj": b"\n" + data, "in.off": data.upper(), "none": b" \n" + data,
                 "dots.2024.dat": data.upper(),
                 "windows.stl": b"\r\n" + data.replace(b"\n", b"\r\n"), "nameless.stl": stl_text(mesh, name=""),
                 "long.stl": stl_text(mesh, name=" " + "n" * 5000),
                 "eighty.stl": stl_text(mesh, name=" " + "x" * 200), "tabs.stl": data.replace(b"  ", b"\t"),
                 "no_end.stl": data.rstrip(),
                 "blank_lines.stl": data.replace(b"\n", b"\n\n"), "nan.stl": stl_text(mesh, normal="nan -nan(ind) -1.#IND")}
        for number, (name, content) in enumerate(cases.items()):
            with self.subTest(name):
                self.read(self.put(name, content), expected(mesh), both=number % 5 == 0)

    def test_binary_stl(self):
        mesh = float32(torus())
        size = len(mesh.triangles)
        solid_header = b"solid part of a thing\n facet normal 0 0 1\n outer loop"
        for name, data in (("a.ply", stl_binary(mesh)), ("b.obj", stl_binary(mesh, b"solid")), ("c", stl_binary(mesh)),
                           ("d.txt", stl_binary(mesh, b"exported")),
                           ("e.off", stl_binary(mesh, b" ")), ("f.stl", stl_binary(mesh, solid_header)),
                           ("g.stl", stl_binary(mesh, b"SOLID")),
                           ("h.stl", stl_binary(mesh, bytes(80))), ("i.STL", stl_binary(mesh, b"\n\nsolid x")),
                           ("j.bin", stl_binary(mesh, b"\xff" * 80))):
            with self.subTest(name):
                self.read(self.put(name, data), expected(mesh))
        for header in (b"", solid_header):
            for tail in (b"\n", bytes(2), b"\r\n\x1a", bytes(16), b"x" * 49):
                with self.subTest(header=header, tail=tail):
                    self.read(self.put("tail.stl", stl_binary(mesh, header, tail=tail)), expected(mesh),
                              warns=(rf"tail.stl.*\b{len(tail)}\b",))
            for tail in (b"x" * 50, bytes(50) + b"x", b"x" * 4096):
                with self.subTest(header=header, tail=len(tail)):
                    self.refuse(self.put("tail.stl", stl_binary(mesh, header, tail=tail)))
            with self.subTest("count", header=header):
                self.refuse(self.put("count.stl", stl_binary(mesh, header, count=0)), rf"\b{size}\b")
                self.refuse(self.put("more.stl", stl_binary(mesh, header, count=size + 1)), str(size + 1))
                self.refuse(self.put("short.stl", stl_binary(mesh, header)[:-1]), str(size))

    def test_off_in_free_form(self):
        mesh = torus()
        plain = off(mesh)
        colors = shades(mesh)
        rgba = lambda i: numbers(colors)(i) + " 255"
        bodies = plain.split(b"\n", 2)
        vertices = b"\n".join(bodies[2].split(b"\n")[:288])
        faces = b"\n".join(bodies[2].split(b"\n")[288:])
        counts = bodies[1]
        head = b"OFF\n" + counts + b"\n"
        for name, data in (("one_a_line.off", rewrap(plain, 1)), ("two_vertices.off", head + rewrap(vertices, 6) + faces),
                           ("three_vertices.off", head + rewrap(vertices, 9) + faces),
                           ("uneven.off", rewrap(plain, 5, 2, 11)),
                           ("one_line.off", rewrap(plain, 10**9)), ("seven.off", rewrap(plain, 7)),
                           ("counts.off", b"OFF 288\n576\n\n0\n" + bodies[2]),
                           ("counts_behind.off", b"OFF\n288 576\n0 " + bodies[2]),
                           ("two_faces.off", head + vertices + b"\n" + rewrap(faces, 8)),
                           ("half_a_vertex.off", head + rewrap(vertices, 2, 1) + faces),
                           ("tabs.off", plain.replace(b" ", b"\t\t")),
                           ("comments.off", b"# one\nOFF # two\n" + counts + b" # three\n" + rewrap(vertices, 4).replace(b"\n", b" # row\n") + faces),
                           ("windows.off", rewrap(plain, 3).replace(b"\n", b"\r\n")),
                           ("blank_lines.off", rewrap(plain, 4).replace(b"\n", b"\n\n")),
                           ("mark.off", BOM + rewrap(plain, 13))):
            with self.subTest(name):
                self.read(self.put(name, data), expected(mesh))
        for name, data in (("rgb.off", off(mesh, behind=numbers(colors))), ("rgba.off", off(mesh, behind=rgba)),
                           ("unit.off", off(mesh, behind=numbers(colors / 255.0))),
                           ("unit_alpha.off", off(mesh, behind=lambda i: numbers(colors / 255.0)(i) + " 1.0")),
                           ("no_keyword.off", off(mesh, "", behind=numbers(colors))),
                           ("free.off", rewrap(off(mesh, "COFF\n", behind=rgba), 5))):
            with self.subTest(name):
                self.read(self.put(name, data), expected(mesh, colors))
        for count in (1, 2, 5):
            with self.subTest(surplus=count):
                data = off(mesh, behind=lambda i: " 0.5" * count)
                self.read(self.put("surplus.off", data), expected(mesh), says=(skipped("surplus.off", "number|column"),))

    def test_obj(self):
        mesh = torus()
        n = len(mesh.points)
        plain = obj(mesh).decode()
        weighted = lambda w: "".join("v " + " ".join(word(x * w(i)) for x in p) + f" {word(float(w(i)))}\n" for i,
                                     p in enumerate(mesh.points))
        faces = plain[plain.index("f "):]
        broken = lambda end: re.sub(r"^f (\d+) (\d+) ", lambda m: f"f {m[1]} {end}\n {m[2]} {end}\n", plain, flags=re.M)
        for name, text in (("w2.obj", weighted(lambda i: 2.0) + faces), ("half.obj", weighted(lambda i: 0.5) + faces),
                           ("one.obj", weighted(lambda i: 1.0) + faces),
                           ("each.obj", weighted(lambda i: 1.0 + i % 7) + faces),
                           ("negative.obj", weighted(lambda i: -4.0) + faces),
                           ("some.obj", "".join(weighted(lambda i: 8.0).splitlines(True)[:100] + plain.splitlines(True)[100:n]) + faces),
                           ("backslash.obj", broken("\\")), ("blanks.obj", broken("\\   ")), ("tabs.obj", broken("\\\t \t")),
                           ("windows.obj", broken("\\  ").replace("\n", "\r\n")),
                           ("vertices.obj", re.sub(r"^v (\S+) ", r"v \1 \\ \n", plain, flags=re.M)),
                           ("comment.obj", "# " + "c" * 200000 + "\n" + plain),
                           ("comment_between.obj", plain + "#" + "\t#" * 70000 + "\n"),
                           ("names.obj", "o " + "n" * 70000 + "\ng " + "a b " * 9000 + "\n" + plain),
                           ("path.obj", "# C:\\scans\\\n" + plain),
                           ("mark.obj", BOM.decode() + plain), ("no_end.obj", plain.rstrip()),
                           ("capital.obj", "# V 1 2 3\n" + plain)):
            with self.subTest(name):
                self.read(self.put(name, text.encode()), expected(mesh))

    def test_ply(self):
        mesh = torus()
        text, binary = ply(mesh, True), ply(mesh, False)
        windows = lambda data: data.split(b"end_header\n")[0].replace(b"\n",
                                                                      b"\r\n") + b"end_header\r\n" + data.split(b"end_header\n", 1)[1]
        for name, data in (("mark.ply", BOM + text), ("mark_binary.ply", BOM + binary),
                           ("mark_big.ply", BOM + ply(mesh, False, order=">")),
                           ("mark_windows.ply", BOM + text.replace(b"\n", b"\r\n")),
                           ("mark_windows_binary.ply", BOM + windows(binary)), ("mark.stl", BOM + text)):
            with self.subTest(name):
                self.read(self.put(name, data), expected(mesh))
        for number, tail in enumerate((bytes(65), bytes(4096), bytes(100000), b" " * 200, b"\n" * 5000, b"\r\n \t" * 300,
                                       b"\n" + bytes(512) + b"\n \0")):
            for name, data in (("text.ply", text), ("binary.ply", binary)):
                with self.subTest(name, tail=number):
                    self.read(self.put(name, data + tail), expected(mesh), warns=(re.escape(name),))
        for name, data in (("none.ply", text.rstrip()), ("line.ply", text), ("binary.ply", binary)):
            with self.subTest(name):
                self.read(self.put(name, data), expected(mesh))

    def test_vertices_that_no_face_uses(self):
        """Whatever is in them is said; in a vertex that is used it is an error, whatever the options."""
        mesh = torus()
        n = len(mesh.points)
        quads = [[a, b, c, d] for (a, b, c), (_, _, d) in zip(mesh.triangles[:288].tolist(), mesh.triangles[288:].tolist())]
        writers = {"a.ply": lambda m, **o: ply(m, True, **o), "b.ply": lambda m, **o: ply(m, False, **o), "c.ply": lambda m,
                   **o: ply(m, False, position="float", **o),
                   "d.obj": obj, "e.off": off}
        for number, value in enumerate((np.nan, np.inf, -np.inf)):
            behind = np.concatenate([mesh.points, np.full((3, 3), 9.0)])
            behind[n:, number] = value
            before = np.concatenate([np.full((4, 3), value), mesh.points])
            used = mesh.points.copy()
            used[123, number] = value
            for name, write in writers.items():
                with self.subTest(name, value=value):
                    # 9 is a place that no face uses either.
                    self.read(self.put(name, write(Mesh(behind, mesh.triangles))),
                              expected(float32(mesh) if name == "c.ply" else mesh),
                              warns=(counted(name, 3, n),))
                    if number == 0:
                        self.read(self.put(name, write(Mesh(before, mesh.triangles + 4),
                                                       faces=[[v + 4 for v in f] for f in quads])),
                                  expected(float32(mesh) if name == "c.ply" else mesh), warns=(counted(name, 4, 0),))
                    self.refuse(self.put(name, write(Mesh(used, mesh.triangles))), r"vertex 123\b")
                    if number < 2:
                        self.refuse(self.put(name, write(Mesh(used, mesh.triangles))), r"vertex 123\b",
                                    options=("--lenient",))

    def test_more_vertices_than_can_be(self):
        mesh = torus()
        for count in (4294967296, 5000000000, 99999999999999):
            for name, data in (("a.ply", ply(mesh, False)), ("b.ply", ply(mesh, True)),
                               ("c.ply", ply(mesh, False, order=">"))):
                with self.subTest(name, count=count):
                    self.refuse(self.put(name, data.replace(b"vertex 288", f"vertex {count}".encode())), r"\b4294967295\b")
            with self.subTest("off", count=count):
                self.refuse(self.put("d.off", off(mesh).replace(b"288", str(count).encode(), 1)), r"\b4294967295\b")

    def test_what_is_no_mesh(self):
        mesh = torus()
        data = ply(mesh)
        archive = io.BytesIO()
        with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
            file.writestr("scan.ply", data)
        zstd = b"\x28\xb5\x2f\xfd\x04\x58" + (len(data) << 3 | 1).to_bytes(3, "little") + data
        pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:" + b"4d" * 32 + b"\nsize 123456\n"
        page = b"<!DOCTYPE html>\n<html><head><title>404 Not Found</title></head><body>solid off ply</body></html>\n"
        for number, (content, words) in enumerate((
                (archive.getvalue(), r"(?i)\bzip\b"), (gzip.compress(data), "(?i)gzip"), (bz2.compress(data), "(?i)bzip2"),
                                                   (lzma.compress(data), r"(?i)\bxz\b"),
                (zstd, "(?i)zstd|zstandard"), (b"\xff\xfe" + obj(mesh).decode().encode("utf-16-le"), "UTF-16"),
                (b"\xfe\xff" + ply(mesh, True).decode().encode("utf-16-be"), "UTF-16"),
                                                   (off(mesh).decode().encode("utf-16"), "UTF-16"),
                (stl_text(mesh).decode().encode("utf-16"), "UTF-16"), (pointer, "Git LFS"), (page, "HTML"),
                                                   (b"\n  <html lang='en'>" + page, "HTML"),
                (page.upper(), "HTML"), (page.lower(), "HTML"), (BOM + page, "HTML"))):
            for name in ("in.ply", "in.stl", "in.obj", "in.off", "none"):
                if (number + len(name)) % 2 == 0 or name == "in.ply":
                    with self.subTest(words, number=number, name=name):
                        self.refuse(self.put(name, content), words, ranks=3 if number % 5 == 0 and name == "in.ply" else 0)


class Lenient(InputTest):
    def both_ways(self, name, data, want, *patterns, warns=None):
        """65 without --lenient, a warning with it."""
        with self.subTest(name):
            path = self.put(name, data)
            self.refuse(path, *patterns)
            self.read(path, want, "--lenient", warns=warns or (re.escape(name),))
            # verify needs it as build does.
            self.run_program("verify", self.path("out.h5"), "--against", path, status=program.BAD_DATA)

    def test_numbers_with_a_point(self):
        mesh = torus()
        want = expected(mesh)
        quads = [[a, b, c, d] for (a, b, c), (_, _, d) in zip(mesh.triangles[:288].tolist(), mesh.triangles[288:].tolist())]
        text = ply(mesh, True)
        floats = ply(mesh, True, index="float").replace(b"uchar float", b"uchar int")
        only_counts = re.sub(rb"(?m)^3 (?=\d+ \d+ \d+$)", b"3.0 ", text)
        self.both_ways("a.ply", floats, want, "face 0")
        self.both_ways("b.ply", only_counts, want, "face 0")
        self.both_ways("c.ply", text.rsplit(b"\n", 2)[0] + b"\n3 1.0 2.0 3.0\n",
                       expected(Mesh(mesh.points, np.concatenate([mesh.triangles[:-1], [[1, 2, 3]]])), closed=False),
                       "face 575")
        self.both_ways("d.ply", ply(mesh, False, index="float"), want)
        self.both_ways("e.ply", ply(mesh, False, index="double", order=">"), want)
        self.both_ways("f.ply", ply(mesh, False, count="float", index="float"), want)
        self.both_ways("g.ply", ply(mesh, True, faces=quads, index="float"), want)
        self.both_ways("h.ply", ply(mesh, False, faces=quads, index="float"), want)
        self.both_ways("i.off", off(mesh, cast=float), want, "face 0")
        self.both_ways("j.off", off(mesh, cast=float, faces=quads), want, "face 0")
        self.both_ways("k.off", off(mesh).replace(b"288 576 0", b"288.0 576.0 0.0"), want)
        for name, data in (("l.ply", floats.replace(b"3.0 ", b"3.5 ", 1)),
                           ("m.ply", only_counts.replace(b"3.0 ", b"-3.0 ", 1)),
                           ("n.off", off(mesh, cast=lambda x: x + 0.25)),
                           ("o.ply", ply(mesh, False, index="float", faces=[[0.5, 1, 2]] + mesh.triangles.tolist())),
                           ("p.ply", ply(mesh, False, index="float", faces=[[0, 1, np.nan]] + mesh.triangles.tolist())),
                           ("q.ply", ply(mesh, False, index="double", faces=[[0, 1, 288]] + mesh.triangles.tolist())),
                           ("r.ply", ply(mesh, True, index="float", faces=[[0, 1, 1e300]] + mesh.triangles.tolist()))):
            with self.subTest(name):
                if name == "r.ply":
                    data = data.replace(b"uchar float", b"uchar int")
                self.refuse(self.put(name, data), *(["face 0"] if name[0] in "opqr" else []), options=("--lenient",))

    def test_numbers_too_many(self):
        mesh = torus()
        want = expected(mesh)
        colors = shades(mesh)
        quads = [[a, b, c, d] for (a, b, c), (_, _, d) in zip(mesh.triangles[:288].tolist(), mesh.triangles[288:].tolist())]
        text = ply(mesh, True)
        lines = text.split(b"\n")
        first = lines.index(b"end_header") + 1
        self.both_ways("a.ply", ply(mesh, True, vertex_tail=" 7"), want, "vertex 0")
        self.both_ways("b.ply", ply(mesh, True, face_tail=" 0"), want, "face 0")
        self.both_ways("c.ply", ply(mesh, True, vertex_tail=" 1 2 3", face_tail=" 0.5 -1"), want, "vertex 0")
        self.both_ways("d.ply", b"\n".join(lines[:first + 100] + [lines[first + 100] + b" 1.5"] + lines[first + 101:]), want,
                       "vertex 100")
        self.both_ways("e.ply", b"\n".join(lines[:first + 300] + [lines[first + 300] + b" 9"] + lines[first + 301:]), want,
                       "face 12")
        self.both_ways("f.ply", ply(mesh, True, columns(RGB, "uchar", colors), vertex_tail=" 255"), expected(mesh, colors),
                       "vertex 0")
        self.both_ways("g.ply", ply(mesh, True, faces=quads, face_tail=" 1 1"), want, "face 0")
        self.both_ways("h.obj", obj(mesh, behind=lambda i: numbers(colors / 255.0)(i) + " 1.0 7.0 8.0"),
                       expected(mesh, colors))
        self.both_ways("i.obj", obj(mesh, behind=lambda i: numbers(colors / 255.0)(i) + (" 1.0 2.0" if i == 40 else "")),
                       expected(mesh, colors), "vertex 40")
        red = np.full((576, 3), (255, 40, 0))
        painted = np.full((288, 3), (255, 40, 0))
        self.both_ways("j.off", off(mesh, face_behind=lambda i: numbers(red)(i) + " 255 1"), expected(mesh, painted),
                       "face 0")
        self.both_ways("k.off", off(mesh, face_behind=lambda i: numbers(red)(i) + " 255" + (" 3 4" if i == 33 else "")),
                       expected(mesh, painted), "face 33")
        for name, data in (("l.ply", ply(mesh, True, vertex_tail=" x")),
                           ("m.ply", b"\n".join(lines[:first + 50] + [lines[first + 50].rsplit(b" ", 1)[0]] + lines[first + 51:])),
                           ("n.ply", text.replace(b".", b",")), ("o.obj", obj(mesh).replace(b"v 1.4 ", b"v ", 1)),
                           ("p.off", off(mesh, face_behind=lambda i: " x"))):
            with self.subTest(name):
                self.assertNotIn(data, (text, obj(mesh)))
                self.refuse(self.put(name, data), options=("--lenient",))

    def test_prose_in_headers(self):
        mesh = torus()
        want = expected(mesh)
        prose = lambda *lines: dict(header=lines)
        for number, (text, lines) in enumerate(((True, ("Created by a modeller",)), (False, ("made with care, 1999",)),
                                                (True, ("author: me", "source file:")),
                                                (False, ("TextureFile none", "-----")), (True, ("vertices below",)),
                                                (False, ("(c) somebody",)))):
            self.both_ways(f"{number}.ply", ply(mesh, text, **prose(*lines)), want, re.escape(lines[0].split()[0]))
        for number, lines in enumerate((b"Exported by a modeller\n", b"a torus\nof two lines\n", b"units: mm\n\n",
                                        b"File made in 2019\n")):
            self.both_ways(f"{number}.off", off(mesh, "OFF\n" + lines.decode()), want)
        for name, data in (("x.ply", ply(mesh).replace(b"property double y", b"property y")),
                           ("y.ply", ply(mesh).replace(b"element face 576", b"element face many")),
                           ("z.ply", ply(mesh).replace(b"format binary_little_endian 1.0", b"format of my own"))):
            with self.subTest(name):
                self.refuse(self.put(name, data), options=("--lenient",))

    def test_other_bytes_behind_the_data(self):
        mesh = torus()
        want = expected(mesh)
        for number, tail in enumerate((b"some more text\n", bytes(100) + b"x", b"\xff" * 1000, b"1 2 3\n4 5 6\n")):
            self.both_ways(f"{number}text.ply", ply(mesh, True) + tail, want)
            self.both_ways(f"{number}binary.ply", ply(mesh, False) + tail, want)
            self.both_ways(f"{number}.off", off(mesh) + tail, want)
            if number in (1, 2):  # in an OBJ the others are statements
                self.both_ways(f"{number}.obj", obj(mesh) + tail, want)
        for name, data in (("x.ply", ply(mesh)[:-5]), ("y.off", off(mesh)[:-200]), ("z.ply", ply(mesh, True)[:-200])):
            with self.subTest(name):
                self.refuse(self.put(name, data), options=("--lenient",))

    def test_nothing_to_forgive(self):
        """No word, and the same bytes."""
        mesh = torus()
        for name, data in (("a.ply", ply(mesh)), ("b.obj", obj(mesh)), ("c.off", off(mesh)),
                           ("d.stl", stl_binary(float32(mesh)))):
            with self.subTest(name):
                path = self.put(name, data)
                self.read(path, expected(float32(mesh) if name == "d.stl" else mesh), "--lenient")

    def test_synth(self):
        mesh = torus()
        for name, data in (("a.ply", ply(mesh, True, index="float")), ("b.off", off(mesh, "OFF\na torus\n")),
                           ("c.ply", ply(mesh, True, face_tail=" 4")),
                           ("d.ply", ply(mesh) + b"behind")):
            with self.subTest(name):
                path = self.put(name, data)
                synth = ("synth", "-o", self.path("out.ply"), "--triangles", 3000, "--base", path)
                self.run_program(*synth, status=program.BAD_DATA)
                run = self.run_program(*synth, "--lenient")
                self.assertRegex(run.stderr, rf"warning: \S*{re.escape(name)}")
                self.assertTrue(Census(check_closed.read_ply(self.path("out.ply"))).is_closed)


class Resume(faults.FaultTest):
    def test_lenient_is_of_the_build(self):
        """A build goes on with --lenient if it began with it, and not otherwise."""
        path = self.path("in.ply")
        with open(path, "wb") as file:
            file.write(ply(torus(60, 40), True))
        for name, first, then in (("with", ("--lenient",), ()), ("without", (), ("--lenient",))):
            for ranks in (0, 3):
                with self.subTest(name, ranks=ranks):
                    builder = self.builder(f"{name}{ranks}", [path], ("--leaf-triangles", 700))
                    phases = [event for event in faults.moments_of(self.make_reference(builder)) if event.endswith(".task")]
                    fault = faults.Fault(phases[len(phases) // 2], 1, "after", str(-signal.SIGTERM))
                    run = builder.run("--resume", *first, fault=fault)
                    self.assertEqual(run.status, faults.STOPPED, str(run))
                    run = builder.run("--resume", *then, ranks=ranks)
                    self.assertEqual(run.status, program.USAGE, str(run))
                    self.assertIn("lenient", " ".join(run.errors))
                    run = builder.run("--resume", *first, ranks=ranks)
                    self.assertEqual(run.status, program.OK, str(run))


class Many(InputTest):
    def test_more_files_than_may_be_open(self):
        corners = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], float)
        sides = np.array([(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)])
        parts, names = [], []
        for k in range(1100):
            part = Mesh(corners * (1 + k % 3 / 4) + (3.0 * (k % 40), 3.0 * (k // 40), k % 2), sides)
            name, write = ((f"{k:04}.ply", ply), (f"{k:04}.obj", obj), (f"{k:04}.off", off),
                           (f"{k:04}.stl", stl_binary))[k % 4]
            self.put(name, write(part))
            parts.append(part)
            names.append(name)
        self.put("list.txt", ("\n".join(names) + "\n").encode())
        want = expected(meshes.join(*parts))
        for ranks, scheme in ((0, "diamonds"), (3, "blocks"), (3, "diamonds")):
            with self.subTest(ranks=ranks, scheme=scheme):
                output = self.path(f"{ranks}{scheme}.h5")
                inputs = ["@" + self.path("list.txt")] if ranks else [self.path(name) for name in names]
                run = self.run_program("build", *inputs, "-o", output, "--scheme", scheme, "--leaf-triangles", 500,
                                       "--position-bits", 16,
                                       ranks=ranks, open_files=256)
                self.assertNotRegex(run.stderr, r"warning: (?!level)")
                self.run_program("verify", output, "--against", *(self.path(name) for name in names), open_files=256)
                self.check(output, want)


if __name__ == "__main__":
    program.main()
