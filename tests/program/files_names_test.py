"""How a build is started and what it is told: launchers, names that are no UTF-8, odd values of all options."""
import itertools
import json
import os
import re
import subprocess

import program
from files import BAD_DATA, CANNOT_CREATE, IO, MOST_SECONDS, NO_RESOURCES, RANKS, USAGE, FilesTest

ODD_VALUES = ("", ".", "/", "x", "nan", "inf", "-inf", "-1", "0", "1", "1e308", "1.5", "4294967295", "4294967296",
              "18446744073709551615", "18446744073709551616", "99999999999999999999999")


class Launchers(FilesTest):
    def test_programs_that_were_started_as_one_of_several(self):
        for environment in ({"SLURM_NTASKS": "3", "SLURM_STEP_NUM_TASKS": "3", "SLURM_PROCID": "0"}, {"PMI_SIZE": "3"},
                            {"SLURM_STEP_NUM_TASKS": "3", "SLURM_PROCID": "2"}):
            run = self.assert_spares("build", "in.ply", "-o", "o.h5", "--status", "st.json", environment=environment)
            for text in b"3 programs of one rank each", b"srun --mpi=pmix", b"mpirun":
                self.assertIn(text, run.stderr)
            self.run_in_folder("synth", "--triangles", 20, "-o", "s.ply", environment=environment)
            os.remove(self.path("s.ply"))

    def test_programs_that_know_their_rank_only(self):
        """MPI sets PMIX_RANK, too, when it starts: what the launcher set must be read before."""
        for environment in {"PMIX_RANK": "2"}, {"PMI_RANK": "1"}:
            run = self.assert_spares("build", "in.ply", "-o", "o.h5", environment=environment)
            self.assertIn(b"several programs of one rank each", run.stderr)
        self.run_in_folder("build", "in.ply", "-o", "o.h5", environment={"PMIX_RANK": "0"})

    def test_programs_that_are_alone(self):
        for environment in ({}, {"SLURM_JOB_ID": "1", "SLURM_NTASKS": "3", "SLURM_PROCID": "0"},
                            {"SLURM_NTASKS": "1", "SLURM_STEP_NUM_TASKS": "1", "SLURM_PROCID": "0"}):
            self.run_in_folder("build", "in.ply", "-o", "o.h5", environment=environment)
        self.run_in_folder("build", "in.ply", "-o", "o.h5", ranks=1,
                           environment={"SLURM_NTASKS": "3", "SLURM_STEP_NUM_TASKS": "3"})


