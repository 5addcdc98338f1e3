"""Starting, ending and misusing the server as a person would."""

import os
import pathlib
import signal
import subprocess
import tempfile
import unittest

from server_process import BUILD, ServerProcess, grpc, rendering, seconds

MWIDTHD = BUILD / "bin" / "mwidthd"


def run(*arguments):
    return subprocess.run([MWIDTHD, *arguments], capture_output=True, text=True, timeout=60)


class LifecycleTest(unittest.TestCase):
    def assert_usage_error(self, result, *words):
        self.assertEqual(result.returncode, 2, result.stderr)
        for word in words:
            self.assertIn(word, result.stderr)

    def test_the_default_is_the_paper_loop(self):
        with ServerProcess() as server:
            self.assertEqual(server.state().info.name, "paper")

    def test_a_rendering_server_ends_cleanly_on_a_signal(self):
        for number in (signal.SIGTERM, signal.SIGINT):
            with ServerProcess("--config", "elbow") as server:
                lease = server.acquire()
                server.start(lease)
                server.set_mass(lease, 0.05, ramp=seconds(0))
                server.process.send_signal(number)
                self.assertEqual(server.process.wait(timeout=30), 0)

    def test_open_streams_do_not_hold_up_the_end(self):
        from mwidth.v1 import telemetry_pb2 as telemetry
        with ServerProcess() as server:
            stream = server.telemetry.StreamSamples(telemetry.StreamSamplesRequest())
            next(stream)
            server.process.terminate()
            self.assertEqual(server.process.wait(timeout=30), 0)
            with self.assertRaises(grpc.RpcError):
                while True:
                    next(stream)

    def test_a_second_server_on_the_same_address_is_refused(self):
        with ServerProcess() as server:
            result = run("--listen", server.address)
            self.assertEqual(result.returncode, 1)
            self.assertIn(server.address, result.stderr)

    def test_it_starts_without_rendering(self):
        with ServerProcess() as server:
            self.assertIn(server.state().state, (rendering.STATE_IDLE, rendering.STATE_READY))

    def test_it_keeps_cpus_awake_only_where_it_is_asked_to(self):
        text = (pathlib.Path(__file__).parents[2] / "deploy/config/paper.toml").read_text()
        off, on = "keep_cpus_awake = false", "keep_cpus_awake = true"
        self.assertIn(off, text)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "host.toml"
            for written, spinners in ((off, 0), (on, len(os.sched_getaffinity(0)))):
                file.write_text(text.replace(off, written))
                with ServerProcess("--config", file) as server:
                    threads = map(int, os.listdir(f"/proc/{server.process.pid}/task"))
                    idle = [thread for thread in threads if os.sched_getscheduler(thread) == os.SCHED_IDLE]
                    self.assertEqual(len(idle), spinners)
                    self.assertEqual({len(os.sched_getaffinity(thread)) for thread in idle}, {1} if idle else set())

    def test_wrong_usage_is_explained(self):
        self.assert_usage_error(run("--config", "no-such"), "no-such", "paper", "elbow")
        self.assert_usage_error(run("--no-such-flag"), "--no-such-flag")
        self.assert_usage_error(run("--listen", "nonsense"), "nonsense", "HOST:PORT")
        self.assert_usage_error(run("--listen", "127.0.0.1:99999"), "99999")
        self.assert_usage_error(run("--simulation-speed", "-1"), "simulation-speed")
        self.assert_usage_error(run("--hand-motion", "/no/such.csv"), "/no/such.csv")

    def test_a_wrong_configuration_names_file_line_key_and_range(self):
        text = (pathlib.Path(__file__).parents[2] / "deploy/config/paper.toml").read_text()
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "wrong.toml"
            file.write_text(text.replace("cutoff_hz = 10.0", "cutoff_hz = 5000"))
            line = 1 + text[:text.index("cutoff_hz = 10.0")].count("\n")
            self.assert_usage_error(run("--config", str(file)), f"{file}:{line}", "cutoff_hz", "500")

    def test_a_wrong_recording_names_file_and_line(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "wrong.csv"
            file.write_text("time_s,angle_rad\n0.00,0.1\n0.01,soon\n0.02,0.1\n")
            self.assert_usage_error(run("--config", "elbow", "--hand-motion", str(file)), f"{file}:3", "soon")
            file.write_text("time_s,angle_m\n0.00,0.1\n0.01,0.1\n0.02,0.1\n")
            self.assert_usage_error(run("--config", "elbow", "--hand-motion", str(file)), "_rad")


if __name__ == "__main__":
    unittest.main()
