"""mwidthd and mwidth-drive as processes of their own: rendering, and every fault on demand, on every link."""

import contextlib
import os
import signal
import subprocess
import tempfile
import time
import unittest

import canopen_example
from emulator_process import Emulator
from mass_rendering import fault_of, render, samples_until, undisturbed_samples
from modbus_example import write_config, write_rtu_config
from server_process import BUILD, ServerProcess, grpc, rendering

SILENT, JUMP = rendering.FAULT_KIND_DRIVE_SILENT, rendering.FAULT_KIND_ENCODER_JUMP
OUTSIDE, ERROR = rendering.FAULT_KIND_POSITION_LIMIT, rendering.FAULT_KIND_DRIVE_ERROR


class ModbusTcp:
    """How a drive is started on a link, and what configuration leads the server to it."""

    force_quantum = 0.001
    watchdog_ms = 50
    faults = [("silence", [SILENT]), ("exceptions", [SILENT]), ("delay 0.02", [SILENT]), ("dribble 0.01", [SILENT]),
              ("jump 1000000", [JUMP]), ("wrong-order", [JUMP, OUTSIDE])]

    @staticmethod
    def start(_folder, *arguments):
        return Emulator(*arguments)

    @staticmethod
    def config(folder, drive):
        return write_config(folder, drive.port)


class ModbusRtu(ModbusTcp):
    faults = [(command.replace("delay 0.02", "delay 0.05"), kinds) for command, kinds in ModbusTcp.faults]

    @staticmethod
    def start(folder, *arguments):
        return Emulator("--config", write_rtu_config(folder, "any"), "--pty", *arguments)

    @staticmethod
    def config(folder, drive):
        return write_rtu_config(folder, drive.place)


class Canopen:
    force_quantum = 0.0125
    watchdog_ms = 100
    faults = [("silence", [SILENT]), ("delay 0.02", [SILENT]), ("dribble 0.01", [SILENT]), ("heartbeat-loss", [SILENT]),
              ("jump 1000000", [JUMP]), ("wrong-order", [JUMP, OUTSIDE]), ("emcy 2310", [ERROR])]

    @staticmethod
    def start(folder, *arguments):
        return Emulator("--config", canopen_example.write_config(folder, 1), *arguments)

    @staticmethod
    def config(folder, drive):
        return canopen_example.write_config(folder, drive.port)


class CanopenOnSync(Canopen):
    @staticmethod
    def config(folder, drive):
        return canopen_example.write_config(folder, drive.port, ('exchange = "on-receipt"', 'exchange = "on-sync"'))


LINKS = [ModbusTcp, ModbusRtu, Canopen, CanopenOnSync]


def on_every_link(test):
    """Runs a test once a link, with what it started ended in between."""
    def run(self):
        for link in LINKS:
            with self.subTest(link.__name__), contextlib.ExitStack() as stack, tempfile.TemporaryDirectory() as folder:
                self.link, self.stack, self.folder = link, stack, folder
                test(self)
    return run