class Names(FilesTest):
    def test_that_are_no_utf_8(self):
        odd, shown = b"sc\xc3\xa4n \xff\\\xc3.ply", "scän \\xff\\\\\\xc3.ply"
        os.rename(self.path("in.ply"), os.fsencode(self.path("")) + odd)
        for ranks in RANKS:
            self.run_in_folder("build", odd, "-o", b"o\xfe.h5", "--report", b"r\xfe.json", "--status", b"s\xfe.json",
                               ranks=ranks)
            with open(os.fsencode(self.path("")) + b"r\xfe.json", encoding="utf-8") as file:
                report = json.load(file)
            self.assertEqual(report["inputs"][0]["name"], shown)
            self.assertIn(shown, report["command"])
            self.assertEqual(report["output"]["path"], "o\\xfe.h5")
        info = json.loads(self.run_in_folder("info", "--json", b"o\xfe.h5").stdout.decode("utf-8"))
        self.assertEqual(info["inputs"][0]["name"], shown)
        self.assertEqual(info["file"]["path"], "o\\xfe.h5")
        self.run_in_folder("info", b"o\xfe.h5")
        self.run_in_folder("build", odd, "-o", "none/o.h5", "--report", "r.json", status=CANNOT_CREATE)
        self.run_in_folder("build", b"\xff", "-o", "o.h5", "--report", "r.json", "--status", "s.json", status=BAD_DATA)
        with open(self.path("r.json"), encoding="utf-8") as file:
            self.assertIn("\\xff", json.load(file)["message"])
        self.run_in_folder("build", odd, "-o", "o.h5", "--scheme", b"\xff", status=USAGE)

    def test_in_the_environment_and_the_folder(self):
        folder = os.fsencode(self.path("")) + b"\xff"
        os.mkdir(folder)
        environment = {**{os.fsencode(k): os.fsencode(v) for k, v in os.environ.items()}, b"SLURM_JOB_NAME": b"\xfe"}
        run = subprocess.run(self.command("build", "../in.ply", "-o", "o.h5", "--report", "r.json"), cwd=folder,
                             env=environment, capture_output=True, check=False, timeout=MOST_SECONDS)
        self.assertEqual(run.returncode, program.OK, run.stderr)
        with open(folder + b"/r.json", encoding="utf-8") as file:
            report = json.load(file)
        self.assertTrue(report["folder"].endswith("\\xff"), report["folder"])
        self.assertEqual(report["job"]["SLURM_JOB_NAME"], "\\xfe")

    def test_a_valid_name_stays(self):
        os.rename(self.path("in.ply"), self.path("sc\\ä𝄞n.ply"))
        self.run_in_folder("build", "sc\\ä𝄞n.ply", "-o", "o.h5")
        self.assertEqual(self.info(self.path("o.h5"))["inputs"][0]["name"], "sc\\ä𝄞n.ply")

    def test_a_folder_that_was_removed(self):
        os.mkdir(self.path("gone"))
        script = ('cd gone && rmdir ../gone && exec "$0" build ../in.ply -o o.h5')
        run = subprocess.run(["sh", "-c", script, program.PROGRAM], cwd=self.folder, capture_output=True, check=False,
                             timeout=MOST_SECONDS)
        self.assertIn(run.returncode, (BAD_DATA, CANNOT_CREATE, IO), run.stderr)


class Options(FilesTest):
    """Odd values never end with 70, by a signal, or not at all; and nonsense is not taken for something else."""
    RIGHT = (program.OK, USAGE, BAD_DATA, NO_RESOURCES, CANNOT_CREATE)

    def check(self, *arguments, option):
        for value in ODD_VALUES:
            run = self.run_in_folder(*arguments, f"{option}={value}", status=self.RIGHT)
            self.assertNotIn(b"internal error", run.stderr)
            is_negative_or_none = value.startswith("-") or value in ("nan", "", "x", ".", "/")
            if is_negative_or_none and option not in ("--eye", "--base"):
                self.assertEqual(run.returncode, USAGE, f"{arguments} {option}={value}")

    def test_of_build(self):
        options = ("--leaf-triangles", "--position-bits", "--tolerance", "--levels", "--block-size", "--color-weight",
                   "--memory", "--time-limit", "--codec", "--scheme")
        for option, scheme in itertools.product(options, ("diamonds", "blocks")):
            self.check("build", "in.ply", "-o", "o.h5", *(() if option == "--scheme" else ("--scheme", scheme)),
                       option=option)

    def test_of_the_other_commands(self):
        for scheme in "diamonds", "blocks":
            self.run_in_folder("build", "in.ply", "-o", f"{scheme}.h5", "--scheme", scheme, "--leaf-triangles", 50)
            for option in "--level", "--error", "--triangles":
                self.check("extract", f"{scheme}.h5", "-o", "cut.ply", option=option)
            self.check("extract", f"{scheme}.h5", "-o", "cut.ply", "--eye=0,0,0", option="--kappa")
            for value in ODD_VALUES:
                run = self.run_in_folder("extract", f"{scheme}.h5", "-o", "cut.ply", f"--eye={value},0,0", status=self.RIGHT)
                self.assertTrue(run.returncode == USAGE or re.fullmatch("[-0-9.e]+", value), value)
            self.check("verify", f"{scheme}.h5", "--against", "in.ply", option="--samples")
        self.check("synth", "--triangles", 20, "-o", "s.ply", option="--seed")
        for value in ODD_VALUES:
            if value not in ("4294967295",):  # which would be made
                self.run_in_folder("synth", "-o", "s.ply", f"--triangles={value}",
                                   status=program.OK if value == "1" else USAGE)


if __name__ == "__main__":
    program.main()
