"""A reaching session feels the same over every link as in a simulation with that link's delay."""

import pathlib
import subprocess
import tempfile
import unittest

import sessions
import virtual_machine
from sessions import Link
from virtual_machine import BUILD

PROGRAMS = [BUILD / "bin" / name for name in ("mwidthd", "mwidth", "mwidth-drive")]

TO_THE_DRIVE = "--drive $(address)"
LINKS = (
    Link("modbus-tcp", "modbus.toml", server_arguments=TO_THE_DRIVE),
    Link("modbus-tcp-read-write", "modbus.toml",
         (('exchange = "two-requests"', 'exchange = "read-write"'), ("delay_s = 0.001", "delay_s = 0.003")),
         server_arguments=TO_THE_DRIVE, delay_periods=1),
    Link("modbus-rtu", "modbus.toml",
         (('type = "modbus-tcp"', 'type = "modbus-rtu"'), ('host = "192.168.0.10"', 'device = "/dev/pts/0"'),
          ("port = 502\n", "")),
         drive_arguments="--pty", server_arguments=TO_THE_DRIVE,
         # The kernel hands a pseudo-terminal's bytes on from a thread of ordinary priority.
         most_missed_ticks=10),
    Link("socketcand", "canopen.toml", (('type = "socketcan"', 'type = "socketcand"\nhost = "127.0.0.1"'),),
         server_arguments=TO_THE_DRIVE),
    Link("virtual-bus", "canopen.toml", (('interface = "can0"', 'interface = "vcan0"'),)),
    Link("virtual-bus-on-sync", "canopen.toml",
         (('interface = "can0"', 'interface = "vcan0"'), ('exchange = "on-receipt"', 'exchange = "on-sync"'),
          ("delay_s = 0.0005", "delay_s = 0.0015")), delay_periods=1),
    # The drive on one controller, the server on the other.
    Link("controllers", "canopen.toml", (('interface = "can0"', 'interface = "can1"'),), server_arguments="--drive can0"),
)


class SessionTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.shared = pathlib.Path(cls.folder.name)
        for link in LINKS:
            (cls.shared / f"{link.name}.toml").write_text(link.configuration())
        script = sessions.PRELUDE + virtual_machine.CAN_INTERFACES + "".join(link.script() for link in LINKS)
        virtual_machine.run(PROGRAMS, script, cls.shared, timeout_s=1500)

    def test_the_perceived_mass_is_that_of_a_simulation_with_the_same_delay(self):
        for link in LINKS:
            axis = sessions.read_axis(self.shared / f"{link.name}.json")
            loop = axis["info"]["loop"]
            delay_s = axis["tick_statistics"]["loop_delay"]["p50_s"] + link.delay_periods * loop["period_s"]
            simulation = sessions.simulation(link.configuration(), delay_s)
            for mass in sessions.MASSES:
                with self.subTest(link=link.name, mass=mass):
                    felt = sessions.perceived_mass(sessions.read_csv(self.shared / f"{link.name}{mass}.csv"), loop)
                    expected = sessions.perceived_mass(sessions.simulate(simulation, mass), loop)
                    self.assertLess(abs(felt / expected - 1), 0.03, f"{felt} instead of {expected} kg m²")

    def test_no_tick_was_missed_that_the_link_is_not_to_blame_for_and_no_fault_came(self):
        for link in LINKS:
            with self.subTest(link=link.name):
                axis = sessions.read_axis(self.shared / f"{link.name}.json")
                self.assertLessEqual(int(axis["missed_ticks"]), link.most_missed_ticks)
                self.assertEqual(axis["state"], "STATE_READY")


if __name__ == "__main__":
    unittest.main()
