"""The analyses of the command line: a server and a configuration file without one give the same answers."""

import csv
import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from server_process import BUILD, ServerProcess

MWIDTH = BUILD / "bin" / "mwidth"
README = pathlib.Path(__file__).resolve().parents[2] / "client" / "cli" / "README.md"

QUESTIONS = (
    ["m-width"],
    ["m-width", "--rate-hz", "500", "--cutoff-hz", "30", "--delay-s", "0.0013"],
    ["m-width", "--hand-stiffness", "0", "--hand-damping", "0"],
    ["m-width", "--estimator", "butterworth", "--cutoff-hz", "40"],
    ["m-width", "--hand-stiffness-range", "10:900", "--hand-damping-range", "1:8", "--released-hand"],
    ["m-width", "--device-damping-range", "0.004:0.04", "--hand-mass-range", "0:0.01"],
    ["sweep", "cutoff-hz=1:100:40:log"],
    ["sweep", "cutoff-hz=1:100:9:log", "--estimator", "late-filtered-difference"],
    ["bode", "0.02", "--estimator", "kalman"],
    ["sweep", "cutoff-hz=1:100:12:log", "hand-stiffness=0:2000:7", "--hand-damping", "1"],
    ["sweep", "period-s=1e-4:1e-2:15:log"],
    ["bode", "0.05"],
    ["bode", "-0.02", "--min-hz", "1", "--max-hz", "100", "--count", "33", "--continuous"],
    ["accuracy", "0.05", "--simulate"],
    ["accuracy", "-0.02", "--max-hz", "2", "--duration-s", "20"],
    ["accuracy", "1e5"],
)


def run(*arguments):
    return subprocess.run([MWIDTH, *map(str, arguments)], capture_output=True, text=True, timeout=120)


