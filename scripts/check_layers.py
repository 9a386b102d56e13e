#!/usr/bin/env python3
"""Checks that the folders of src/ depend on each other only as src/README.md draws it.

check_layers.py [SOURCE_FOLDER]    default: src/ beside this script's folder

Each folder, and each folder within one, includes headers of the folders that it is allowed only, and of these only
those that its CMake target links; the target links no folder that it may not; a system's header stays in the folder
that hides it; a header whose first line says "Private to this folder" is included there only; each file has a namespace,
which is named like its folder. What is in the folders of a scheme only the tables of schemes (schemes.cpp) include, and the
other folders of this scheme. Each folder has tests: tests/, where it lies beside SOURCE_FOLDER, has the same folders.
Prints one line per violation; exit status 1 if there is any.
"""
import pathlib
import re
import sys

GROUND = {"core", "geometry"}
MESH = GROUND | {"mesh", "hierarchy"}
CODEC = {"codec", "codec/coded", "codec/entropy", "codec/quantization"}
CODED = MESH | {"codec/coded"}  # what the form of a coded node is about
READ = CODED | {"codec", "container"}
ROOMS = ["facts", "run", "ingest", "nodes", "buckets"]  # of the pipeline, each above those before it
BELOW_PIPELINE = READ | CODEC | {"simplify", "input", "cluster", "scratch"}


def pipeline_below(count):
    return BELOW_PIPELINE | {f"pipeline/{room}" for room in ROOMS[:count]}


# For each folder, what it may include beside itself. A folder's own files stand above the folders within it.
ALLOWED = {
    "core": set(),
    "geometry": {"core"},
    "mesh": GROUND,
    "hierarchy": GROUND,
    "simplify": GROUND | {"mesh"},
    "codec/coded": MESH,
    "codec/entropy": {"core"},
    "codec/quantization": CODED,
    "codec/predict": CODED | {"codec/entropy"},
    "codec/paper": CODED | {"codec/entropy"},
    "codec/zstd": CODED,
    "codec": CODED | {"codec/predict", "codec/paper", "codec/zstd"},
    "input": GROUND,
    "synth": {"core"},
    "cluster": {"core"},
    "scratch": {"core"},
    "container/hdf5": {"core"},
    "container": GROUND | {"container/hdf5"},
    **{f"pipeline/{room}": pipeline_below(number) for number, room in enumerate(ROOMS)},
    "pipeline/diamonds": pipeline_below(len(ROOMS)),
    "pipeline/blocks": pipeline_below(len(ROOMS)),
    "pipeline": pipeline_below(len(ROOMS)) | {"pipeline/diamonds", "pipeline/blocks"},
    "reader/access": READ,
    "reader/diamonds": READ | {"reader/access"},
    "reader/blocks": READ | {"reader/access"},
    "reader": READ | {"reader/access", "reader/diamonds", "reader/blocks"},
    "exporters": MESH | {"reader/access"},
    "verify/measure": READ | {"reader/access"},
    "verify/diamonds": READ | {"reader/access", "reader/diamonds", "verify/measure"},
    "verify/blocks": READ | {"reader/access", "reader/blocks", "verify/measure"},
    "verify": {"core", "reader/access", "reader/diamonds", "reader/blocks", "verify/measure", "verify/diamonds",
               "verify/blocks"},
    "cli": {"core", "input", "synth", "cluster", "pipeline", "pipeline/facts", "pipeline/run", "reader", "reader/access",
            "exporters", "verify", "verify/measure"},
}
# Only the cluster's ranks share MPI; what facts are does not depend on it.
ALLOWED["pipeline/facts"] = ALLOWED["pipeline/facts"] - {"cluster"}

FILES = {"core", "input", "synth", "scratch", "container", "container/hdf5", "exporters", "cli"}
FILES |= {folder for folder in ALLOWED if folder.split("/")[0] in ("pipeline", "reader", "verify")}

SCHEMES = {"diamonds", "blocks"}
TABLE_OF_SCHEMES = "schemes.cpp"

