#!/usr/bin/env python3
"""Builds statues of several sizes, and prints what a build took and used beside what it had estimated.

measure_sizes.py PROGRAMS [--sizes 1,6,25,100] [--scheme NAME] [--ranks N] [--memory SIZE] [--shuffle] [--verify]
                 [--folder FOLDER] [--json FILE]

PROGRAMS is the folder of a build in preset bench; scripts/bench --sizes calls this. The figures are those of
`colossus build --report`, but for the seconds, which are those of the whole command. The largest size needs some 15 GB
in FOLDER.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time


def run(command, folder):
    done = subprocess.run([str(c) for c in command], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: status {done.returncode}\n{done.stdout}")


def measure(program, folder, millions, options):
    shuffle = ["--shuffle"] if options.shuffle else []
    run([program, "synth", "--seed", 1, "--triangles", round(millions * 1e6), *shuffle, "-o", "statue.ply"], folder)
    start = time.monotonic()
    run(["mpirun", "--bind-to", "none", "-n", options.ranks, program, "build", "statue.ply", "-o", "statue.h5",
         "--scheme", options.scheme, "--memory", options.memory, "--report", "report.json"], folder)
    seconds = time.monotonic() - start
    if options.verify:
        run([program, "verify", "statue.h5"], folder)
    report = json.loads((folder / "report.json").read_text())
    estimate, used = report["estimate"], report["used"]
    needs = {"memory": (estimate["memory_bytes_per_rank"], max(used["peak_memory_bytes"])),
             "scratch": (estimate["scratch_bytes"], used["scratch_bytes"]),
             "output": (estimate["output_bytes"], used["output_bytes"])}
    triangles = report["counts"]["triangles"]
    return {"triangles": triangles, "seconds": seconds, "needs": needs,
            "triangles_per_second_per_core": triangles / seconds / len(os.sched_getaffinity(0))}


def main():
    cores = len(os.sched_getaffinity(0))
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("--sizes", default="1,6,25", help="millions of triangles (default %(default)s)")
    parser.add_argument("--scheme", default="diamonds")
    parser.add_argument("--ranks", type=int, default=cores + 1)
    parser.add_argument("--memory", default="512M")
    parser.add_argument("--shuffle", action="store_true")
    parser.add_argument("--verify", action="store_true", help="verify each container, too")
    parser.add_argument("--folder", type=pathlib.Path, help="for statues and containers (default: a temporary one)")
    parser.add_argument("--json", type=pathlib.Path, help="where to write all figures")
    options = parser.parse_args()
    program = options.programs.resolve() / "src/cli/colossus"
    results = []
    print(f"{options.scheme}, {options.ranks} ranks on {cores} cores, --memory {options.memory}"
          f"{', shuffled' if options.shuffle else ''}; in brackets: estimate beside truth")
    print("million triangles | seconds | Mtri/s/core | memory per rank, MB | scratch, MB | output, MB")
    for millions in map(float, options.sizes.split(",")):
        with tempfile.TemporaryDirectory(dir=options.folder) as folder:
            result = measure(program, pathlib.Path(folder), millions, options)
        results.append(result)
        print(f"{result['triangles'] / 1e6:.1f} | {result['seconds']:.1f} | "
              f"{result['triangles_per_second_per_core'] / 1e6:.3f}", end="")
        for estimate, used in result["needs"].values():
            print(f" | {used / 2**20:.0f} ({estimate / used:.2f})", end="")
        print(flush=True)
    if options.json:
        options.json.write_text(json.dumps(results, indent=2) + "\n")


if __name__ == "__main__":
    main()