class OfflineTest(unittest.TestCase):
    def answer(self, *arguments):
        result = run(*arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertTrue(result.stdout.strip())
        return result.stdout

    def test_both_ways_agree_to_the_last_digit(self):
        for config in ("paper", "elbow"):
            with ServerProcess("--config", config) as server:
                for question in QUESTIONS:
                    with self.subTest(config=config, question=question):
                        asked = self.answer("--json", "--server", server.address, *question)
                        self.assertEqual(asked, self.answer("--json", *question, "--offline", config))

    def test_the_same_is_refused_in_the_same_words(self):
        with ServerProcess("--config", "paper") as server:
            for question in (["m-width", "--cutoff-hz", "501"], ["m-width", "--hand-mass-range", "1:0"], ["bode", "1e7"], ["accuracy", "0.1", "--max-hz", "900"],
                             ["sweep", "cutoff-hz=10:1"], ["m-width", "--axis", "nobody"]):
                with self.subTest(question=question):
                    online = run("--json", "--server", server.address, *question)
                    offline = run("--json", *question, "--offline", "paper")
                    self.assertEqual(online.returncode, 1)
                    self.assertEqual(offline.returncode, 1)
                    self.assertEqual(online.stderr, offline.stderr)
                    # The metadata of the details is a map: its order means nothing.
                    self.assertEqual(json.loads(online.stdout), json.loads(offline.stdout))

    def test_csv_has_the_digits_of_json(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "bode.csv"
            answer = json.loads(self.answer("--json", "bode", "0.05", "--offline", "paper", "--csv", file))
            with file.open(newline="") as rows:
                table = list(csv.DictReader(rows))
            for column in table[0]:
                self.assertEqual([float(row[column]) for row in table], answer[column])
            with file.with_name("bode-margins.csv").open(newline="") as rows:
                margins = {row["margin"]: float(row["value"]) for row in csv.DictReader(rows)}
            self.assertEqual(margins, {name: float(answer["margins"][name]) for name in margins})
            self.assertEqual(set(margins), {"gain_db", "phase_deg", "delay_s", "modulus"})

            question = ["m-width", "--hand-stiffness-range", "100:2000", "--offline", "paper"]
            self.answer(*question, "--csv", file)
            with file.open(newline="") as rows:
                edges = {(row["interval"], row["edge"]): row for row in csv.DictReader(rows)}
            answer = json.loads(self.answer("--json", *question))["m_width"]
            self.assertEqual(float(edges["nominal", "min"]["mass_kg"]), answer["nominal"]["min"])
            self.assertEqual(float(edges["robust", "max"]["mass_kg"]), answer["robust"]["max"])
            self.assertEqual(float(edges["nominal", "min"]["hand_stiffness"]), 700)
            self.assertEqual(float(edges["admitted", "min"]["hand_stiffness"]), 2000)
            self.assertEqual(edges["robust", "min"]["estimator"], "filtered-difference")

            run("sweep", "cutoff-hz=1:2:2", "hand-damping=1:3:3", "--offline", "elbow", "--csv", file)
            with file.open(newline="") as rows:
                table = list(csv.DictReader(rows))
            self.assertEqual([(row["hand_damping"], row["cutoff_hz"]) for row in table],
                             [("1", "1"), ("1", "2"), ("2", "1"), ("2", "2"), ("3", "1"), ("3", "2")])
            self.assertIn("min_kg_m2", table[0])

    def test_every_analysis_draws(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, question in {"m-width": ["m-width"], "curves": ["sweep", "cutoff-hz=1:100:9:log"],
                                   "map": ["sweep", "cutoff-hz=1:100:9:log", "hand-stiffness=0:900:5"],
                                   "bode": ["bode", "0.05"], "accuracy": ["accuracy", "0.05"]}.items():
                for extension, signature in {"svg": b"<?xml", "png": b"\x89PNG"}.items():
                    picture = pathlib.Path(folder) / f"{name}.{extension}"
                    result = run(*question, "--offline", "paper", "--plot", picture)
                    self.assertEqual(result.returncode, 0, result.stderr)
                    self.assertTrue(picture.read_bytes().startswith(signature))

    def test_a_configuration_that_is_not_there_is_told(self):
        result = run("m-width", "--offline", "nowhere")
        self.assertEqual(result.returncode, 3)
        self.assertIn("nowhere", result.stderr)

    def test_an_unstable_mass_is_said_to_be_unstable(self):
        result = run("accuracy", "100", "--offline", "paper")
        self.assertEqual(result.returncode, 0)
        self.assertIn("unstable", result.stderr.lower())
        self.assertNotIn("nan", result.stdout.lower())

    def test_only_analyses_work_offline(self):
        self.assertEqual(run("set-mass", "0.1", "--offline", "paper").returncode, 2)

    def test_a_malformed_range_is_explained(self):
        for wrong in ("cutoff-hz", "cutoff-hz=1", "cut=1:2", "cutoff-hz=1:x", "cutoff-hz=1:2:3:4", "cutoff-hz=1:2:-3"):
            result = run("sweep", wrong, "--offline", "paper")
            self.assertEqual(result.returncode, 2, wrong)
            self.assertIn(wrong, result.stderr)

    def test_the_examples_of_the_readme_are_true(self):
        blocks = re.findall(r"```console\n(.*?)```", README.read_text(), re.DOTALL)
        analyses = [line[2:] for line in blocks[0].splitlines()
                    if re.match(r"\$ mwidth (m-width|sweep|bode|accuracy|figures) ", line)]
        self.assertEqual(len(analyses), 6)
        with tempfile.TemporaryDirectory() as folder, ServerProcess("--config", "paper") as server:
            environment = dict(os.environ, MWIDTH_SERVER=server.address,
                               PATH=f"{MWIDTH.parent}:{os.environ['PATH']}")
            for command in analyses:
                with self.subTest(command=command):
                    subprocess.run(["bash", "-e", "-c", command], cwd=folder, env=environment, check=True,
                                   capture_output=True, timeout=120)
            self.assertLessEqual({"map.svg", "bode.csv", "bode.png", "figures"}, set(os.listdir(folder)))
        offline = [block.split("\n", 1) for block in blocks[1:] if "--offline" in block]
        self.assertEqual(len(offline), 2)
        for command, output in offline:
            self.assertEqual(self.answer(*command.split()[2:]), output)
        refused = next(block for block in blocks if "Refused" in block)
        with ServerProcess("--config", "elbow") as server:
            result = run("--server", server.address, *refused.split("\n")[0].split()[2:])
            self.assertEqual(result.stderr, refused.split("\n", 1)[1])


if __name__ == "__main__":
    unittest.main()