# Headers of others that only some folders may include.
OWNERS = [
    (re.compile(r"(.*/)?mpi\.h"), {"cluster"}),
    (re.compile(r"(.*/)?(hdf5|H5\w*)\.h"), {"container", "container/hdf5"}),
    (re.compile(r"zstd.*\.h"), {"container", "container/hdf5"}),
    (re.compile(r"meshoptimizer\.h"), {"codec/zstd"}),
    (re.compile(r"CLI/.*"), {"cli"}),
    # What runs in a unit test and under a fuzzer knows no files.
    (re.compile(r"fstream|filesystem|fcntl\.h|core/file\.hpp"), FILES),
]

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*(?:"([^"]+)"|<([^>]+)>)', re.MULTILINE)
TARGET = re.compile(r"colossus::(\w+)")
FOREIGN_SUFFIXES = {".h", ".hh", ".hxx", ".h++", ".c", ".cc", ".cxx", ".c++", ".inc", ".ipp", ".inl", ".tpp"}
NAMESPACE = re.compile(r"^namespace (colossus(?:::\w+)*) \{", re.MULTILINE)


def target_of(folder):
    return folder.replace("/", "_")


def scheme_of(folder):
    name = folder.rsplit("/", 1)[-1]
    return name if name in SCHEMES else None


def line_of(text, offset):
    return text.count("\n", 0, offset) + 1


def linked_folders(source):
    """For each folder, all folders that its CMake target links, directly or through others; and the violations."""
    folder_of = {target_of(folder): folder for folder in ALLOWED}
    direct, violations = {}, []
    for folder in sorted(ALLOWED):
        path = source / folder / "CMakeLists.txt"
        direct[folder] = set()
        if not path.exists():
            violations.append(f"{path}: expected this file: scripts/check_layers.py knows the folder {folder}")
            continue
        for target in sorted(set(TARGET.findall(re.sub(r"#.*", "", path.read_text()))) - {target_of(folder)}):
            if folder_of.get(target) in ALLOWED[folder]:
                direct[folder].add(folder_of[target])
            else:
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


def check_include(source, place, header, folder, linked):
    target = str(pathlib.PurePosixPath(header).parent)
    if target not in ALLOWED:
        yield f'{place}: "{header}" should start with a folder of src/'
    elif target != folder:
        if target not in ALLOWED[folder]:
            yield f"{place}: {folder} may not include {header}"
        elif scheme_of(target) not in (None, scheme_of(folder)) and not place.rsplit(":", 1)[0].endswith(
                "/" + TABLE_OF_SCHEMES):
            yield f"{place}: {header} is of one scheme; only {TABLE_OF_SCHEMES} and folders {scheme_of(target)}/ include it"
        elif target not in linked:
            yield f"{place}: {folder} includes {header}, but does not link colossus::{target_of(target)}"
        if (source / header).exists() and (source / header).read_text().startswith("// Private to this folder"):
            yield f"{place}: {header} is private to {target}"


def check_file(source, path, folder, linked):
    text = path.read_text()
    for match in INCLUDE.finditer(text):
        place = f"{path}:{line_of(text, match.start())}"
        header = match[1] or match[2]
        for pattern, owners in OWNERS:
            if pattern.fullmatch(header) and folder not in owners:
                yield f"{place}: {folder} may not include {header}; only {', '.join(sorted(owners))} may"
        if match[1]:
            yield from check_include(source, place, header, folder, linked)
    expected = "colossus::" + folder.replace("/", "::")
    found = [(match, match[1]) for match in NAMESPACE.finditer(text)]
    for match, name in found:
        if name != expected:
            yield f"{path}:{line_of(text, match.start())}: expected namespace {expected}, found {name}"
    if not found and "int main(" not in text:
        yield f"{path}: expected namespace {expected}, found none"


def check_tests(source, tests):
    for folder in sorted(ALLOWED):
        if not any(path.suffix in (".cpp", ".py") for path in (tests / folder).glob("*")):
            yield f"{source / folder}: expected tests in {tests / folder}"


def check(source):
    linked, violations = linked_folders(source)
    for path in sorted(source.rglob("*")):
        folder = str(path.parent.relative_to(source))
        if path.suffix in FOREIGN_SUFFIXES:
            violations.append(f"{path}: expected a name that ends in .cpp or .hpp")
        elif path.suffix not in (".cpp", ".hpp"):
            continue
        elif folder in ALLOWED:
            violations.extend(check_file(source, path, folder, linked[folder]))
        else:
            violations.append(f"{path}: scripts/check_layers.py does not know the folder {folder}")
    tests = source.parent / "tests"
    if tests.exists():
        violations.extend(check_tests(source, tests))
    return violations


def main():
    default = pathlib.Path(__file__).resolve().parent.parent / "src"
    source = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default
    violations = check(source)
    print("\n".join(violations) if violations else f"{source}: {len(ALLOWED)} folders keep their layers")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
