#!/usr/bin/env python3
"""Prints the share of lines that have run of each file of a folder, from what a build with --coverage has counted.

    scripts/line_coverage.py BUILD FOLDER [--each-file PERCENT] [--folder PERCENT]

Exit status 1 where a file, or the folder as a whole, is below. A line counts once, however many programs and templates have
it; one has run if it has run in any of them."""
import argparse
import collections
import json
import pathlib
import subprocess
import sys


def reports(build):
    """What gcov says of each object; of those that no program has run there is no .gcda, and all lines have run 0 times."""
    notes = sorted(str(path.resolve()) for path in build.rglob("*.gcno"))
    if not notes:
        sys.exit(f"{build}: no *.gcno: was it built with --coverage?")
    run = subprocess.run(["gcov", "--json-format", "--stdout", *notes], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                         check=True)
    return [json.loads(line) for line in run.stdout.splitlines() if line.strip()]


def lines_of(build, folder):
    """By file below the folder, by number: how often a line has run."""
    counts = collections.defaultdict(collections.Counter)
    for report in reports(build):
        here = pathlib.Path(report["current_working_directory"])
        for file in report["files"]:
            path = (here / file["file"]).resolve()
            if not path.is_relative_to(folder):
                continue
            for line in file["lines"]:
                counts[path][line["line_number"]] += line["count"]
    return counts


def ranges(numbers):
    text = []
    for number in numbers:
        if text and text[-1][1] == number - 1:
            text[-1][1] = number
        else:
            text.append([number, number])
    return ", ".join(str(a) if a == b else f"{a}-{b}" for a, b in text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--each-file", type=float, default=0.0, metavar="PERCENT")
    parser.add_argument("--folder", type=float, default=0.0, metavar="PERCENT", dest="whole")
    parser.add_argument("--missing", action="store_true", help="print the lines that have not run")
    options = parser.parse_args()
    folder = options.folder.resolve()
    counts = lines_of(options.build, folder)
    sources = {path for path in folder.rglob("*.cpp")}
    is_low = False
    for path in sorted(set(counts) | sources):
        lines = counts.get(path, {})
        missing = sorted(number for number, count in lines.items() if count == 0)
        share = 100.0 * (len(lines) - len(missing)) / len(lines) if lines else 0.0
        note = "" if share >= options.each_file else f"  below {options.each_file:g} %"
        is_low |= note != ""
        print(f"{share:6.1f} % of {len(lines):4}  {path.relative_to(folder)}{note}")
        if options.missing and missing:
            print(f"          {ranges(missing)}")
    total = sum(len(lines) for lines in counts.values())
    ran = sum(count > 0 for lines in counts.values() for count in lines.values())
    share = 100.0 * ran / max(total, 1)
    note = "" if share >= options.whole else f"  below {options.whole:g} %"
    print(f"{share:6.1f} % of {total:4}  in all{note}")
    return 1 if is_low or note else 0


if __name__ == "__main__":
    sys.exit(main())
