"""What the server and the drive do on a CAN bus of the kernel's when something fails."""

import csv
import math
import pathlib
import tempfile
import unittest

import sessions
import virtual_machine
from session_test import PROGRAMS

# What fails, while a force acts: a shell command, and the faults that may be told. A drive that lives says afterwards
# whether its motor is off.
FAULTS = {
    "silence": ("echo silence >&3", {"FAULT_KIND_DRIVE_SILENT"}),
    "delay": ("echo delay 0.02 >&3", {"FAULT_KIND_DRIVE_SILENT"}),
    "heartbeat-loss": ("echo heartbeat-loss >&3", {"FAULT_KIND_DRIVE_SILENT"}),
    "freeze": ("echo freeze >&3", {"FAULT_KIND_ENCODER_FREEZE"}),
    "wrong-order": ("echo wrong-order >&3", {"FAULT_KIND_ENCODER_JUMP", "FAULT_KIND_POSITION_LIMIT"}),
    "emcy": ("echo emcy 4310 >&3", {"FAULT_KIND_DRIVE_ERROR"}),
    "jump": ("echo jump 100000 >&3", {"FAULT_KIND_ENCODER_JUMP"}),
    "dead-drive": ("kill -9 $drive", {"FAULT_KIND_DRIVE_SILENT"}),
    "bus-down": ("/programs/ip link set can0 down", {"FAULT_KIND_DRIVE_SILENT"}),
}

BEGIN = """
echo "== {name}"
/programs/ip link set can0 up
mkfifo /tmp/commands
mwidth-drive --config drive.toml --hand-motion hand.csv </tmp/commands >{name}-drive.log 2>&1 & drive=$!
exec 3>/tmp/commands
await 'listening on' {name}-drive.log
mwidthd --config drive.toml --drive can0 --listen 127.0.0.1:50051 >{name}-server.log 2>&1 & server=$!
await 'listening on' {name}-server.log
mwidth set-mass 0.1 --hold 30 >{name}.log 2>&1 & setting=$!
await Rendering {name}.log
"""

FAULT = """
mwidth stream --csv {name}.csv --seconds 1.5 >{name}-stream.log 2>&1 & stream=$!
sleep 0.5
{act}
wait $stream || fail "no samples"
mwidth state --json >{name}.json || fail "no state"
if kill -0 $drive 2>/dev/null; then
  echo state >&3
  await 'disabled, force 0 counts' {name}-drive.log
fi
kill $server; wait $server
kill $drive 2>/dev/null; wait $drive $setting
exec 3>&-; rm /tmp/commands
"""

KILLED_SERVER = """
sleep 0.5
echo state >&3
await '^enabled, force' killed-server-drive.log
kill -9 $server
await watchdog: killed-server-drive.log
echo state >&3
await 'watchdog fired' killed-server-drive.log
kill $drive; wait $drive $setting
exec 3>&-; rm /tmp/commands
"""


def write_hand_motion(path):
    """A hand that never rests, so that a force acts whenever something fails."""
    with path.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["time_s", "angle_rad"])
        rows.writerows([i / 100, 0.5 + 0.2 * math.sin(2 * math.pi * i / 100)] for i in range(2000))


class FaultTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.shared = pathlib.Path(cls.folder.name)
        link = sessions.Link("drive", "canopen.toml", (('interface = "can0"', 'interface = "can1"'),))
        (cls.shared / "drive.toml").write_text(link.configuration())
        write_hand_motion(cls.shared / "hand.csv")
        script = sessions.PRELUDE + virtual_machine.CAN_INTERFACES
        for name, (act, _) in FAULTS.items():
            script += BEGIN.format(name=name) + FAULT.format(name=name, act=act)
        script += BEGIN.format(name="killed-server") + KILLED_SERVER
        virtual_machine.run(PROGRAMS, script, cls.shared, timeout_s=1500)

    def test_each_failure_is_told_and_the_force_is_zero_in_time(self):
        for name, (_, kinds) in FAULTS.items():
            with self.subTest(name):
                axis = sessions.read_axis(self.shared / f"{name}.json")
                self.assertEqual(axis["state"], "STATE_FAULT")
                self.assertIn(axis["fault"]["kind"], kinds, axis["fault"])
                with (self.shared / f"{name}.csv").open(newline="") as file:
                    rows = list(csv.DictReader(file))
                fault = next(i for i, row in enumerate(rows) if row["state"] == "fault")
                self.assertTrue(any(float(row["force_n_m"]) for row in rows[:fault]), "a force acted before")
                self.assertFalse(any(float(row["force_n_m"]) for row in rows[fault + 1:]))

    def test_a_killed_server_leaves_the_drive_without_force(self):
        log = (self.shared / "killed-server-drive.log").read_text()
        self.assertIn("the motor is disabled 50 ms after the last sign of life", log)
        self.assertIn("disabled, force 0 counts, watchdog fired 1 times", log)


if __name__ == "__main__":
    unittest.main()
