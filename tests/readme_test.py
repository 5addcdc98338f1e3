"""The README stays true: its commands run, its examples are files that are built and run, its links lead somewhere."""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "integration"))

from server_process import BUILD, ServerProcess  # noqa: E402

README = (ROOT / "README.md").read_text()


def block(name):
    """The code of the block marked `<!-- test: name -->`."""
    return re.search(rf"<!-- test: {name} -->\n```\w+\n(.*?)```", README, re.DOTALL).group(1)


class ReadmeTest(unittest.TestCase):
    def run_against_server(self, command, **options):
        with tempfile.TemporaryDirectory() as folder, \
                ServerProcess("--config", "paper", "--simulation-speed", "1",  # in lock step: no host is too busy
                              "--sessions", f"{folder}/mwidth-sessions") as server:
            environment = dict(os.environ, MWIDTH_SERVER=server.address, PYTHONPATH=str(BUILD / "python"),
                               PATH=f"{BUILD / 'bin'}:{os.environ['PATH']}")
            result = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, timeout=60,
                                    **options)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            return result.stdout

    def test_commands(self):
        self.run_against_server(["bash", "-e", "-c", block("cli")])

    def test_sessions(self):
        self.run_against_server(["bash", "-e", "-c", block("sessions")])

    def test_python_example_is_the_file_that_runs(self):
        example = ROOT / "client/python/example.py"
        self.assertEqual(block("python"), example.read_text())
        self.assertIn("refused", self.run_against_server(["/usr/bin/python3", example]).lower())

    def test_cpp_example_is_the_file_that_runs(self):
        self.assertEqual(block("cpp"), (ROOT / "client/cpp/example.cc").read_text())
        self.assertIn("refused", self.run_against_server([BUILD / "bin" / "mwidth-example"]).lower())

    def test_the_two_commands_exist_and_the_demo_runs(self):
        self.assertTrue(os.access(ROOT / "deploy/test", os.X_OK))
        # The build under test instead of a second, optimized one.
        environment = dict(os.environ, MWIDTH_DEMO_PRESET=BUILD.name)
        with tempfile.TemporaryDirectory() as folder:
            result = subprocess.run([ROOT / "deploy/demo", folder], env=environment, capture_output=True, text=True,
                                    timeout=300)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            self.assertTrue(list(pathlib.Path(folder).glob("*.png")))
            self.assertTrue(pathlib.Path(folder, "report.html").exists())

    def test_links_lead_to_files(self):
        for readme in ROOT.glob("**/README.md"):
            if "build" in readme.relative_to(ROOT).parts:
                continue
            for target in re.findall(r"\]\(([^)#:]+)\)", readme.read_text()):
                self.assertTrue((readme.parent / target).exists(), f"{readme}: {target}")


if __name__ == "__main__":
    unittest.main()
