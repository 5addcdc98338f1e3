"""mwidthd doctor, as a person and as a script would run it."""

import json
import pathlib
import subprocess
import tempfile
import unittest

from server_process import BUILD

MWIDTHD = BUILD / "bin" / "mwidthd"
CONFIG = pathlib.Path(__file__).parents[2] / "deploy/config"


def doctor(*arguments):
    return subprocess.run([MWIDTHD, "doctor", *map(str, arguments)], capture_output=True, text=True, timeout=60)


class DoctorTest(unittest.TestCase):
    def test_it_examines_this_host_and_its_exit_code_tells_of_problems(self):
        report = doctor("--json")
        answer = json.loads(report.stdout)
        self.assertEqual(report.returncode, 1 if answer["problems"] else 0, report.stdout)
        subjects = [finding["subject"] for finding in answer["findings"]]
        for subject in ("kernel", "real-time priority", "locked memory", "throttling", "isolation", "interrupts",
                        "CPU governor", "idle states", "clock source"):
            self.assertIn(subject, subjects)
        for finding in answer["findings"]:
            self.assertIn(finding["verdict"], ("ok", "warning", "problem"))
            self.assertEqual(finding["verdict"] == "ok", finding["advice"] == "", finding)

    def test_it_holds_the_host_against_the_configuration(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "pinned.toml"
            text = (CONFIG / "elbow.toml").read_text()
            file.write_text(text.replace("# cpu = 1", "cpu = 1000"))
            report = doctor("--config", file)
            self.assertEqual(report.returncode, 1)
            self.assertIn("problem  isolation: a loop is pinned to CPU 1000", report.stdout)

    def test_a_host_without_files_is_not_fit(self):
        with tempfile.TemporaryDirectory() as folder:
            report = doctor("--root", folder)
            self.assertEqual(report.returncode, 1)
            self.assertIn("rtprio", report.stdout)

    def test_wrong_usage_is_explained(self):
        self.assertEqual(doctor("--root", "/no/such/folder").returncode, 2)
        self.assertEqual(doctor("--config", "no-such").returncode, 2)


if __name__ == "__main__":
    unittest.main()
