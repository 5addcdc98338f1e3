"""What mwidthd streamed while it recorded, and what other programs read from its exports: the same bits."""

import contextlib
import csv
import json
import math
import pathlib
import tempfile
import time
import unittest

import h5py
import numpy as np

from bids_checker import problems_of, rows_of, table
from server_process import ServerProcess
from session_exports_test import ROTARY_UNITS, LINEAR_UNITS, STATES, mwidth as run, validate

import mwidth

COLUMNS = ("tick", "monotonic_ns", "position", "velocity", "acceleration", "force", "mass", "state", "saturated",
           "position_counts", "force_counts", "acceleration_counts")
IN_DEGREES = ("position", "velocity", "acceleration")


class SessionRoundTripTest(unittest.TestCase):
    def setUp(self):
        stack = contextlib.ExitStack()
        self.addCleanup(stack.close)
        self.folder = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory()))
        self.out = self.folder / "out"

    def record(self, config, mass, ticks=3000):
        """Records while it streams and renders; the session, and what was streamed of it."""
        with contextlib.ExitStack() as stack:
            server = stack.enter_context(
                ServerProcess("--config", config, "--simulation-speed", 20, "--sessions", self.folder))
            client = stack.enter_context(mwidth.Client(server.address))
            control = stack.enter_context(client.control("test", ttl_s=60))
            stream = stack.enter_context(client.stream(max_batch=1000))
            with client.session(subject="01", visit="1", task="reach", operator="me") as session:
                control.start_rendering()
                control.set_mass(mass)
                with session.trial("one", target_rad=0.5):
                    batches = [next(stream)]
                    while batches[-1].tick[-1] < batches[0].tick[0] + ticks:
                        batches.append(next(stream))
                control.set_filter(15)
                time.sleep(0.02)
                session.mark("after the filter")
            while batches[-1].tick[-1] < session.info.last_tick:
                batches.append(next(stream))
            control.stop_rendering()
        streamed = mwidth.concatenate(batches)
        inside = (streamed.tick >= session.info.first_tick) & (streamed.tick <= session.info.last_tick)
        return session, {name: np.asarray(getattr(streamed, name))[inside] for name in COLUMNS}

    def export(self, session, form):
        result = run("session", "export", session.session_id, "--folder", self.folder, "--to", self.out, "--format", form)
        self.assertEqual(result.returncode, 0, result.stderr)

    def assert_same(self, name, read, streamed):
        """To the bit; `read` and `streamed` are of the same ticks."""
        streamed = np.asarray(streamed)
        if streamed.dtype.kind == "f":
            self.assertTrue(np.array_equal(np.asarray(read, "<f8").view("<u8"), streamed.astype("<f8").view("<u8")), name)
        else:
            self.assertTrue(np.array_equal(np.asarray(read).astype(np.int64), streamed.astype(np.int64)), name)

    def check(self, config, mass, units, degrees):
        session, streamed = self.record(config, mass)
        ticks = streamed["tick"]
        self.assertGreater(len(ticks), 3000)
        self.assertGreater(len(np.unique(streamed["force"])), 20, "something was rendered")
        for form in ("csv", "hdf5"):
            self.export(session, form)
        with open(self.out / session.session_id / "samples.csv", newline="", encoding="utf-8") as file:
            there = set(ticks.tolist())
            rows = [row for row in csv.DictReader(file) if int(row["tick"]) in there]
        with h5py.File(self.out / f"{session.session_id}.h5") as file:
            inside = np.isin(file["samples/tick"][:], ticks)
            for name in COLUMNS:
                column = [row[f"{name}_{units[name]}" if name in units else name] for row in rows]
                column = [STATES.index(cell) for cell in column] if name == "state" else column
                kind = float if streamed[name].dtype.kind == "f" else int
                expected = streamed[name]
                if name == "state":
                    # The API counts from 1; 0 is unspecified there.
                    expected = expected.astype(np.int64) - 1
                self.assert_same(name, [kind(cell) for cell in column], expected)
                self.assert_same(name, file["samples"][name][inside], expected)
        self.check_bids(session, streamed, degrees)

    def check_bids(self, session, streamed, degrees):
        dataset = self.out / "bids"
        self.out = dataset
        self.export(session, "bids")
        self.assertEqual(problems_of(dataset), [])
        self.assertEqual(validate(dataset)[0], [])
        motion, = dataset.glob("sub-*/ses-*/motion/*_motion.tsv")
        _, channels = table(motion.with_name(motion.name.replace("_motion.tsv", "_channels.tsv")))
        rows = {int(row[6]): row for row in rows_of(motion) if row[6] != "n/a"}
        self.assertEqual(channels[6]["name"], "tick")
        index = {"force" if channel["name"] == "torque" else channel["name"]: i for i, channel in enumerate(channels)}
        for name in COLUMNS:
            cells = [rows[tick][index[name]] for tick in streamed["tick"].tolist()]
            expected = streamed[name].astype(np.int64) - 1 if name == "state" else streamed[name]
            if degrees and name in IN_DEGREES:
                expected = np.array([math.degrees(value) for value in expected.tolist()])
            kind = float if streamed[name].dtype.kind == "f" else int
            self.assert_same(name, [kind(cell) for cell in cells], expected)
        sidecar = json.loads(motion.with_suffix(".json").read_text())
        self.assertEqual(len(sidecar["SoftwareFilters"]), 2, "the filter was changed")
        _, events = table(motion.with_name(motion.name.replace("_motion.tsv", "_events.tsv")))
        kinds = [event["trial_type"] for event in events]
        for kind in ("trial", "mass_set", "filter_set", "marker"):
            self.assertIn(kind, kinds)

    def test_a_session_that_is_being_recorded_is_read_up_to_now(self):
        with ServerProcess("--config", "elbow", "--simulation-speed", 20, "--sessions", self.folder) as server, \
                mwidth.Client(server.address) as client:
            with client.session(subject="01", task="reach") as session:
                time.sleep(0.5)
                listed = json.loads(run("session", "list", "--folder", self.folder, "--json").stdout)
                self.assertEqual([(each["session"], each["state"]) for each in listed], [(session.session_id, "recording")])
                for form in ("csv", "hdf5", "bids"):
                    self.export(session, form)
                self.assertEqual(run("session", "verify", session.session_id, "--folder", self.folder).returncode, 0)
                self.assertEqual(run("session", "recover", session.session_id, "--folder", self.folder).returncode, 1)
            self.assertEqual(session.info.lost_ticks, 0)
        with h5py.File(self.out / f"{session.session_id}.h5") as file:
            ticks = file["samples/tick"][:]
        self.assertGreater(len(ticks), 1000)
        self.assertTrue(np.all(np.diff(ticks.astype(np.int64)) > 0))
        self.assertEqual(int(ticks[0]), session.info.first_tick)
        self.assertLessEqual(int(ticks[-1]), session.info.last_tick)
        self.assertEqual(run("session", "verify", session.session_id, "--folder", self.folder).returncode, 0)

    def test_a_rotary_axis(self):
        self.check("elbow", 0.05, ROTARY_UNITS, degrees=True)

    def test_a_linear_axis(self):
        self.check("paper", 0.05, LINEAR_UNITS, degrees=False)


if __name__ == "__main__":
    unittest.main()
