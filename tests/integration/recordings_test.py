"""Recorded human reaches run through the server without a fault, and the stream holds every tick.

Plays each CSV file of the folder MWIDTH_RECORDINGS (columns time_s and one ending in _rad, many reaches each), faster
than real time; without that folder, recordings made here of the same form.
"""

import csv
import math
import os
import pathlib
import random
import tempfile
import threading
import unittest

from server_process import ServerProcess, rendering, seconds

from mwidth.v1 import telemetry_pb2 as telemetry

SPEED = 40
RATE_HZ = 1000
RENEW_EVERY_S = 0.1
RETURN_S = 1


def make_recording(path):
    """Twenty noisy minimum-jerk reaches at 100 Hz."""
    random.seed(1)
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["repetition", "time_s", "elbow_angle_rad"])
        for repetition in range(20):
            start, end = random.uniform(0.3, 1.2), random.uniform(0.3, 2.0)
            steps = random.randint(60, 180)
            for i in range(steps + 1):
                s = i / steps
                angle = start + (end - start) * (10 * s**3 - 15 * s**4 + 6 * s**5)
                writer.writerow([repetition, f"{i / 100:.2f}", f"{angle + 0.002 * math.sin(40 * s):.6f}"])


def recorded(path):
    """Time in seconds that every reach and the returns between them take at the most, smallest and largest angle."""
    with open(path, newline="") as file:
        rows = [(float(row["time_s"]), float(row["elbow_angle_rad"])) for row in csv.DictReader(file)]
    angles = [angle for _, angle in rows]
    reaches = sum(time_s == 0 for time_s, _ in rows)
    return len(rows) / 100 + reaches * RETURN_S, min(angles), max(angles)


class RecordingsTest(unittest.TestCase):
    def test_every_recording_runs_without_a_fault_and_without_a_lost_tick(self):
        folder = os.environ.get("MWIDTH_RECORDINGS")
        with tempfile.TemporaryDirectory() as made:
            if not folder:
                make_recording(pathlib.Path(made) / "made.csv")
            files = sorted(pathlib.Path(folder or made).glob("*.csv"))
            self.assertTrue(files)
            for file in files:
                with self.subTest(file.name):
                    self.run_recording(file)

    def run_recording(self, file):
        length_s, lowest, highest = recorded(file)
        with ServerProcess("--config", "elbow", "--hand-motion", file, "--simulation-speed", SPEED) as server:
            lease = server.acquire(ttl_s=60)
            stopped = threading.Event()
            renewal = threading.Thread(target=self.renew, args=(server, lease, stopped))
            renewal.start()
            try:
                server.start(lease)
                self.watch(server, lease, int(length_s * RATE_HZ), (lowest, highest))
            finally:
                stopped.set()
                renewal.join()

    def renew(self, server, lease, stopped):
        while not stopped.wait(RENEW_EVERY_S):
            server.rendering.RenewControl(rendering.RenewControlRequest(lease_id=lease))

    def watch(self, server, lease, ticks, extent):
        admitted = server.state().m_width.admitted
        masses = [0.9 * admitted.max, 0.9 * admitted.min, 0.0]
        request = telemetry.StreamSamplesRequest(max_batch=1000)
        expected, seen, reached = None, 0, [math.inf, -math.inf]
        for response in server.telemetry.StreamSamples(request):
            if seen * 3 >= ticks * (3 - len(masses)) and masses:
                server.set_mass(lease, masses.pop(0), ramp=seconds(0.5))
            batch = response.batch
            if expected is None and set(batch.state) != {rendering.STATE_RENDERING}:
                continue  # drained from before the start
            gap = 0 if expected is None else batch.first_tick - expected
            self.assertEqual(gap, 0, "a simulated axis misses no tick, and this reader keeps up")
            self.assertEqual(set(batch.state), {rendering.STATE_RENDERING})
            expected = batch.first_tick + len(batch.position)
            seen += len(batch.position)
            reached = [min(reached[0], *batch.position), max(reached[1], *batch.position)]
            if seen >= ticks:
                break
        self.assertEqual(server.state().dropped_samples, 0)
        self.assertFalse(masses, "every mass was rendered")
        self.assertGreater(reached[1] - reached[0], 0.8 * (extent[1] - extent[0]), "the hand moves the joint")


if __name__ == "__main__":
    unittest.main()
