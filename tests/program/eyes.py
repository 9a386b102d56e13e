"""Random eyes, and the proof that what they see of closed surfaces is closed: scripts/eyes runs it, and says what it
does. eyes.py PROGRAM [--eyes N] [--seed N] [--leaf-triangles N] FILE..."""
import argparse
import concurrent.futures
import os
import random
import re
import subprocess
import sys
import tempfile

import numpy as np

import check_closed

GREATEST_KAPPA = 4.0


def positions(points, edge, count, numbers):
    """Half of them inside the bounds of the points or within an edge length of one, half around. Arrays of three."""
    low, high = points.min(axis=0), points.max(axis=0)
    for i in range(count):
        if i % 4 == 0:
            yield low + (high - low) * [numbers.random() for _ in range(3)]
        elif i % 4 == 1:
            yield points[numbers.randrange(len(points))] + edge * np.array([numbers.uniform(-1, 1) for _ in range(3)])
        else:
            yield low + (high - low) * [numbers.uniform(-2, 3) for _ in range(3)]


def mean_edge(mesh):
    t = mesh.points[mesh.triangles[:, :2]]
    return float(np.linalg.norm(t[:, 1] - t[:, 0], axis=1).mean())


def holds_several_levels(said):
    """Whether `extract --eye` has said that it draws more than one level."""
    return len(re.findall(r"level \d+: [1-9]", said)) > 1


def run(*command, status=0):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, check=False)
    if done.returncode != status:
        sys.exit(f"{' '.join(map(str, command))}: status {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


class Looks:
    """At one container, in a folder."""

    def __init__(self, program, source, folder, options):
        self.program, self.folder = program, folder
        self.container = os.path.join(folder, "blocks.h5")
        run(program, "build", source, "-o", self.container, "--scheme", "blocks", *options)
        finest = os.path.join(folder, "finest.ply")
        run(program, "extract", self.container, "-o", finest, "--level", 99)
        self.finest = check_closed.Census(check_closed.read_ply(finest))
        said = run(program, "extract", self.container, "-o", finest, "--eye=0,0,0", "--kappa", 1, status=2)
        self.least_kappa = float(re.findall(r"[0-9]+\.[0-9]+", said)[-1])

    def look(self, number, eye, kappa):
        """The census of the view, and whether it holds several levels."""
        view = os.path.join(self.folder, f"view{number}.ply")
        said = run(self.program, "extract", self.container, "-o", view,
                   "--eye=" + ",".join(repr(float(x)) for x in eye), "--kappa", repr(kappa))
        census = check_closed.Census(check_closed.read_ply(view))
        os.remove(view)
        return census, holds_several_levels(said)


def prove(program, source, arguments):
    """Whether all is well; prints a line, and one per open view."""
    options = ["--leaf-triangles", arguments.leaf_triangles] if arguments.leaf_triangles else []
    with tempfile.TemporaryDirectory(prefix="colossus-eyes-") as folder:
        looks = Looks(program, source, folder, options)
        if not looks.finest.is_closed:
            print(f"{source}: left out, open by itself: {len(looks.finest.border)} border edges", flush=True)
            return True
        numbers = random.Random(arguments.seed)
        mesh = looks.finest.mesh
        views = []
        for eye in positions(mesh.points, mean_edge(mesh), arguments.eyes, numbers):
            views.append((eye, 2.0))
            views.append((eye, numbers.uniform(looks.least_kappa, GREATEST_KAPPA)))
        border = nonmanifold = mixed = triangles = 0
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            seen = pool.map(lambda i: looks.look(i, *views[i]), range(len(views)))
            for (eye, kappa), (census, is_mixed) in zip(views, seen):
                border += len(census.border)
                nonmanifold += len(census.nonmanifold)
                triangles += len(census.mesh.triangles)
                mixed += is_mixed and kappa == 2.0
                if not census.is_closed:
                    print(f"{source}: open: eye {eye.tolist()}, kappa {kappa!r}: {census}", flush=True)
    print(f"{source}: {len(views)} views of {triangles} triangles, {border} border edges, {nonmanifold} non-manifold edges; "
          f"{mixed} of {arguments.eyes} views at kappa 2 hold several levels", flush=True)
    return border == 0 and 2 * mixed > arguments.eyes


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("files", nargs="+", metavar="FILE")
    parser.add_argument("--eyes", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--leaf-triangles", type=int)
    arguments = parser.parse_args()
    print(f"seed {arguments.seed}", flush=True)
    return 0 if all([prove(arguments.program, source, arguments) for source in arguments.files]) else 1


if __name__ == "__main__":
    sys.exit(main())
