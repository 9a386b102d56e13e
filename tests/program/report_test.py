"""What a build says of itself: --status, --report, --dry-run, the estimate."""
import itertools
import json
import os
import re
import unittest

import jsonschema
import numpy

import program
from program import ColossusTest

SCHEMAS = os.path.join(os.path.dirname(__file__), "..", "..", "schemas")
NO_RESOURCES, STOPPED = 69, 75


def read_json(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


class Report(ColossusTest):
    def statue(self, triangles=60000):
        output = self.path("statue.ply")
        self.run_program("synth", "--triangles", triangles, "--seed", 1, "-o", output)
        return output

    def quads(self, cells):
        """A rough, speckled sheet of shuffled quads with colours that are floats: as hard to compress as a scan."""
        name = self.path("quads.ply")
        x, y = (axis.ravel() for axis in numpy.meshgrid(*2 * [numpy.arange(cells + 1)]))
        noise = numpy.random.default_rng(1).random((len(x), 3))
        vertices = numpy.stack([x, y, 9 * numpy.sin(x / 9) * numpy.cos(y / 7) + noise[:, 0] / 3, noise[:, 1] / 20 + x / cells / 2,
                                noise[:, 2] / 20 + y / cells / 2, 0 * x], 1)
        faces = numpy.empty((cells * cells, 17), "u1")
        faces[:, 0] = 4
        corner = (x + (cells + 1) * y)[(x < cells) & (y < cells)]
        faces[:, 1:] = numpy.stack([corner, corner + 1, corner + cells + 2, corner + cells + 1], 1).astype("<i4").view("u1")
        names = "".join(f"property float {word}\n" for word in ("x", "y", "z", "red", "green", "blue"))
        header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(x)}\n{names}"
                  f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
        numpy.random.default_rng(2).shuffle(faces)
        with open(name, "wb") as file:
            file.write(header.encode() + vertices.astype("<f4").tobytes() + faces.tobytes())
        return name

    def build_reported(self, *arguments, ranks=0, status=program.OK):
        """The run, its report and its last status; both files keep to their schemas."""
        report, state = self.path("report.json"), self.path("status.json")
        run = self.run_program("build", *arguments, "--report", report, "--status", state, ranks=ranks, status=status)
        report, state = read_json(report), read_json(state)
        jsonschema.validate(report, read_json(os.path.join(SCHEMAS, "report.schema.json")))
        jsonschema.validate(state, read_json(os.path.join(SCHEMAS, "status.schema.json")))
        self.assertEqual([report["state"], report["exit_status"]], [state["state"], status])
        return run, report, state

    def test_done(self):
        statue, output = self.statue(), self.path("a.h5")
        for scheme in "diamonds", "blocks":
            for ranks in 0, 3:
                with self.subTest(scheme=scheme, ranks=ranks):
                    _, report, state = self.build_reported(statue, "-o", output, "--leaf-triangles", 1000, "--scheme",
                                                           scheme, ranks=ranks)
                    self.assertEqual(report["state"], "done")
                    self.check_done(report, output, max(ranks, 1))
                    self.assertEqual(state["phase"]["name"], "assembly")
                    self.assertEqual(state["phase"]["done"], state["phase"]["tasks"])

    def check_done(self, report, output, ranks):
        info = self.info(output)
        self.assertEqual(report["output"]["bytes"], os.path.getsize(output))
        self.assertEqual(len(report["hosts"]), ranks)
        self.assertEqual(len(report["used"]["peak_memory_bytes"]), ranks)
        self.assertEqual([level["triangles"] for level in report["levels"]],
                         [level["triangles"] for level in info["levels"]])
        workers = max(ranks - 1, 1)
        phases = {phase["name"]: phase for phase in report["phases"]}
        for name in "survey", "requests", "buckets":
            self.assertEqual(round(phases[name]["triangles"]["mean"] * workers), report["counts"]["triangles"], name)
        for phase in report["phases"][:-1]:
            self.assertEqual(round(phase["rank_tasks"]["mean"] * workers), phase["tasks"], phase["name"])
            for spread in (value for value in phase.values() if isinstance(value, dict)):
                self.assertLessEqual(spread["min"], spread["mean"])
                self.assertLessEqual(spread["mean"], spread["max"])
            self.assertLessEqual(phase["work_seconds"]["max"], phase["seconds"])
        # Enough to run it again.
        self.assertEqual(report["command"][1], "build")
        self.assertEqual(report["inputs"][0]["bytes"], os.path.getsize(self.path("statue.ply")))

    def test_estimate(self):
        """Between 1.0 and 1.5 times what is used, also where polygons are cut, or floats have two scales until all are known."""
        output = self.path("a.h5")
        for scheme, statue in itertools.product(("diamonds", "blocks"), (self.statue(400000), self.quads(600))):
            with self.subTest(scheme=scheme, statue=statue):
                _, report, _ = self.build_reported(statue, "-o", output, "--scheme", scheme, ranks=3)
                estimate, used = report["estimate"], report["used"]
                for name, need in (("memory_bytes_per_rank", max(used["peak_memory_bytes"])),
                                   ("scratch_bytes", used["scratch_bytes"]), ("output_bytes", used["output_bytes"])):
                    self.assertLessEqual(need, estimate[name], name)
                    self.assertLessEqual(estimate[name], 1.5 * need, name)

    def test_refused(self):
        """What cannot fit ends after the survey; with enough memory it goes on from there."""
        statue, output = self.statue(1000000), self.path("a.h5")
        options = ["--scheme", "blocks", "--leaf-triangles", 4000000]
        run, report, _ = self.build_reported(statue, "-o", output, *options, "--memory", "256M", ranks=2,
                                             status=NO_RESOURCES)
        self.assertRegex(run.stderr, r"a rank will need some .* of memory, but may use 256\.0 MB: .*--memory")
        self.assertEqual([phase["name"] for phase in report["phases"]], ["survey", "requests", "extent", "occupancy"])
        self.assertFalse(os.path.exists(output))
        self.build_reported(statue, "-o", output, *options, "--memory", "1G", "--resume", ranks=2)

    def test_dry_run(self):
        statue, output = self.statue(), self.path("a.h5")
        run, report, _ = self.build_reported(statue, "-o", output, "--dry-run", ranks=2)
        self.assertRegex(run.stdout, r"estimate: .* of memory per rank, .* of scratch \(.* free\), .* of output \(.* free\)")
        self.assertIn("nothing was built", run.stdout)
        self.assertGreater(report["estimate"]["output_bytes"], 0)
        self.assertEqual(sorted(os.listdir(self.folder)), ["report.json", "statue.ply", "status.json"])

    def test_stopped_and_resumed(self):
        statue, output = self.statue(1000000), self.path("a.h5")
        whole = self.path("whole.h5")
        self.run_program("build", statue, "-o", whole)
        _, report, _ = self.build_reported(statue, "-o", output, "--time-limit", "1s", ranks=2, status=STOPPED)
        self.assertEqual(report["state"], "stopped")
        self.assertIn("--resume", report["message"])
        _, report, _ = self.build_reported(statue, "-o", output, "--resume", ranks=3)
        self.assertGreaterEqual(report["attempt"], 1)
        with open(output, "rb") as a, open(whole, "rb") as b:
            self.assertEqual(a.read(), b.read())

    def test_failed(self):
        broken = self.path("broken.ply")
        with open(self.statue(), "rb") as file, open(broken, "wb") as cut:
            cut.write(file.read()[:100000])
        run, report, _ = self.build_reported(broken, "-o", self.path("a.h5"), ranks=2, status=program.BAD_DATA)
        self.assertEqual(report["state"], "failed")
        self.assertIn("broken.ply", report["message"])
        self.assertIn(report["message"], run.stderr)

    def test_files_that_cannot_be_written(self):
        """Said at once, not after hours."""
        statue = self.statue(1000)
        for option in "--status", "--report":
            nowhere = self.path("nowhere/file.json")
            run = self.run_program("build", statue, "-o", self.path("a.h5"), option, nowhere, ranks=2,
                                   status=program.CANNOT_CREATE)
            self.assertIn(nowhere, run.stderr)
            self.assertNotIn("survey", run.stdout)

    def test_log_lines(self):
        """Each with time and seconds, no control characters: fit for a log file."""
        run = self.run_program("build", self.statue(), "-o", self.path("a.h5"), ranks=2)
        for line in run.stdout.splitlines():
            self.assertTrue(re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ +\d+\.\d\ds  [ -~]+", line), line)


if __name__ == "__main__":
    program.main()
