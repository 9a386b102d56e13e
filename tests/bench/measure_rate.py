#!/usr/bin/env python3
"""Measures the rate of `colossus build`: input triangles / wall seconds of the whole command / cores.

measure_rate.py PROGRAMS [--triangles N] [--scheme NAME] [--ranks 1,2,3] [--rounds N] [--folder FOLDER] [--json FILE]

PROGRAMS is the folder of a build in preset bench; scripts/bench calls this. Each round runs the yardstick
(meshopt_simplify of the same statue in memory to half, one thread) and a build with each number of ranks, one after
the other, so that all of them meet the same machine; medians over the rounds are reported.
"""
import argparse
import datetime
import json
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import tempfile
import time


def run(command, folder):
    done = subprocess.run([str(c) for c in command], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: status {done.returncode}\n{done.stdout}")
    return done.stdout


def measure_build(programs, folder, ranks, scheme):
    """Wall seconds of the command, largest resident set of each rank, size of the container."""
    with tempfile.TemporaryDirectory(dir=folder) as memory:
        command = ["mpirun", "-n", ranks, programs / "tests/bench/rank_memory", memory,
                   programs / "src/cli/colossus", "build", "statue.ply", "-o", "statue.h5",
                   "--scheme", scheme]
        start = time.monotonic()
        run(command, folder)
        seconds = time.monotonic() - start
        peaks = [int((pathlib.Path(memory) / f"rank_{rank}").read_text()) for rank in range(ranks)]
    return {"seconds": seconds, "peak_bytes_per_rank": peaks, "container_bytes": (folder / "statue.h5").stat().st_size}


def cpu_name():
    try:
        for line in open("/proc/cpuinfo"):
            if line.startswith("model name"):
                return line.split(":")[1].strip()
    except OSError:
        pass
    return platform.machine()


def summarize(ranks, runs, triangles, cores):
    seconds = statistics.median(r["seconds"] for r in runs)
    peaks = [max(values) for values in zip(*(r["peak_bytes_per_rank"] for r in runs))]
    return {"ranks": ranks, "seconds": seconds, "all_seconds": [r["seconds"] for r in runs],
            "triangles_per_second": triangles / seconds, "triangles_per_second_per_core": triangles / seconds / cores,
            "peak_bytes_per_rank": peaks, "container_bytes": runs[0]["container_bytes"]}


def main():
    cores = len(os.sched_getaffinity(0))
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("--triangles", type=int, default=6_000_000, help="size of the statue (default 6000000)")
    parser.add_argument("--scheme", default="diamonds")
    parser.add_argument("--ranks", default=",".join(str(n) for n in sorted({1, cores, cores + 1})),
                        help="numbers of ranks to try (default %(default)s)")
    parser.add_argument("--rounds", type=int, default=3, help="runs of each, of which the median counts (default 3)")
    parser.add_argument("--folder", type=pathlib.Path, help="for the statue and its container (default: a temporary one)")
    parser.add_argument("--json", type=pathlib.Path, help="where to write all figures")
    options = parser.parse_args()
    programs = options.programs.resolve()
    rank_numbers = [int(n) for n in options.ranks.split(",")]

    with tempfile.TemporaryDirectory(dir=options.folder) as name:
        folder = pathlib.Path(name)
        print(f"synth --seed 1 --triangles {options.triangles}, with colours", flush=True)
        run([programs / "src/cli/colossus", "synth", "--seed", 1, "--triangles", options.triangles, "-o", "statue.ply"],
            folder)
        builds, yards = {n: [] for n in rank_numbers}, []
        for number in range(1, options.rounds + 1):
            yards.append(json.loads(run([programs / "tests/bench/yardstick", "statue.ply"], folder)))
            print(f"round {number}: yardstick {yards[-1]['seconds']:.2f} s", end="", flush=True)
            for ranks in rank_numbers:
                builds[ranks].append(measure_build(programs, folder, ranks, options.scheme))
                print(f", {ranks} ranks {builds[ranks][-1]['seconds']:.2f} s", end="", flush=True)
            print(flush=True)
        statue_bytes = (folder / "statue.ply").stat().st_size

    triangles = yards[0]["triangles"]
    yard_rate = triangles / statistics.median(y["seconds"] for y in yards)
    results = [summarize(n, builds[n], triangles, cores) for n in rank_numbers]
    best = max(results, key=lambda r: r["triangles_per_second"])
    report = {
        "date": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
        "machine": {"cpu": cpu_name(), "cores": cores},
        "triangles": triangles, "statue_bytes": statue_bytes, "rounds": options.rounds,
        "yardstick_triangles_per_second": yard_rate,
        "builds": results, "best": best,
        "rate_per_core": best["triangles_per_second_per_core"],
        "rate_per_core_to_yardstick": best["triangles_per_second_per_core"] / yard_rate,
    }
    print(f"{triangles} triangles, {cores} cores ({report['machine']['cpu']}), median of {options.rounds}")
    print(f"{'ranks':>5} {'seconds':>8} {'Mtri/s/core':>12} {'peak memory per rank, MB'}")
    for r in results:
        peaks = " ".join(f"{p / 2**20:.0f}" for p in r["peak_bytes_per_rank"])
        print(f"{r['ranks']:5d} {r['seconds']:8.2f} {r['triangles_per_second_per_core'] / 1e6:12.3f} {peaks}")
    print(f"yardstick, meshopt_simplify to half, one thread: {yard_rate / 1e6:.3f} Mtri/s")
    print(f"rate {report['rate_per_core'] / 1e6:.3f} million triangles per second per core with {best['ranks']} ranks, "
          f"{report['rate_per_core_to_yardstick']:.3f} of the yardstick")
    if options.json:
        options.json.write_text(json.dumps(report, indent=2) + "\n")
        print(f"all figures: {options.json}")


if __name__ == "__main__":
    main()
