"""Lists of facts that are written for people, or for other programs, name what the program's tables name."""
import os
import re

import h5py

import program
from report_test import SCHEMAS, read_json

README = os.path.join(SCHEMAS, "..", "README.md")
# In words that differ: what holds for all, and what for blocks.
OPTIONS = {"diamonds": ["--tolerance", 0.5],
           "blocks": ["--position-bits", 10, "--block-size", 8, "--levels", 2, "--color-weight", 1]}


def options_of_readme(text):
    """(`--flag`, default, meaning) of each row of the README's table of options."""
    table = text[text.index("| `build` option |"):].split("\n\n")[0]
    return re.findall(r"^\| `(?:-., )?(--[a-z-]+)[^`]*` \|([^|]*)\|(.*)", table, re.M)


def documented(text, head):
    """The names in the first column of the table of schemas/container.md that follows `head`."""
    table = re.search(r"\| [^\n]*\n(?:\|[^\n]*\n)+", text[text.index(head):])[0]
    return {name for row in table.splitlines()[2:] for name in re.findall(r"`([a-z0-9_]+)`", row.split("|")[1])}


class Tables(program.ColossusTest):
    def statue(self):
        output = self.path("statue.ply")
        self.run_program("synth", "--triangles", 20000, "-o", output)
        return output

    def builds(self):
        """(scheme, report, info) of builds to which every option that shapes bytes is given once."""
        statue, report = self.statue(), self.path("report.json")
        for scheme, options in OPTIONS.items():
            output = self.build(f"{scheme}.h5", statue, options=["--scheme", scheme, "--leaf-triangles", 1000, "--report", report,
                                                                  "--keep-outliers", "--lenient", "--drop-textures", *options])
            yield scheme, read_json(report), self.info(output)

    def test_help_and_readme(self):
        """The same options in the same order, those of one scheme marked, with the same defaults."""
        text = self.run_program("build", "--help").stdout
        told = re.findall(r"^  (?:-o,)?(--[a-z-]+)(?: [A-Z]+(?:=(\S+))?)?", text, re.M)
        with open(README, encoding="utf-8") as file:
            rows = options_of_readme(file.read())
        self.assertEqual([flag for flag, _ in told], [flag for flag, _, _ in rows])
        self.assertGreater(len(rows), 15)
        for (flag, default), (_, cell, meaning) in zip(told, rows):
            if default:
                self.assertEqual(cell.strip(), default, flag)
            entry = re.search(rf"^  (?:-o,)?{flag}\b.*?(?=^  -|\Z)", text, re.M | re.S)[0]
            self.assertEqual(meaning.startswith(" blocks:"), " Of blocks:" in entry, flag)

    def test_report_and_schema(self):
        schema = read_json(os.path.join(SCHEMAS, "report.schema.json"))["properties"]
        self.assertFalse(schema["options"]["additionalProperties"])
        self.assertFalse(schema["counts"]["additionalProperties"])
        options = set()
        for _, report, info in self.builds():
            options |= set(report["options"])
            self.assertEqual(list(report["counts"]), list(schema["counts"]["properties"]))
            self.assertEqual(set(report["levels"][0]), set(schema["levels"]["items"]["properties"]))
            for name, value in info["counts"].items():
                self.assertEqual(report["counts"][name], value, name)
        self.assertEqual(options, set(schema["options"]["properties"]))

    def check_explained(self, container):
        """Each option, count and column has an attribute that says what it is."""
        with h5py.File(container) as file:
            for table in "options", "counts":
                for name in file[table]["name"]:
                    self.assertIn(f"row_{name.decode()}", file[table].attrs, table)
            for column in file["levels"].dtype.names:
                self.assertIn(f"field_{column}", file["levels"].attrs)

    def test_container(self):
        """schemas/container.md names what is stored; what `info` makes of the columns is there."""
        with open(os.path.join(SCHEMAS, "container.md"), encoding="utf-8") as file:
            text = file.read()
        counts, columns = documented(text, "**Counts.**"), documented(text, "**Columns of `/levels`.**")
        for scheme, _, info in self.builds():
            self.assertEqual(set(info["counts"]) | {"split_edges"}, counts)
            self.assertEqual(set(info["levels"][0]["statistics"]), columns)
            self.check_explained(self.path(f"{scheme}.h5"))
            lines = self.run_program("info", self.path(f"{scheme}.h5")).stdout.splitlines()
            head = next(i for i, line in enumerate(lines) if line.split()[:1] == ["level"] and "bits/vertex" in line)
            self.assertNotIn("-", lines[head + 1].split(), "a column that info looks for is not there")


if __name__ == "__main__":
    program.main()