class EmulatedDriveTest(unittest.TestCase):
    def start_drive(self, *arguments):
        return self.stack.enter_context(self.link.start(self.folder, *arguments))

    def serve(self, drive):
        return ServerProcess("--config", self.link.config(self.folder, drive), "--allow-non-realtime")

    def samples_to_the_fault(self, server, act, moving=0.0):
        """Renders, acts once a force flows and the joint moves, and returns all samples until FAULT with zero force."""
        lease, acted = render(server), []

        def enough(joined):
            faulty = joined.state[-1] == rendering.STATE_FAULT
            if not acted and not faulty and joined.force_counts[-1] != 0 and abs(joined.velocity[-1]) >= moving:
                acted.append(act())
            return faulty and joined.force_counts[-1] == 0

        samples = samples_until(server, enough)
        while not acted:
            render(server, lease)
            samples = samples_until(server, enough)
        return samples

    @staticmethod
    def first_wrong_tick(samples):
        """The first of those without an answer, or with a position that cannot be, which led to FAULT."""
        positions = list(samples.position)
        first = list(samples.state).index(rendering.STATE_FAULT)
        while samples.position_stale[first - 1] or abs(positions[first - 1] - positions[first - 2]) > 0.5:
            first -= 1
        return first

    def check_force_ends_by_the_fifth_tick(self, samples, first):
        """From tick `first` on, which is wrong: two on the last estimate, zero by the fifth."""
        self.assertTrue(any(list(samples.force_counts)[:first + 1]), "there was a force")
        self.assertFalse(any(list(samples.force_counts)[first + 4:]))

    def await_let_go(self, drive):
        """Until the drive itself says that its motor is off: told so, or by its watchdog where it does not obey."""
        deadline = time.monotonic() + 20
        line = drive.say("state")
        while not line.startswith("disabled, force 0 counts"):
            self.assertLess(time.monotonic(), deadline, line)
            time.sleep(0.02)
            # The watchdog's own line may come between.
            line = drive.line() if line.startswith("watchdog") else drive.say("state")

    @on_every_link
    def test_a_mass_is_rendered(self):
        server = self.stack.enter_context(self.serve(self.start_drive()))
        samples = undisturbed_samples(server, 150)
        self.assertGreater(max(samples.position) - min(samples.position), 0.2)
        self.assertGreater(max(abs(force) for force in samples.force), 0.02)
        for acceleration, mass, force in zip(samples.acceleration, samples.mass, samples.force):
            self.assertAlmostEqual(force, mass * acceleration, delta=0.6 * self.link.force_quantum)

    @on_every_link
    def test_each_fault_of_the_drive_is_told_and_ends_the_force(self):
        for command, kinds in self.link.faults:
            with self.subTest(command), contextlib.ExitStack() as stack:
                drive = stack.enter_context(self.link.start(self.folder))
                server = stack.enter_context(self.serve(drive))
                samples = self.samples_to_the_fault(server, lambda: self.assertEqual(drive.say(command), "ok"))
                self.assertIn(server.state().fault.kind, kinds)
                self.check_force_ends_by_the_fifth_tick(samples, self.first_wrong_tick(samples))
                self.await_let_go(drive)

    @on_every_link
    def test_an_encoder_that_freezes_in_motion_is_told(self):
        drive = self.start_drive()
        server = self.stack.enter_context(self.serve(drive))
        samples = self.samples_to_the_fault(server, lambda: self.assertEqual(drive.say("freeze"), "ok"), moving=0.4)
        self.assertEqual(server.state().fault.kind, rendering.FAULT_KIND_ENCODER_FREEZE)
        self.check_force_ends_by_the_fifth_tick(samples, list(samples.state).index(rendering.STATE_FAULT))
        self.await_let_go(drive)

    @on_every_link
    def test_a_killed_server_leaves_the_drive_to_its_watchdog(self):
        drive = self.start_drive()
        server = self.serve(drive)
        render(server)
        samples_until(server, lambda joined: any(joined.force_counts))
        self.assertRegex(drive.say("state"), "^enabled")
        server.kill()
        # The drive's own clock: it lets go on the time-out, however late this process looks.
        self.assertRegex(drive.line(), f"watchdog: the motor is disabled {self.link.watchdog_ms} ms after")
        self.assertEqual(drive.say("state"), "disabled, force 0 counts, watchdog fired 1 times")

    @on_every_link
    def test_a_drive_that_comes_back_can_be_used_again(self):
        drive = self.start_drive()
        server = self.stack.enter_context(self.serve(drive))
        lease = render(server)
        drive.say("silence")
        fault_of(server)
        drive.say("well")
        render(server, lease)
        self.assertEqual(server.state().state, rendering.STATE_RENDERING)

    @on_every_link
    def test_without_a_watchdog_the_drive_is_not_armed(self):
        server = self.stack.enter_context(self.serve(self.start_drive("--watchdog", 0)))
        with self.assertRaisesRegex(Exception, "watchdog"):
            server.start(server.acquire())
        self.assertEqual(server.state().fault.kind, rendering.FAULT_KIND_NO_DRIVE_WATCHDOG)


