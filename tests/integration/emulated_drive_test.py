"""mwidthd and mwidth-drive as processes of their own: rendering, and every fault of the link on demand."""

import contextlib
import signal
import subprocess
import tempfile
import time
import unittest

from modbus_example import write_config
from server_process import BUILD, ServerProcess, rendering, seconds

from mwidth.v1 import telemetry_pb2 as telemetry

SILENT, JUMP = rendering.FAULT_KIND_DRIVE_SILENT, rendering.FAULT_KIND_ENCODER_JUMP


class Emulator:
    """A running mwidth-drive on a free port."""

    def __init__(self, *arguments):
        self.process = subprocess.Popen([BUILD / "bin" / "mwidth-drive", *map(str, arguments)], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.port = int(self.process.stdout.readline().rsplit(":", 1)[1])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        self.process.stdin.close()
        self.process.stdout.close()

    def say(self, command):
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()
        return self.process.stdout.readline().strip()


class EmulatedDriveTest(unittest.TestCase):
    def setUp(self):
        self.stack = contextlib.ExitStack()
        self.addCleanup(self.stack.close)
        self.folder = self.stack.enter_context(tempfile.TemporaryDirectory())

    def serve(self, drive):
        return ServerProcess("--config", write_config(self.folder, drive.port), "--allow-non-realtime")

    def rendering(self, drive):
        server = self.stack.enter_context(self.serve(drive))
        lease = server.acquire()
        server.start(lease)
        server.set_mass(lease, 0.05, ramp=seconds(0))
        return server

    def samples_to_the_fault(self, server, act):
        """Acts once samples come, and returns all samples until one is in FAULT with zero force."""
        joined = telemetry.SampleBatch()
        stream = server.telemetry.StreamSamples(telemetry.StreamSamplesRequest(max_batch=10))
        deadline = time.monotonic() + 60
        for response in stream:
            if act:
                act()
                act = None
            joined.MergeFrom(response.batch)
            if joined.state[-1] == rendering.STATE_FAULT and joined.force_counts[-1] == 0:
                stream.cancel()
                return joined
            self.assertLess(time.monotonic(), deadline, "no fault came")
        raise AssertionError("the stream ended")

    def test_each_fault_of_the_drive_is_told_and_ends_the_force(self):
        for command, kinds in [("silence", [SILENT]), ("exceptions", [SILENT]), ("delay 0.02", [SILENT]),
                               ("dribble 0.01", [SILENT]), ("jump 1000000", [JUMP]),
                               ("wrong-order", [JUMP, rendering.FAULT_KIND_POSITION_LIMIT])]:
            with self.subTest(command):
                drive = self.stack.enter_context(Emulator())
                server = self.rendering(drive)
                samples = self.samples_to_the_fault(server, lambda: self.assertEqual(drive.say(command), "ok"))
                self.assertIn(server.state().fault.kind, kinds)
                if kinds == [SILENT]:
                    # From the first tick without an answer: two on the last estimate, zero by the fifth.
                    first = list(samples.position_stale).index(True)
                    self.assertFalse(any(list(samples.force_counts)[first + 4:]))

    def test_a_killed_server_leaves_the_drive_to_its_watchdog(self):
        drive = self.stack.enter_context(Emulator())
        server = self.serve(drive)
        lease = server.acquire()
        server.start(lease)
        server.set_mass(lease, 0.05, ramp=seconds(0))
        server.kill()
        self.assertIn("watchdog", drive.process.stdout.readline())

    def test_a_drive_that_comes_back_can_be_used_again(self):
        drive = self.stack.enter_context(Emulator())
        server = self.stack.enter_context(self.serve(drive))
        lease = server.acquire(ttl_s=60)
        server.start(lease)
        drive.say("silence")
        deadline = time.monotonic() + 30
        while server.state().state != rendering.STATE_FAULT:
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.01)
        drive.say("well")
        server.rendering.ClearFault(rendering.ClearFaultRequest(lease_id=lease))
        server.start(lease)
        self.assertEqual(server.state().state, rendering.STATE_RENDERING)

    def test_without_a_watchdog_the_drive_is_not_armed(self):
        drive = self.stack.enter_context(Emulator("--watchdog", 0))
        server = self.stack.enter_context(self.serve(drive))
        with self.assertRaisesRegex(Exception, "watchdog"):
            server.start(server.acquire())
        self.assertEqual(server.state().fault.kind, rendering.FAULT_KIND_NO_DRIVE_WATCHDOG)

    def test_commands_that_mean_nothing_are_told(self):
        drive = self.stack.enter_context(Emulator())
        self.assertRegex(drive.say("dance"), "not understood")

    def test_wrong_usage_is_explained(self):
        for arguments, words in [(["--config", "paper"], "simulated drive already"), (["--axis", "knee"], "knee"),
                                 (["--watchdog", "-1"], "--watchdog")]:
            result = subprocess.run([BUILD / "bin" / "mwidth-drive", *arguments], capture_output=True, text=True, timeout=60,
                                    stdin=subprocess.DEVNULL)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(words, result.stderr)

    def test_it_ends_on_a_signal(self):
        drive = self.stack.enter_context(Emulator())
        drive.process.send_signal(signal.SIGTERM)
        self.assertEqual(drive.process.wait(timeout=30), 0)


if __name__ == "__main__":
    unittest.main()
