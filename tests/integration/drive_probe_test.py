"""mwidth drive probe: what a person sees of a drive before it is armed."""

import contextlib
import json
import subprocess
import tempfile
import unittest

from emulated_drive_test import Emulator
from modbus_example import write_config
from modbus_test import Drive as PymodbusDrive
from server_process import BUILD, ServerProcess


def probe(*arguments):
    return subprocess.run([BUILD / "bin" / "mwidth", *map(str, arguments)], capture_output=True, text=True, timeout=60)


class DriveProbeTest(unittest.TestCase):
    def setUp(self):
        self.stack = contextlib.ExitStack()
        self.addCleanup(self.stack.close)

    def answer(self, port, code, config="modbus"):
        result = probe("--json", "drive", "probe", "--config", config, "--drive", f"127.0.0.1:{port}")
        self.assertEqual(result.returncode, code, result.stderr)
        answer = json.loads(result.stdout)
        self.assertEqual(answer["ready"], code == 0)
        return {finding["subject"]: finding for finding in answer["findings"]}

    def test_a_drive_tells_its_state_position_force_and_watchdog(self):
        drive = self.stack.enter_context(Emulator("--watchdog", 0.03))
        found = self.answer(drive.port, 0)
        self.assertRegex(found["state"]["seen"], "^disabled")
        self.assertRegex(found["position"]["seen"], r"^-?[0-9.e-]+ rad \(-?\d+ in the register\)$")
        self.assertRegex(found["force"]["seen"], "^0 N m ")
        self.assertRegex(found["watchdog"]["seen"], "^after 0.03 s, with a reaction")
        text = probe("drive", "probe", "--config", "modbus", "--drive", f"127.0.0.1:{drive.port}").stdout
        self.assertIn("It can be armed.", text)

    def test_a_drive_on_canopen_tells_its_state_position_torque_and_watchdog(self):
        drive = self.stack.enter_context(Emulator("--config", "canopen", "--port", "0"))
        found = self.answer(drive.port, 0, "canopen")
        self.assertEqual(found["state"]["seen"], "switch on disabled")
        self.assertRegex(found["position"]["seen"], r"^-?[0-9.e-]+ rad \(-?\d+ in 6064h\)$")
        self.assertEqual(found["rated torque"]["seen"], "0.25 N m (250 in 6076h)")
        self.assertRegex(found["watchdog"]["seen"], "1016h.*6007h")

    def test_a_drive_that_others_wrote_is_read_as_well(self):
        drive = self.stack.enter_context(PymodbusDrive())
        self.assertRegex(self.answer(drive.port, 0)["position"]["seen"], " rad ")

    def test_a_weak_watchdog_is_told_with_what_to_do(self):
        drive = self.stack.enter_context(Emulator("--watchdog", 0.5))
        watchdog = self.answer(drive.port, 1)["watchdog"]
        self.assertRegex(watchdog["seen"], "^after 0.5 s")
        self.assertIn("at most 0.1 s", watchdog["advice"])

    def test_a_drive_that_answers_exceptions_is_told_register_by_register(self):
        drive = self.stack.enter_context(Emulator())
        self.assertEqual(drive.say("exceptions"), "ok")
        found = self.answer(drive.port, 1)
        self.assertRegex(found["position"]["seen"], "exception at register 100")
        self.assertIn("axis.drive.position", found["position"]["advice"])

    def test_a_drive_in_use_is_left_alone(self):
        drive = self.stack.enter_context(Emulator())
        config = write_config(self.stack.enter_context(tempfile.TemporaryDirectory()), drive.port)
        self.stack.enter_context(ServerProcess("--config", config, "--allow-non-realtime"))
        result = probe("drive", "probe", "--config", config)
        self.assertEqual(result.returncode, 3)
        self.assertIn("held by another server", result.stderr)

    def test_what_is_no_drive_is_explained(self):
        for arguments, words in [(["--config", "elbow"], "simulated drive"), (["--config", "nowhere"], "nowhere"),
                                 (["--config", "modbus", "--drive", "can0"], "HOST:PORT"),
                                 (["--config", "modbus", "--drive", "127.0.0.1:1"], "Connection refused")]:
            result = probe("drive", "probe", *arguments)
            self.assertEqual(result.returncode, 3, arguments)
            self.assertIn(words, result.stderr)


if __name__ == "__main__":
    unittest.main()
