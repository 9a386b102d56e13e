"""Scratch that no later phase reads is deleted while the build goes on."""
import json
import os
import re

import faults
import program
from faults import Fault


class Release(faults.FaultTest):
    def check(self, *options, most_streams):
        for ranks in (0, 3):
            builder = self.builder(f"on_{ranks}", [self.statue(60000)], ["--leaf-triangles", 700, *options])
            report = self.path("report.json")
            run = builder.run("--report", report, ranks=ranks)
            self.assertEqual(run.status, program.OK, str(run))
            with open(report, encoding="utf-8") as file:
                report = json.load(file)
            workers = max(1, ranks - 1)
            written = sum(phase["scratch_bytes"]["mean"] for phase in report["phases"]) * workers
            used = report["used"]["scratch_bytes"]
            print(f"{options} on {ranks} ranks: {used} bytes at a time of {written:.0f}")
            self.assertLess(used, written / 2)
            self.assertLessEqual(self.most_streams(run), most_streams)
            self.check_nothing_is_done_again(builder, ranks)

    def check_nothing_is_done_again(self, builder, ranks):
        """Of a build that is killed when all is done but the container's name: the tasks of the next attempt are the same,
        though their results came in another order. Else they would need what was deleted."""
        self.reference[tuple(builder.options)] = self.path(f"reference_{ranks}.h5")
        os.rename(builder.output, self.reference[tuple(builder.options)])
        run = builder.run(ranks=ranks, fault=Fault("rename", 1, "before", "-9"))
        self.assertNotEqual(run.status, program.OK)
        trace = self.assert_resumes(builder, "killed at the end", ranks).trace()
        self.assertEqual([line for line in trace if line[2] == "task"], [])

    def most_streams(self, run):
        """How many streams besides the one that is kept had files at a time."""
        files, most = set(), 0
        for operation, file, _, _ in run.trace():
            stream = re.search("stream-([0-9]+)", file)
            if not stream or int(stream[1]) == 0:
                continue
            if operation == "create":
                files.add(file)
                most = max(most, len({re.search("stream-([0-9]+)", name)[1] for name in files}))
            elif operation == "unlink":
                files.discard(file)
        return most

    def test_of_blocks(self):
        # Requests, answers and buckets.
        self.check("--scheme", "blocks", most_streams=3)

    def test_of_diamonds(self):
        # The leaves of the partition and of two completions, and two levels.
        self.check(most_streams=5)


if __name__ == "__main__":
    program.main()
