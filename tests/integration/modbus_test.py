"""mwidthd renders on a drive that pymodbus plays."""

import contextlib
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

from modbus_example import write_config
from pymodbus.client import ModbusTcpClient
from server_process import BUILD, ServerProcess, grpc, rendering, seconds

from mwidth.v1 import telemetry_pb2 as telemetry

HERE = pathlib.Path(__file__).resolve().parent
FORCE, ENABLE = 200, 300


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Drive:
    """The drive's process."""

    def __init__(self, *settings):
        self.port = free_port()
        self.process = subprocess.Popen([sys.executable, HERE / "pymodbus_drive.py", str(self.port), *map(str, settings)],
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.expect("serving")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()

    def expect(self, word):
        line = self.process.stdout.readline().strip()
        if line != word:
            raise AssertionError(f"the drive said '{line}' instead of '{word}'")

    def register(self, address):
        with contextlib.closing(ModbusTcpClient("127.0.0.1", port=self.port)) as client:
            client.connect()
            return client.read_holding_registers(address, 1, slave=1).registers[0]


class ModbusTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def config(self, drive, *replacements):
        return write_config(self.folder.name, drive.port, *replacements)

    def serve(self, drive, *replacements):
        return ServerProcess("--config", self.config(drive, *replacements), "--allow-non-realtime")

    def rendering_server(self, stack, drive, *replacements):
        """A server that renders 0.05 kg m^2 on the drive, and its lease."""
        server = stack.enter_context(self.serve(drive, *replacements))
        lease = server.acquire()
        server.start(lease)
        server.set_mass(lease, 0.05, ramp=seconds(0))
        return server

    def wait_for_state(self, server, state):
        deadline = time.monotonic() + 30
        while server.state().state != state:
            self.assertLess(time.monotonic(), deadline, server.state())
            time.sleep(0.01)
        return server.state()

    def test_forces_follow_positions_on_either_exchange(self):
        for exchange in ('"two-requests"', '"read-write"'):
            with self.subTest(exchange), contextlib.ExitStack() as stack:
                drive = stack.enter_context(Drive())
                server = self.rendering_server(stack, drive, ('exchange = "two-requests"', f"exchange = {exchange}"))
                samples = self.samples(server, 300)
                self.assertGreater(max(samples.position) - min(samples.position), 0.2)
                self.assertGreater(max(abs(force) for force in samples.force), 0.05)
                for acceleration, mass, force in zip(samples.acceleration, samples.mass, samples.force):
                    self.assertAlmostEqual(force, mass * acceleration, delta=0.0006)
                self.assertEqual(drive.register(ENABLE), 1)
                self.assertEqual(server.state().state, rendering.STATE_RENDERING)

    def samples(self, server, count):
        stream = server.telemetry.StreamSamples(telemetry.StreamSamplesRequest())
        joined = telemetry.SampleBatch()
        for response in stream:
            joined.MergeFrom(response.batch)
            if len(joined.position) >= count:
                stream.cancel()
                return joined
        raise AssertionError("the stream ended")

    def test_a_drive_that_dies_or_hangs_is_a_latched_fault(self):
        for number in (signal.SIGKILL, signal.SIGSTOP):
            with self.subTest(number), contextlib.ExitStack() as stack:
                drive = stack.enter_context(Drive())
                server = self.rendering_server(stack, drive)
                drive.process.send_signal(number)
                state = self.wait_for_state(server, rendering.STATE_FAULT)
                self.assertEqual(state.fault.kind, rendering.FAULT_KIND_DRIVE_SILENT)

    def test_a_server_that_dies_leaves_the_drive_to_its_watchdog(self):
        with contextlib.ExitStack() as stack:
            drive = stack.enter_context(Drive())
            server = self.serve(drive)
            lease = server.acquire()
            server.start(lease)
            server.set_mass(lease, 0.05, ramp=seconds(0))
            server.kill()
            drive.expect("watchdog")
            self.assertEqual(drive.register(FORCE), 0)

    def test_stopping_takes_the_force_and_the_motor_away(self):
        with contextlib.ExitStack() as stack:
            drive = stack.enter_context(Drive())
            with self.serve(drive) as server:
                lease = server.acquire()
                server.start(lease)
                server.set_mass(lease, 0.05, ramp=seconds(0))
            self.assertEqual(drive.register(FORCE), 0)
            self.assertEqual(drive.register(ENABLE), 0)

    def test_without_a_watchdog_that_reacts_it_is_not_armed(self):
        for settings in ((101, 1), (50, 0)):
            with self.subTest(settings), contextlib.ExitStack() as stack:
                drive = stack.enter_context(Drive(*settings))
                server = stack.enter_context(self.serve(drive))
                with self.assertRaises(grpc.RpcError) as caught:
                    server.start(server.acquire())
                self.assertEqual(caught.exception.code(), grpc.StatusCode.FAILED_PRECONDITION)
                self.assertRegex(caught.exception.details(), "watchdog")
                self.assertEqual(server.state().fault.kind, rendering.FAULT_KIND_NO_DRIVE_WATCHDOG)
                self.assertEqual(drive.register(ENABLE), 0)

    def test_a_drive_has_one_server(self):
        with contextlib.ExitStack() as stack:
            drive = stack.enter_context(Drive())
            path = self.config(drive)
            stack.enter_context(ServerProcess("--config", path, "--allow-non-realtime"))
            second = subprocess.run([BUILD / "bin" / "mwidthd", "--config", path, "--listen", "127.0.0.1:0"],
                                    capture_output=True, text=True, timeout=60)
            self.assertEqual(second.returncode, 1)
            self.assertIn(str(drive.port), second.stderr)

    def test_a_drive_that_is_not_there_is_named(self):
        with Drive() as drive:
            path = self.config(drive)
        result = subprocess.run([BUILD / "bin" / "mwidthd", "--config", path], capture_output=True, text=True, timeout=60)
        self.assertEqual(result.returncode, 1)
        self.assertRegex(result.stderr, re.compile(r"127\.0\.0\.1:\d+.*check that the drive is on"))


if __name__ == "__main__":
    unittest.main()