class CanopenDriveTest(unittest.TestCase):
    """What there is on CAN alone."""

    def setUp(self):
        self.stack = contextlib.ExitStack()
        self.addCleanup(self.stack.close)
        self.folder = self.stack.enter_context(tempfile.TemporaryDirectory())
        self.drive = self.stack.enter_context(Canopen.start(self.folder))

    def serve(self, *replacements):
        config = canopen_example.write_config(self.folder, self.drive.port, *replacements)
        return self.stack.enter_context(ServerProcess("--config", config, "--allow-non-realtime"))

    def test_a_drive_that_aborts_every_transfer_is_not_armed(self):
        server = self.serve()
        self.assertEqual(self.drive.say("abort"), "ok")
        with self.assertRaises(grpc.RpcError):
            server.start(server.acquire())
        # The first thing that it does not tell.
        self.assertEqual(server.state().fault.kind, rendering.FAULT_KIND_NO_DRIVE_WATCHDOG)
        self.assertRegex(self.drive.say("state"), "^disabled")

    def test_each_reaction_to_a_lost_connection_takes_the_force_away(self):
        for reaction in ("fault", "disable-voltage", "quick-stop"):
            with self.subTest(reaction), contextlib.ExitStack() as stack:
                drive = stack.enter_context(Canopen.start(self.folder))
                config = canopen_example.write_config(self.folder, drive.port, ('"disable-voltage"\n', f'"{reaction}"\n'))
                server = ServerProcess("--config", config, "--allow-non-realtime")
                render(server)
                server.kill()
                self.assertIn("100 ms", drive.line())
                self.assertEqual(drive.say("state"), "disabled, force 0 counts, watchdog fired 1 times")

    def test_an_error_of_the_drive_is_told_with_its_number(self):
        server = self.serve()
        render(server)
        self.drive.say("emcy 2310")
        self.assertEqual(fault_of(server).value, 0x2310)


class CommandLineTest(unittest.TestCase):
    def test_commands_that_mean_nothing_are_told(self):
        with Emulator() as drive:
            self.assertRegex(drive.say("dance"), "not understood")

    def test_wrong_usage_is_explained(self):
        for arguments, words in [(["--config", "paper"], "simulated drive already"), (["--axis", "knee"], "knee"),
                                 (["--watchdog", "-1"], "--watchdog"), (["--config", "canopen", "--pty"], "Modbus"),
                                 (["--config", "canopen", "--device", "/dev/ttyS0"], "Modbus")]:
            with self.subTest(arguments):
                result = subprocess.run([BUILD / "bin" / "mwidth-drive", *arguments], capture_output=True, text=True,
                                        timeout=60, stdin=subprocess.DEVNULL)
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertIn(words, result.stderr)

    def test_a_serial_port_can_be_given(self):
        master, end = os.openpty()
        with tempfile.TemporaryDirectory() as folder:
            config = write_rtu_config(folder, "any")
            with Emulator("--config", config, "--device", os.ttyname(end)) as drive:
                self.assertEqual(drive.place, os.ttyname(end))
                # The position of unit 1, asked for with a checksum that is wrong, and then with the right one.
                os.write(master, bytes([1, 3, 0, 100, 0, 2, 0, 0]))
                time.sleep(0.1)
                os.write(master, bytes([1, 3, 0, 100, 0, 2, 0x85, 0xD4]))
                self.assertEqual(os.read(master, 100)[:3], bytes([1, 3, 4]))
        os.close(master)
        os.close(end)

    def test_a_host_without_can_is_told_so(self):
        result = subprocess.run([BUILD / "bin" / "mwidth-drive", "--config", "canopen"], capture_output=True, text=True,
                                timeout=60, stdin=subprocess.DEVNULL)
        self.assertEqual(result.returncode, 1, "this host has an interface called can0")
        self.assertIn("SocketCAN", result.stderr)

    def test_it_ends_on_a_signal(self):
        with Emulator() as drive:
            drive.process.send_signal(signal.SIGTERM)
            self.assertEqual(drive.process.wait(timeout=30), 0)


if __name__ == "__main__":
    unittest.main()
