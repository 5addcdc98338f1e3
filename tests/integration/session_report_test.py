"""What mwidthd recorded, as `mwidth session report` tells it and as `mwidth session replay` proves it."""

import math
import pathlib
import re
import subprocess
import tempfile
import time
import unittest

from server_process import BUILD, ServerProcess

import mwidth
import numpy as np
from mwidth import reaches
from mwidth.v1 import session_pb2 as v1
from mwidth.v1 import session_pb2_grpc

SPEED = 20
TARGET_RAD = math.radians(30)  # of --config elbow, whose hand reaches every 4 s
TRIAL_S = 6
MASSES = (0.0, 0.1, -0.05)


class SessionReportTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = cls.enterClassContext(tempfile.TemporaryDirectory())
        with ServerProcess("--config", "elbow", "--simulation-speed", SPEED, "--sessions", cls.folder) as server:
            with mwidth.Client(server.address) as client:
                cls.name = cls.record(client, session_pb2_grpc.SessionServiceStub(server.channel))
                cls.stored = client.stored_session(cls.name)
                cls.samples = client.read_session(cls.name).samples()
                cls.device = client.axis().info.loop

    @staticmethod
    def record(client, stub):
        def mark(kind, **metadata):
            # Without a time of the client: the clock of this simulation runs faster than a client's.
            stub.AddMarker(v1.AddMarkerRequest(kind=kind, label="there & back", metadata=metadata))

        with client.session(subject="sub-01", task="reach") as session, client.control("test", ttl_s=60) as control:
            control.start_rendering()
            for mass in MASSES:
                control.set_mass(mass)
                time.sleep(0.5 / SPEED)
                mark("trial_start", target_rad=str(TARGET_RAD), start_rad="0")
                time.sleep(TRIAL_S / SPEED)
                mark("trial_end")
            control.stop_rendering()
            return session.session_id

    def mwidth_session(self, *arguments):
        return subprocess.run([BUILD / "bin" / "mwidth", "session", "--folder", self.folder, *arguments],
                              capture_output=True, text=True, check=True).stdout

    def page(self):
        path = pathlib.Path(self.folder) / "page.html"
        self.mwidth_session("report", self.name, "--to", str(path))
        return path.read_text(encoding="utf-8")

    def trials(self):
        starts = [marker.monotonic_ns for marker in self.stored.markers if marker.kind == "trial_start"]
        ends = [marker.monotonic_ns for marker in self.stored.markers if marker.kind == "trial_end"]
        for start, end in zip(starts, ends):
            part = (self.samples.monotonic_ns >= start) & (self.samples.monotonic_ns < end)
            yield mwidth.SampleBatch(**{field: column[part] for field, column in vars(self.samples).items()
                                        if isinstance(column, np.ndarray)})

    def test_every_sample_is_proved(self):
        told = self.mwidth_session("replay", self.name)
        self.assertIn(f"{len(self.samples.tick) - 1} of {len(self.samples.tick)} samples computed again", told)

    def test_the_reaches_are_those_that_the_python_package_finds(self):
        rows = re.findall(r'<tr><th class="text" scope="row"><a href="#trial-(\d)">.*?</tr>', self.page(), re.S)
        cells = [re.findall(r"<td>(.*?)</td>", row, re.S) for row in
                 re.findall(r'<tr><th class="text" scope="row"><a href="#trial-\d">.*?</tr>', self.page(), re.S)]
        compared = 0
        for number, trial in enumerate(self.trials(), start=1):
            moved = reaches.motion(trial, self.device.period_s)
            found = reaches.find_reaches(moved, 0, TARGET_RAD, before_s=0, after_s=0.9)
            shown = [cell for row, cell in zip(rows, cells) if row == str(number)]
            self.assertGreaterEqual(len(shown), len(found))
            for reach, cell in zip(found, shown):
                overshoot = 100 * reaches.overshoot([reach], 0, TARGET_RAD)
                self.assertAlmostEqual(float(cell[3].rstrip("‡").replace("−", "-")), overshoot, delta=0.0501)
                peak = math.degrees(reach.velocity.max())
                self.assertAlmostEqual(float(cell[7]), peak, delta=0.0501)
                compared += 1
        self.assertGreaterEqual(compared, len(MASSES))

    def test_it_tells_the_margins_that_the_server_told(self):
        text = self.page()
        told = re.findall(r"Margins to instability</th><td>gain (\S+?)(?: dB)?,", text)
        masses = [event.metadata for event in self.stored.events if "gain_margin_db" in event.metadata]
        self.assertEqual(told[0], "∞")
        self.assertEqual(len(told), len(MASSES))
        for shown, event in zip(told[1:], masses[1:]):
            self.assertAlmostEqual(float(shown), float(event["gain_margin_db"]), delta=0.06)
        self.assertIn(f"<td>{self.device.device_mass:.4g} kg m², {self.device.device_damping:.4g} N m s/rad</td>", text)
        self.assertIn("which was simulated", text)
        self.assertIn("Admitted masses at the start", text)


if __name__ == "__main__":
    unittest.main()
