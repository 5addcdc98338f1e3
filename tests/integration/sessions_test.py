"""Sessions as a study records them: through the Python client, from a server of its own."""

import json
import os
import pathlib
import tempfile
import threading
import time
import unittest

from server_process import ServerProcess

import mwidth
import numpy as np
from mwidth.v1 import session_pb2 as v1
from mwidth.v1 import telemetry_pb2 as telemetry

COLUMNS = ("tick", "monotonic_ns", "position", "velocity", "acceleration", "force", "mass", "state", "saturated",
           "position_counts", "force_counts", "acceleration_counts")


class SessionsTest(unittest.TestCase):
    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory())
        self.server = self.enterContext(
            ServerProcess("--config", "elbow", "--simulation-speed", 20, "--sessions", self.folder))
        self.client = self.enterContext(mwidth.Client(self.server.address))

    def assert_refused(self, code, reason, call):
        with self.assertRaises(mwidth.Error) as raised:
            call()
        self.assertEqual(raised.exception.code.name, code, str(raised.exception))
        self.assertEqual(raised.exception.reason, reason)
        self.assertGreater(len(str(raised.exception)), 20, "a sentence")

    def record(self, ticks=2000, **labels):
        """Records at least so many ticks while they are streamed, and returns the session and the streamed samples."""
        with self.client.stream(max_batch=1000) as stream:
            with self.client.session(**{"subject": "sub-01", "task": "reach", **labels}) as session:
                batches = [next(stream)]
                while batches[-1].tick[-1] < batches[0].tick[0] + ticks:
                    batches.append(next(stream))
            while batches[-1].tick[-1] < session.info.last_tick:
                batches.append(next(stream))
            self.assertEqual(stream.dropped_ticks, 0)
        return session, mwidth.concatenate(batches)

    def test_what_is_read_is_what_was_streamed_to_the_bit(self):
        with self.client.control("test", ttl_s=60) as control:
            control.start_rendering()
            control.set_mass(0.05)
            session, streamed = self.record(ticks=4000)
            control.stop_rendering()
        info = session.info
        self.assertEqual(info.state, v1.SESSION_STATE_ENDED)
        self.assertEqual((info.lost_ticks, info.missed_ticks), (0, 0))
        self.assertEqual(info.samples, info.last_tick - info.first_tick + 1)
        read = self.client.read_session(info.session_id).samples()
        self.assertEqual((read.tick[0], read.tick[-1]), (info.first_tick, info.last_tick))
        part = (streamed.tick >= info.first_tick) & (streamed.tick <= info.last_tick)
        both = (read.tick >= streamed.tick[0]) & (read.tick <= streamed.tick[-1])
        self.assertGreater(both.sum(), 1000)
        for name in COLUMNS:
            np.testing.assert_array_equal(
                getattr(read, name)[both].view(np.uint8), getattr(streamed, name)[part].view(np.uint8), name)

    def test_markers_and_events_lie_on_the_time_line_of_the_samples(self):
        with self.client.session(subject="sub-01", task="reach") as session:
            with session.trial("one", target_rad=0.5):
                time.sleep(0.02)
            self.assertIsNone(session.clock, "the axis's time runs at another pace")
            with self.assertRaises(ValueError):
                session.mark("earlier", at_ns=time.monotonic_ns())
            session.mark("late")
            with self.client.control("the study") as control:
                control.set_mass(0.05)
        stored = self.client.stored_session(session.session_id)
        self.assertEqual([(marker.label, marker.kind) for marker in stored.markers],
                         [("one", "trial_start"), ("one", "trial_end"), ("late", "")])
        self.assertEqual(stored.markers[0].metadata["target_rad"], "0.5")
        for marker in stored.markers:
            self.assertEqual(marker.monotonic_ns, marker.arrival_ns)
        kinds = [event.kind for event in stored.events]
        self.assertIn(telemetry.EVENT_KIND_SESSION_STARTED, kinds)
        self.assertIn(telemetry.EVENT_KIND_MASS_SET, kinds)
        mass = next(event for event in stored.events if event.kind == telemetry.EVENT_KIND_MASS_SET)
        self.assertLess(float(mass.metadata["admitted_min"]), 0)
        # In the stream they stand where they belong.
        times, notes = [], 0
        for record in self.client.read_session(session.session_id):
            if isinstance(record, mwidth.SampleBatch):
                times += list(record.monotonic_ns)
            else:
                notes += 1
                times.append(record.monotonic_ns)
        self.assertEqual(times, sorted(times))
        self.assertEqual(notes, len(stored.markers) + len(stored.events))

    def test_a_session_says_what_ran(self):
        session, _ = self.record(visit="ses-2", run=7, operator="the operator", metadata={"arm": "left"})
        labels = session.info.labels
        self.assertEqual((labels.subject, labels.visit, labels.task, labels.run), ("01", "2", "reach", 7))
        self.assertEqual((labels.operator, dict(labels.metadata)), ("the operator", {"arm": "left"}))
        stored = self.client.stored_session(session.session_id)
        self.assertIn("[axis.loop]", stored.configuration)
        self.assertIn("--simulation-speed 20", stored.command_line)
        state = json.loads(stored.axis_state)
        self.assertEqual(state["info"]["name"], "elbow")
        self.assertLess(state["m_width"]["admitted"]["min"], 0)
        file = pathlib.Path(self.folder, session.session_id + ".sqlite")
        self.assertEqual(session.info.file_bytes, file.stat().st_size)
        self.assertEqual(os.listdir(self.folder), [file.name], "nothing else is left")

    def test_runs_are_counted_and_sessions_listed_the_newest_first(self):
        runs = [self.record(ticks=100, subject=subject)[0].info for subject in ("sub-01", "02", "01")]
        self.assertEqual([run.labels.run for run in runs], [1, 1, 2])
        listed = self.client.sessions()
        self.assertEqual([each.session_id for each in listed], [run.session_id for run in reversed(runs)])
        self.assertEqual(len(self.client.sessions(subject="sub-01")), 2)
        self.assertEqual(listed[0].samples, runs[2].samples)

    def test_a_part_is_read_and_at_the_speed_that_is_asked_for(self):
        info = self.record()[0].info
        first = info.first_tick + 500
        read = self.client.read_session(info.session_id, first_tick=first, last_tick=first + 999).samples()
        self.assertEqual((read.tick[0], read.tick[-1], len(read)), (first, first + 999, 1000))
        begin = time.monotonic()
        self.client.read_session(info.session_id, first_tick=first, last_tick=first + 999, speed=2,
                                 max_batch=10).samples()
        self.assertGreater(time.monotonic() - begin, 0.45, "half a second of samples twice as fast")

    def test_refusals_say_what_to_do(self):
        self.assert_refused("INVALID_ARGUMENT", "INVALID_TEXT",
                            lambda: self.client.session(subject="../sub", task="reach"))
        self.assert_refused("INVALID_ARGUMENT", "INVALID_TEXT", lambda: self.client.session(subject="01", task=""))
        self.assert_refused("INVALID_ARGUMENT", "INVALID_NUMBER",
                            lambda: self.client.session(subject="01", task="reach", run=10_000))
        self.assert_refused("NOT_FOUND", "UNKNOWN_SESSION", lambda: self.client.stored_session("../../etc/passwd"))
        self.assert_refused("NOT_FOUND", "UNKNOWN_SESSION", lambda: next(self.client.read_session("none")))
        with self.client.session(subject="01", task="reach", run=1) as session:
            self.assert_refused("FAILED_PRECONDITION", "SESSION_OPEN",
                                lambda: self.client.session(subject="02", task="reach"))
            self.assert_refused("INVALID_ARGUMENT", "INVALID_TEXT", lambda: session.mark("m" * 201))
        self.assert_refused("FAILED_PRECONDITION", "SESSION_EXISTS",
                            lambda: self.client.session(subject="01", task="reach", run=1))
        self.assert_refused("FAILED_PRECONDITION", "NO_SESSION", lambda: session.mark("too late"))

    def test_a_file_that_is_no_session_is_listed_as_unreadable(self):
        pathlib.Path(self.folder, "broken.sqlite").write_bytes(b"not a database")
        listed = self.client.sessions()
        self.assertEqual([(each.session_id, each.state) for each in listed], [("broken", v1.SESSION_STATE_UNREADABLE)])
        self.assertTrue(listed[0].message)
        self.assert_refused("DATA_LOSS", "UNREADABLE_SESSION", lambda: self.client.stored_session("broken"))

    def test_texts_that_are_no_utf8_do_not_spoil_the_list(self):
        pathlib.Path(os.fsdecode(os.fsencode(self.folder) + b"/bad\xff.sqlite")).write_bytes(b"not a database")
        info = self.record(ticks=10)[0].info
        self.assertEqual({each.session_id for each in self.client.sessions()}, {info.session_id, "bad\ufffd"})

    def test_a_marker_dated_by_another_clock_does_not_hold_up_playback(self):
        with self.client.session(subject="01", task="reach") as session:
            for client_ns in (0, time.time_ns()):
                self.client._sessions.AddMarker(v1.AddMarkerRequest(time=v1.ClientTime(client_ns=client_ns)))
            time.sleep(0.05)
        markers = [each for each in self.client.read_session(session.session_id, speed=1000) if isinstance(each, v1.Marker)]
        self.assertEqual(len(markers), 2)

    def test_a_session_ends_once(self):
        session = self.client.session(subject="01", task="reach")
        outcomes = []

        def end():
            try:
                self.client._call(self.client._sessions.EndSession, v1.EndSessionRequest(session_id=session.session_id))
                outcomes.append("ended")
            except mwidth.Error as error:
                outcomes.append(error.reason)

        threads = [threading.Thread(target=end) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(sorted(outcomes), ["UNKNOWN_SESSION", "UNKNOWN_SESSION", "ended"])
        kinds = [event.kind for event in self.client.stored_session(session.session_id).events]
        self.assertEqual(kinds.count(telemetry.EVENT_KIND_SESSION_ENDED), 1)

    def test_events_are_told_as_they_happen(self):
        with self.client.events() as events:
            with self.client.control("the study") as control:
                control.start_rendering()
                with self.assertRaises(mwidth.Refused):
                    control.set_mass(-1)
            self.client.emergency_stop("a test")
            told = []
            while not told or told[-1].kind != telemetry.EVENT_KIND_FAULT:
                told.append(next(events))
        self.assertEqual([event.number for event in told], list(range(told[0].number, told[0].number + len(told))))
        refused = next(event for event in told if event.kind == telemetry.EVENT_KIND_MASS_REFUSED)
        self.assertEqual(refused.metadata["reason"], "UNSTABLE_MASS")
        stop = next(event for event in told if event.kind == telemetry.EVENT_KIND_EMERGENCY_STOP)
        self.assertEqual(stop.metadata["reason"], "a test")
        self.assertIn("RENDERING", "".join(event.message for event in told))

    def test_the_clock_of_the_server_is_found_to_within_its_bound(self):
        offset = self.client.sync_clock()
        self.assertGreater(offset.error_ns, 0)
        # With a simulated clock that runs 20 times as fast, an offset holds for a moment only; its bound is what counts.
        before = self.server.telemetry.SyncClock(telemetry.SyncClockRequest()).server_send_ns
        again = self.client.sync_clock()
        after = self.server.telemetry.SyncClock(telemetry.SyncClockRequest()).server_send_ns
        now = again.to_axis_ns(time.monotonic_ns())
        self.assertGreater(now + again.error_ns, before)
        self.assertLess(after - before, 20 * 10_000_000_000)


class UnusableFolderTest(unittest.TestCase):
    def test_keeps_nobody_from_rendering(self):
        with tempfile.NamedTemporaryFile() as file, ServerProcess("--config", "paper", "--sessions", file.name) as server, \
                mwidth.Client(server.address) as client:
            with client.control("test") as control:
                control.start_rendering()
                control.set_mass(0.05)
                control.stop_rendering()
            with self.assertRaises(mwidth.Error) as raised:
                client.session(subject="01", task="reach")
            self.assertEqual(raised.exception.reason, "STORAGE_FAILED")


class RealTimeClockTest(unittest.TestCase):
    def test_a_past_moment_is_marked_where_it_was(self):
        with tempfile.TemporaryDirectory() as folder, ServerProcess("--config", "paper", "--sessions", folder) as server, \
                mwidth.Client(server.address) as client, client.session(subject="01", task="reach") as session:
            past_ns = time.monotonic_ns() - 10_000_000
            marker = session.mark("past", at_ns=past_ns)
            self.assertEqual(marker.client_ns, past_ns)
            self.assertGreater(marker.error_ns, 0)
            self.assertLessEqual(abs(marker.monotonic_ns - past_ns), marker.error_ns, "one clock for all of a host")
            self.assertGreater(marker.arrival_ns, marker.monotonic_ns)

    def test_both_clocks_being_one_the_offset_is_zero_within_its_bound(self):
        with tempfile.TemporaryDirectory() as folder, ServerProcess("--config", "paper", "--sessions", folder) as server, \
                mwidth.Client(server.address) as client:
            # CLOCK_MONOTONIC is the same for every process of a host.
            for _ in range(20):
                offset = client.sync_clock()
                self.assertLessEqual(abs(offset.offset_ns), offset.error_ns)


if __name__ == "__main__":
    unittest.main()
