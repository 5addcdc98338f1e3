"""The example and the study, run as programs against a server that answers as mwidthd does."""

import csv
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import mwidth
from fake_server import FakeServer

# Where the build puts the programs: beside the package.
PROGRAMS = pathlib.Path(mwidth.__file__).parent.parent


def run(program, *arguments):
    return subprocess.run(
        [sys.executable, PROGRAMS / program, *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        # The programs must find the package by themselves.
        env={name: value for name, value in os.environ.items() if name != "PYTHONPATH"},
    )


class ProgramsTest(unittest.TestCase):
    def setUp(self):
        self.server = self.enterContext(FakeServer())

    def test_example_renders_streams_and_shows_a_refusal(self):
        done = run("example.py", self.server.address)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("rendering 0.175, gain margin 9.1 dB", done.stdout)
        self.assertIn(" 1.005 s  position", done.stdout)
        self.assertIn("refused (UNSTABLE_MASS): that mass is unstable", done.stdout)
        self.assertIn("nearest admitted mass: 0.35", done.stdout)
        self.assertEqual(self.server.calls[-1], "ReleaseControl")

    def test_example_says_that_nobody_answers(self):
        done = run("example.py", "127.0.0.1:1")
        self.assertEqual(done.returncode, 1)
        self.assertIn("failed to connect", done.stderr)

    def test_study_compares_commanded_with_perceived_mass(self):
        with tempfile.TemporaryDirectory() as folder:
            done = run("reach_study.py", "--server", self.server.address, "--output", folder, "--reaches", "1")
            self.assertEqual(done.returncode, 0, done.stderr)
            picture = (pathlib.Path(folder) / "reaches.png").read_bytes()
            with (pathlib.Path(folder) / "reaches.csv").open() as file:
                rows = list(csv.DictReader(file))
        self.assertTrue(picture.startswith(b"\x89PNG"))
        # M = 0, half the device's mass, and three quarters of the lower edge: rendered ideally by the fake.
        lines = [line.split() for line in done.stdout.splitlines()]
        table = {line[0]: line[1:] for line in lines if len(line) == 6 and line[0][0] in "+-"}
        self.assertEqual(list(table), ["+0.00000", "+0.02500", "-0.02250"])
        for ideal, perceived, error, overshoot, _ in table.values():
            self.assertAlmostEqual(float(perceived) / float(ideal), 1, delta=0.01)
            self.assertLess(abs(float(error.rstrip("%"))), 1)
            self.assertLess(abs(float(overshoot.rstrip("%"))), 0.2)
        self.assertEqual(table["+0.02500"][-1], "26.0")
        self.assertIn("15 ticks had no sample", done.stdout)
        self.assertIn("A virtual mass of +0.75 kg m² was refused (UNSTABLE_MASS):", done.stdout)
        self.assertIn("  that mass is unstable\n", done.stdout)
        self.assertEqual({row["mass_kg_m2"] for row in rows}, {"0.0", "0.025", "-0.0225"})
        self.assertEqual(self.server.calls[-2:], ["StopRendering", "ReleaseControl"])

    def test_study_without_a_server_fails_with_its_reason(self):
        done = run("reach_study.py", "--server", "127.0.0.1:1")
        self.assertEqual(done.returncode, 1)
        self.assertIn("reach study: failed to connect", done.stderr)


if __name__ == "__main__":
    unittest.main()
