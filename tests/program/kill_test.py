"""Builds that are killed once, twice or thrice, each time in another phase, by SIGKILL to a rank, to mpirun or to all, lose
some scratch at times, and go on on another number of ranks: the container has the bytes of a build that nobody killed.
COLOSSUS_KILL_BUILDS is the least number of builds of each scheme; more are made until each phase has been hit twice."""
import os

import faults
import program
from faults import Fault

SIGKILL = "-9"
MOST_KILLS = 3
SHARE_OF_CRASHES = 0.25
LEAST_BUILDS = int(os.environ.get("COLOSSUS_KILL_BUILDS", 10))


class Kill(faults.FaultTest):
    def draw_plan(self, hits):
        """The events at which a build is killed, in order: those that were hit least."""
        least = sorted(hits, key=lambda event: (hits[event], self.random.random()))
        return sorted(least[:self.random.randint(1, MOST_KILLS)], key=list(hits).index)

    def draw_fault(self, event, count, ranks):
        targets = ["self", "all", "ranks"] + (["parent", str(self.random.randrange(ranks))] if ranks else [])
        if not ranks:
            targets = ["self"]
        return Fault(event, self.random.randint(1, count), self.random.choice(["before", "half", "after"]), SIGKILL,
                     self.random.choice(targets))

    def check(self, scheme, leaf_triangles):
        builder = self.builder(scheme, [self.statue(20000)], ["--scheme", scheme, "--leaf-triangles", leaf_triangles])
        events = faults.moments_of(self.make_reference(builder))
        hits = dict.fromkeys(events, 0)
        builds = 0
        # A moment is missed when what was killed before had come further than it was told to.
        while builds < LEAST_BUILDS or min(hits.values()) < 2:
            plan = [(event, events[event]) for event in self.draw_plan(hits)]
            self.check_build(builder, plan, hits, f"build {builds}")
            builder.clear()
            builds += 1
            self.assertLess(builds, LEAST_BUILDS + 10 * len(events), f"phases that are not hit: {hits}")
        print(f"{builds} builds, hits: {hits}")

    def lose_data(self, scratch):
        """As if the whole machine had gone down: nothing is forced to the disk, so the end of a file may be missing, or
        be zeros."""
        files = sorted(os.path.join(folder, name) for folder, _, names in os.walk(scratch) for name in names
                       if name != "manifest")
        if not files:
            return ""
        path = self.random.choice(files)
        size = os.path.getsize(path)
        kept = self.random.randint(0, size)
        os.truncate(path, kept)
        if self.random.random() < 0.5:
            os.truncate(path, size)
        return f"; {os.path.basename(path)} lost what follows byte {kept} of {size}"

    def check_build(self, builder, plan, hits, what):
        ranks = self.random.choice([0, 2, 3, 4])
        for event, count in plan:
            fault = self.draw_fault(event, count, ranks)
            what += f"; on {ranks} ranks {fault}"
            run = builder.run("--resume", ranks=ranks, fault=fault)
            hits[event] += run.events >= fault.n
            if run.status == program.OK:
                self.assertTrue(fault.target.isdigit() or run.events < fault.n or event in ("rename", "rmdir"), what)
            self.assert_right_or_nothing(builder, what)
            if self.random.random() < SHARE_OF_CRASHES:
                what += self.lose_data(builder.scratch)
            ranks = self.random.choice([n for n in (0, 2, 3, 4) if n != ranks])
        self.assert_resumes(builder, f"{what}; on {ranks} ranks", ranks)

    def test_diamonds(self):
        self.check("diamonds", 700)

    def test_blocks(self):
        self.check("blocks", 300)


if __name__ == "__main__":
    program.main()
