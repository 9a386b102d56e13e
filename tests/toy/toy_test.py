"""A program with a scheme and a format more: they build, verify and extract, on any number of ranks, and go on when they
are killed, with no line in the program but those of its tables. COLOSSUS_PROGRAM is colossus_toy here,
COLOSSUS_PLAIN_PROGRAM the program without the toys."""
import json
import os
import random

import h5py
import jsonschema
import numpy as np

import check_closed
import program

PLAIN = os.environ["COLOSSUS_PLAIN_PROGRAM"]
SCHEMAS = os.path.join(os.path.dirname(__file__), "..", "..", "schemas")


class Toy(program.ColossusTest):
    def statue(self, triangles=20000):
        """The same surface as a PLY with colours and as a .tris; and as points of triangles."""
        ply, tris = self.path("statue.ply"), self.path("statue.tris")
        self.run_program("synth", "--triangles", triangles, "--seed", 1, "-o", ply)
        mesh = check_closed.read_ply(ply)
        soup = mesh.points[mesh.triangles]
        with open(tris, "w", encoding="utf-8") as file:
            file.write("tris # a comment\n")
            for row in soup.reshape(-1, 9):
                file.write(" ".join(map(repr, map(float, row))) + "\n")
        return ply, tris, soup

    def sketch(self, name, *inputs, ranks=0):
        return self.build(name, *inputs, options=("--scheme", "sketch", "--report", self.path("report.json")), ranks=ranks)

    def test_build_verify_and_extract(self):
        ply, tris, soup = self.statue()
        container = self.sketch("sketch.h5", tris)
        with open(self.path("report.json"), encoding="utf-8") as file:
            report = json.load(file)
        with open(os.path.join(SCHEMAS, "report.schema.json"), encoding="utf-8") as file:
            schema = json.load(file)
        # It lists the options of the program's schemes.
        schema["properties"]["options"]["properties"].update(share={"type": "number"}, whole={"type": "boolean"})
        jsonschema.validate(report, schema)
        self.assertEqual(report["options"]["scheme"], "sketch")
        info = self.info(container)
        self.assertEqual(info["scheme"], "sketch")
        self.assertEqual([level["triangles"] for level in info["levels"]], [len(soup) // 2, len(soup)])
        self.run_program("verify", container, "--against", tris)
        for level in (0, 1):
            census = check_closed.Census(self.extract(container, "--level", level))
            self.assertTrue(census.is_closed, f"level {level}: {census}")
        # What is finest is the input.
        finest = self.finest(container)
        step = 2.0 * info["levels"][1]["error"]
        corners = finest.points[finest.triangles]
        self.assertEqual(len(corners), len(soup))
        key = lambda points: sorted(map(tuple, np.round(points.mean(axis=1) / step / 64).astype(int)))
        difference = len(set(key(corners)) ^ set(key(soup)))
        self.assertLess(difference, len(soup) / 100)
        # With colours, by all other ways to cut.
        colored = self.sketch("colored.h5", ply)
        self.run_program("verify", colored, "--against", ply)
        self.assertEqual(len(self.extract(colored, "--error", 1e9).triangles), len(soup) // 2)
        self.assertEqual(len(self.extract(colored, "--error", 1e-9).triangles), len(soup))
        self.assertEqual(len(self.extract(colored, "--triangles", len(soup)).triangles), len(soup))
        self.assertEqual(len(self.extract(colored, "--eye", "0,0,0").triangles), len(soup))

    def test_any_number_of_ranks(self):
        _, tris, _ = self.statue(3000)
        alone = self.sketch("alone.h5", tris)
        for ranks in (1, 2, 3, 4, 9):
            other = self.sketch("other.h5", tris, ranks=ranks)
            with open(alone, "rb") as a, open(other, "rb") as b:
                self.assertEqual(a.read(), b.read(), f"{ranks} ranks")

    def test_damage_is_found(self):
        _, tris, _ = self.statue()
        container = self.sketch("sketch.h5", tris)
        with open(container, "rb") as file:
            content = bytearray(file.read())
        # Chunks fill the file from its table on.
        for place in random.Random(1).sample(range(len(content) // 4, len(content) * 9 // 10), 5):
            damaged = bytearray(content)
            damaged[place] ^= 0x10
            with open(self.path("damaged.h5"), "wb") as file:
                file.write(damaged)
            run = self.run_program("verify", self.path("damaged.h5"), status=program.BAD_DATA)
            self.assertIn("checksum", run.stdout + run.stderr)

    def test_options_of_their_own(self):
        """Of all three types; one has the name of an option of blocks. Help, container, report and manifest have them."""
        _, tris, soup = self.statue(3000)
        text = self.run_program("build", "--help").stdout
        for line in ("--levels INT +Of blocks: the deepest level, instead of the one that fits. Of sketch: the level",
                     "--share FLOAT=0.5 +Of sketch: what the sketch has", "--whole +Of sketch: the sketch has all"):
            self.assertRegex(text, line)
        report = self.path("report.json")
        container = self.build("sketch.h5", tris, options=("--scheme", "sketch", "--levels", 1, "--share", 0.25, "--report", report))
        info = self.info(container)
        self.assertEqual(info["options"]["levels"], "1")
        self.assertEqual(info["options"]["share"], "0.25")
        self.assertNotIn("whole", info["options"])
        self.assertAlmostEqual(info["levels"][0]["triangles"], len(soup) // 4, delta=2)  # collapses take two
        self.assertLessEqual(info["levels"][1]["nodes"], 8)
        with h5py.File(container) as file:
            self.assertEqual(file["options"].attrs["row_share"], b"Share of the triangles that the sketch was to have")
        with open(report, encoding="utf-8") as file:
            options = json.load(file)["options"]
        self.assertEqual((options["levels"], options["share"], options["whole"]), (1, 0.25, False))
        whole = self.build("whole.h5", tris, options=("--scheme", "sketch", "--whole"))
        self.assertEqual(self.info(whole)["levels"][0]["triangles"], len(soup))
        for option, found in ((("--levels", 5), "--levels 5 is out of range"),
                              (("--tolerance", 1e-12), "--tolerance 1e-12"),
                              (("--position-bits", 99), "--position-bits 99 is out of range")):
            run = self.run_program("build", tris, "-o", self.path("no.h5"), "--scheme", "sketch", *option, status=program.USAGE)
            self.assertIn(found, run.stderr)
            self.assertEqual([name for name in os.listdir(self.folder) if name.startswith("no.h5")], [])
        run = self.run_program("build", tris, "-o", self.path("no.h5"), "--share", 0.25, status=program.USAGE)
        self.assertIn("--share is an option of --scheme sketch only", run.stderr)
        run = self.run_program("build", tris, "-o", self.path("no.h5"), "--levels", 1, status=program.USAGE)
        self.assertIn("--levels is an option of --scheme blocks or sketch only", run.stderr)
        # A default says nothing new: not to another scheme either.
        self.build("default.h5", tris, options=("--share", 0.5))

    def test_what_the_program_says_of_them(self):
        _, tris, _ = self.statue(500)
        container = self.sketch("sketch.h5", tris)
        self.assertIn("sketch: the input, and a sketch of it", self.run_program("build", "--help").stdout)
        run = self.run_program("info", container, program=PLAIN, status=program.BAD_DATA)
        self.assertIn("scheme: expected 'diamonds' or 'blocks', found 'sketch'", run.stderr)
        run = self.run_program("build", tris, "-o", self.path("no.h5"), program=PLAIN, status=program.BAD_DATA)
        self.assertIn("unknown format; expected a PLY, OBJ, STL or OFF file", run.stderr)
        run = self.run_program("build", tris, "-o", self.path("no.h5"), "--scheme", "sketch", program=PLAIN,
                               status=program.USAGE)
        self.assertIn("sketch", run.stderr)
        self.assertIn("PLY, OBJ, STL, OFF or TRIS files", self.run_program("build", "--help").stdout)
        for content, found in (("tris 1 2 3", "the end of the file"), ("tris 1 2 x", "x"), ("odd", "TRIS")):
            with open(self.path("bad"), "w", encoding="utf-8") as file:
                file.write(content)
            run = self.run_program("build", self.path("bad"), "-o", self.path("no.h5"), status=program.BAD_DATA)
            self.assertIn(found, run.stderr)
        # Those that others know are as they were.
        for scheme in ("diamonds", "blocks"):
            ply = self.path("statue.ply")
            ours = self.build("ours.h5", ply, options=("--scheme", scheme))
            theirs = self.build("theirs.h5", ply, options=("--scheme", scheme), program=PLAIN)
            with open(ours, "rb") as a, open(theirs, "rb") as b:
                self.assertEqual(a.read(), b.read(), scheme)


if __name__ == "__main__":
    program.main()
