"""mwidthd renders on a CiA 402 drive that python-can plays, on the bus behind mwidth-drive's gateway."""

import contextlib
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import can
from canopen_example import write_config
from emulator_process import Emulator
from mass_rendering import fault_of, render, undisturbed_samples
from server_process import BUILD, ServerProcess, grpc, rendering

HERE = pathlib.Path(__file__).resolve().parent
# mwidth-drive's own drive is node 1 of the same bus.
NODE = 2


class Drive:
    """The drive's process, and the gateway that it and the server join."""

    def __init__(self, folder, *objects):
        self.folder = folder
        self.gateway = Emulator("--config", write_config(folder, 29536), "--port", "0")
        self.process = subprocess.Popen(
            [sys.executable, HERE / "python_can_node.py", str(self.gateway.port), str(NODE), *objects],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.expect("serving")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        self.process.stdin.close()
        self.process.stdout.close()
        self.gateway.__exit__()

    def expect(self, *words):
        for word in words:
            line = self.process.stdout.readline().strip()
            if line != word:
                raise AssertionError(f"the drive said '{line}' instead of '{word}'")

    def report(self, code):
        self.process.stdin.write(f"{code:x}\n")
        self.process.stdin.flush()

    def config(self, *replacements):
        return write_config(self.folder, self.gateway.port, ("\nnode = 1", f"\nnode = {NODE}"), *replacements)

    def other_master(self):
        return can.Bus(interface="socketcand", channel="can0", host="127.0.0.1", port=self.gateway.port)


class PythonCanTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.stack = contextlib.ExitStack()
        self.addCleanup(self.stack.close)

    def drive(self, *objects):
        return self.stack.enter_context(Drive(self.folder, *objects))

    def server(self, drive, *replacements):
        return self.stack.enter_context(ServerProcess("--config", drive.config(*replacements), "--allow-non-realtime"))

    def assert_renders_again(self, server, lease):
        server.rendering.ClearFault(rendering.ClearFaultRequest(lease_id=lease))
        render(server, lease)
        self.assertEqual(server.state().state, rendering.STATE_RENDERING)

    def assert_not_armed(self, server, kind, words):
        """Returns the lease that it was asked for with."""
        lease = server.acquire(ttl_s=60)
        with self.assertRaises(grpc.RpcError) as caught:
            server.start(lease)
        self.assertEqual(caught.exception.code(), grpc.StatusCode.FAILED_PRECONDITION)
        self.assertRegex(caught.exception.details(), words)
        self.assertEqual(server.state().fault.kind, kind)
        return lease

    def test_forces_follow_positions_on_either_exchange(self):
        for exchange in ('"on-receipt"', '"on-sync"'):
            with self.subTest(exchange), contextlib.ExitStack() as self.stack:
                drive = self.drive()
                server = self.server(drive, ('exchange = "on-receipt"', f"exchange = {exchange}"))
                samples = undisturbed_samples(server, 300)
                drive.expect("ready", "switched on", "enabled")
                self.assertGreater(max(samples.position) - min(samples.position), 0.2)
                self.assertGreater(max(abs(force) for force in samples.force), 0.05)
                for acceleration, mass, force in zip(samples.acceleration, samples.mass, samples.force):
                    self.assertAlmostEqual(force, mass * acceleration, delta=0.0063)

    def test_stopping_lets_go_of_the_motor(self):
        drive = self.drive()
        with ServerProcess("--config", drive.config(), "--allow-non-realtime") as server:
            render(server)
        drive.expect("ready", "switched on", "enabled", "disabled")

    def test_a_server_that_dies_leaves_the_drive_to_its_watchdog(self):
        drive = self.drive()
        server = ServerProcess("--config", drive.config(), "--allow-non-realtime")
        render(server)
        server.kill()
        drive.expect("ready", "switched on", "enabled", "fault")

    def test_an_emergency_is_a_fault_with_its_code_that_the_next_start_resets(self):
        drive = self.drive()
        server = self.server(drive)
        lease = render(server)
        drive.report(0x2310)
        fault = fault_of(server)
        self.assertEqual(fault.kind, rendering.FAULT_KIND_DRIVE_ERROR)
        self.assertEqual(fault.value, 0x2310)
        self.assertRegex(fault.message, "code 2310h")
        self.assert_renders_again(server, lease)
        drive.expect("ready", "switched on", "enabled", "fault", "disabled", "ready", "switched on", "enabled")

    def test_a_drive_that_hangs_is_a_latched_fault_and_comes_back(self):
        drive = self.drive()
        server = self.server(drive)
        lease = render(server)
        drive.process.send_signal(signal.SIGSTOP)
        self.assertEqual(fault_of(server).kind, rendering.FAULT_KIND_DRIVE_SILENT)
        drive.process.send_signal(signal.SIGCONT)
        # It is set up anew, and asked until it answers.
        self.assert_renders_again(server, lease)

    def test_another_master_keeps_the_drive_from_being_armed_and_ends_what_is_rendered(self):
        drive = self.drive()
        server = self.server(drive)
        sync = can.Message(arbitration_id=0x080, is_extended_id=False)
        with drive.other_master() as other:
            other.send(sync)
            time.sleep(0.1)
            lease = self.assert_not_armed(server, rendering.FAULT_KIND_FOREIGN_TRAFFIC, "Disconnect the other master")
            time.sleep(2)  # So long it is remembered.
            self.assert_renders_again(server, lease)
            other.send(sync)
            fault = fault_of(server)
            self.assertEqual(fault.kind, rendering.FAULT_KIND_FOREIGN_TRAFFIC)
            self.assertEqual(fault.value, 0x80)

    def test_without_a_reaction_to_silence_it_is_not_armed(self):
        drive = self.drive("6007=")
        server = self.server(drive)
        self.assert_not_armed(server, rendering.FAULT_KIND_NO_DRIVE_WATCHDOG, "watchdog")

    def test_a_drive_that_is_another_one_is_named(self):
        drive = self.drive("6076=3e8")
        result = subprocess.run([BUILD / "bin" / "mwidthd", "--config", drive.config()], capture_output=True, text=True,
                                timeout=60)
        self.assertEqual(result.returncode, 1)
        self.assertRegex(result.stderr, r"node 2 on can0 of 127\.0\.0\.1:\d+: .*6076h.* is 1, .* says 0\.25")


if __name__ == "__main__":
    unittest.main()
