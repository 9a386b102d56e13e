#!/usr/bin/env python3
"""Checks that the folders of src/ depend on each other only as src/README.md draws it.

check_layers.py [SOURCE_FOLDER]    default: src/ beside this script's folder

Each folder includes headers of folders below it only, and only of those that its CMake target links; the target links
no folder that it may not; a system's header stays in the folder that hides it. Prints one line per violation; exit
status 1 if there is any.
"""
import pathlib
import re
import sys

# For each folder, what it may include beside itself.
ALLOWED = {
    "core": set(),
    "geometry": {"core"},
    "mesh": {"core", "geometry"},
    "hierarchy": {"core", "geometry"},
    "simplify": {"core", "geometry", "mesh"},
    "codec": {"core", "geometry", "mesh", "hierarchy"},
    "input": {"core", "geometry", "mesh"},
    "cluster": {"core"},
    "scratch": {"core"},
    "container": {"core", "geometry"},
    "reader": {"core", "geometry", "mesh", "hierarchy", "codec", "container"},
    "build": {"core", "geometry", "mesh", "hierarchy", "simplify", "codec", "input", "cluster", "scratch", "container"},
    "cli": {"core", "input", "cluster", "build", "reader"},
}

# Headers of others that only some folders may include.
OWNERS = [
    (re.compile(r"(.*/)?mpi\.h"), {"cluster"}),
    (re.compile(r"(.*/)?(hdf5|H5\w*)\.h"), {"container"}),
    (re.compile(r"zstd.*\.h"), {"container"}),
    (re.compile(r"meshoptimizer\.h"), {"codec"}),
    (re.compile(r"CLI/.*"), {"cli"}),
    # What runs in a unit test and under a fuzzer knows no files.
    (re.compile(r"fstream|filesystem|fcntl\.h|core/file\.hpp"), {"core", "input", "scratch", "container", "reader",
                                                                 "build", "cli"}),
]

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*(?:"([^"]+)"|<([^>]+)>)', re.MULTILINE)
TARGET = re.compile(r"colossus::(\w+)")


def line_of(text, offset):
    return text.count("\n", 0, offset) + 1


def linked_folders(source):
    """For each folder, all folders that its CMake target links, directly or through others; and the violations."""
    direct, violations = {}, []
    for folder in sorted(ALLOWED):
        path = source / folder / "CMakeLists.txt"
        if not path.exists():
            violations.append(f"{path}: expected this file: scripts/check_layers.py knows the folder {folder}")
            direct[folder] = set()
            continue
        text = re.sub(r"#.*", "", path.read_text())
        direct[folder] = set(TARGET.findall(text)) - {folder}
        for target in sorted(direct[folder] - ALLOWED[folder]):
            violations.append(f"{path}: {folder} may not link colossus::{target}")
    linked = {}
    for folder in direct:
        seen, todo = set(), [folder]
        while todo:
            for target in direct.get(todo.pop(), ()):
                if target not in seen:
                    seen.add(target)
                    todo.append(target)
        linked[folder] = seen
    return linked, violations


def check_file(path, folder, linked):
    text = path.read_text()
    for match in INCLUDE.finditer(text):
        place = f"{path}:{line_of(text, match.start())}"
        header = match[1] or match[2]
        for pattern, owners in OWNERS:
            if pattern.fullmatch(header) and folder not in owners:
                yield f"{place}: {folder} may not include {header}; only {', '.join(sorted(owners))} may"
        if not match[1]:
            continue
        target = header.split("/")[0]
        if target not in ALLOWED:
            yield f'{place}: "{header}" should start with a folder of src/'
        elif target != folder:
            if target not in ALLOWED[folder]:
                yield f"{place}: {folder} may not include {header}"
            elif target not in linked:
                yield f"{place}: {folder} includes {header}, but does not link colossus::{target}"
            if "/detail/" in header:
                yield f"{place}: {header} is private to {target}"


def check(source):
    linked, violations = linked_folders(source)
    for folder in sorted(p.name for p in source.iterdir() if p.is_dir()):
        if folder not in ALLOWED:
            violations.append(f"{source / folder}: scripts/check_layers.py does not know this folder")
            continue
        for path in sorted((source / folder).rglob("*.[ch]pp")):
            violations.extend(check_file(path, folder, linked[folder]))
    return violations


def main():
    default = pathlib.Path(__file__).resolve().parent.parent / "src"
    source = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default
    violations = check(source)
    print("\n".join(violations) if violations else f"{source}: {len(ALLOWED)} folders keep their layers")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
