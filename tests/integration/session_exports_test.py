"""Recorded sessions as other people's programs read them: csv, h5py, and a BIDS dataset with two checkers."""

import concurrent.futures
import contextlib
import csv
import json
import math
import os
import pathlib
import shutil
import sqlite3
import subprocess
import tempfile
import unittest

import h5py
import numpy

from bids_checker import problems_of, rows_of, table

BUILD = pathlib.Path(os.environ["MWIDTH_BUILD"])
ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
VALIDATOR = ROOT / "build" / "npm" / "node_modules" / ".bin" / "bids-validator"

# As tests/server/record/export/write_session.cc writes them.
TRUTH = numpy.dtype([
    ("tick", "<u8"), ("monotonic_ns", "<i8"), ("position", "<f8"), ("velocity", "<f8"), ("acceleration", "<f8"),
    ("force", "<f8"), ("mass", "<f8"), ("state", "u1"), ("saturated", "u1"), ("position_counts", "<i8"),
    ("force_counts", "<i4"), ("acceleration_counts", "<i4"), ("slew_limited", "u1"), ("position_stale", "u1"),
    ("force_taken", "u1"), ("missed_ticks", "<u8"), ("estimator", "u1"), ("cutoff_hz", "<f8")])
STATES = ["idle", "ready", "rendering", "fault"]
ESTIMATORS = {0: "filtered-difference", 3: "kalman"}
ROTARY_UNITS = {"position": "rad", "velocity": "rad_per_s", "acceleration": "rad_per_s2", "force": "n_m", "mass": "kg_m2"}
LINEAR_UNITS = {"position": "m", "velocity": "m_per_s", "acceleration": "m_per_s2", "force": "n", "mass": "kg"}
SAMPLES = 12_000
FIRST_NS = 5_000_000_000_123


def mwidth(*arguments, **more):
    return subprocess.run([BUILD / "bin" / "mwidth", *map(str, arguments)], capture_output=True, text=True, timeout=120,
                          **more)


def write_session(file, *arguments):
    """Writes a session; returns its samples."""
    truth = file.with_suffix(".truth")
    subprocess.run([BUILD / "bin" / "mwidth_write_session", file, "--truth", truth, "--samples", str(SAMPLES),
                    *map(str, arguments)], check=True, timeout=60)
    samples = numpy.fromfile(truth, TRUTH)
    truth.unlink()
    return samples


def same_bits(a, b):
    """Equal to the sign of zero."""
    return numpy.array_equal(numpy.asarray(a, "<f8").view("<u8"), numpy.asarray(b, "<f8").view("<u8"))


def flip_a_bit(file, block):
    """Of the data of a block, past SQLite, as a failing disk does."""
    database = sqlite3.connect(file)
    data, first, last = database.execute("SELECT data, first_tick, last_tick FROM blocks WHERE number = ?", (block,)).fetchone()
    database.close()
    content = bytearray(file.read_bytes())
    # A piece long enough to be there once, and short enough to lie in one page.
    at = content.find(data[1000:1100])
    assert at > 0 and content.find(data[1000:1100], at + 1) < 0
    content[at + 50] ^= 0x10
    file.write_bytes(content)
    return first, last


def validate(dataset):
    """Errors and warnings of the legacy bids-validator."""
    result = subprocess.run([VALIDATOR, dataset, "--json"], capture_output=True, text=True, timeout=120)
    issues = json.loads(result.stdout)["issues"]
    return [issue["key"] for issue in issues["errors"]], [issue["key"] for issue in issues["warnings"]]


class SessionExportsTest(unittest.TestCase):
    def setUp(self):
        stack = contextlib.ExitStack()
        self.addCleanup(stack.close)
        self.folder = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory()))
        self.session = self.folder / "one.sqlite"
        self.out = self.folder / "out"

    def export(self, form, *sessions, code=0, options=()):
        result = mwidth("session", "export", *(sessions or [self.session]), "--to", self.out, "--format", form, *options)
        self.assertEqual(result.returncode, code, result.stderr + result.stdout)
        return result

    # CSV

    def csv_rows(self, name):
        with open(self.out / "one" / name, newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def check_csv(self, samples, units):
        rows = self.csv_rows("samples.csv")
        self.assertEqual(len(rows), len(samples))
        for name in TRUTH.names:
            column = [row[f"{name}_{units[name]}" if name in units else name] for row in rows]
            if name == "state":
                self.assertEqual(column, [STATES[state] for state in samples[name]])
            elif name == "estimator":
                self.assertEqual(column, [ESTIMATORS[estimator] for estimator in samples[name]])
            elif TRUTH[name].kind == "f":
                self.assertTrue(same_bits([float(cell) for cell in column], samples[name]), name)
            else:
                self.assertEqual([int(cell) for cell in column], samples[name].tolist(), name)

    def test_csv_has_every_sample_to_the_bit(self):
        samples = write_session(self.session)
        self.export("csv")
        self.check_csv(samples, ROTARY_UNITS)

    def test_csv_of_a_linear_axis_has_its_units(self):
        samples = write_session(self.session, "--linear", "--seed", 7)
        self.export("csv")
        self.check_csv(samples, LINEAR_UNITS)

    def test_csv_has_markers_events_and_gaps_with_their_texts(self):
        samples = write_session(self.session)
        self.export("csv")
        markers = self.csv_rows("markers.csv")
        self.assertEqual([marker["kind"] for marker in markers],
                         ["trial_start", "trial_end", "trial_start", "cue", "trial_end", "", "trial_start"])
        self.assertEqual(markers[2]["label"], 'reach, "2"\n')
        self.assertEqual(json.loads(markers[0]["metadata"]), {"target_rad": "0.5"})
        self.assertEqual(int(markers[0]["error_ns"]), 250001)
        events = self.csv_rows("events.csv")
        self.assertEqual([event["kind"] for event in events], ["session_started", "mass_refused", "fault"])
        self.assertEqual(events[1]["message"], 'a mass of -0.5 kg m² is refused:\n"unstable", so')
        self.assertEqual(json.loads(events[1]["metadata"]), {"mass": "-0.5", "admitted_min": "-0.17"})
        # Ticks between first and last are samples or told in gaps.
        told = sum(int(gap["missed_ticks"]) + int(gap["lost_ticks"]) for gap in self.csv_rows("gaps.csv"))
        self.assertGreater(told, 0)
        self.assertEqual(int(samples["tick"][-1] - samples["tick"][0]) + 1, len(samples) + told)
        session = json.loads((self.out / "one" / "session.json").read_text())
        self.assertEqual(session["labels"]["operator"], 'Zoë, "the" operator')
        self.assertEqual(session["configuration"], '[[axis]]\nname = "elbow"  # größer\n')
        self.assertIsNone(session["axis"]["force_slew_limit"])
        self.assertEqual(len(session["wall_clock_steps"]), 1)

    # HDF5

    def check_hdf5(self, samples):
        with h5py.File(self.out / "one.h5") as file:
            for name in TRUTH.names:
                column = file["samples"][name]
                self.assertEqual(column.dtype, TRUTH[name], name)
                self.assertEqual((column.compression, column.shuffle, column.fletcher32), ("gzip", True, True))
                if TRUTH[name].kind == "f":
                    self.assertTrue(same_bits(column[:], samples[name]), name)
                else:
                    self.assertTrue(numpy.array_equal(column[:], samples[name]), name)
                self.assertIsInstance(column.attrs["units"], str)
                self.assertGreater(len(column.attrs["description"]), 5)
            self.assertEqual(len(file["samples"]), len(TRUTH.names))

    def test_hdf5_has_every_sample_to_the_bit_in_its_type(self):
        samples = write_session(self.session)
        self.export("hdf5")
        self.check_hdf5(samples)
        with h5py.File(self.out / "one.h5") as file:
            self.assertEqual(file["samples/position"].attrs["units"], "rad")
            self.assertEqual(file["samples/force"].attrs["units"], "N m")
            self.assertIn("2 rendering", file["samples/state"].attrs["values"])

    def test_hdf5_says_who_what_and_how(self):
        write_session(self.session)
        self.export("hdf5")
        with h5py.File(self.out / "one.h5") as file:
            attributes = dict(file.attrs)
            self.assertEqual(attributes["subject"], "01")
            self.assertEqual(attributes["run"], 2)
            self.assertEqual(attributes["operator"], 'Zoë, "the" operator')
            self.assertEqual(attributes["period_s"], 0.001)
            self.assertEqual(attributes["force_slew_limit"], math.inf)
            self.assertEqual(attributes["start_wall_ns"], 1_763_793_000_123_456_789)
            self.assertEqual(attributes["state"], "ended")
            self.assertEqual(file["configuration"].asstr()[()], '[[axis]]\nname = "elbow"  # größer\n')
            self.assertEqual(json.loads(file["metadata"].asstr()[()])["note"], 'a,b\tc\nd "e" ü')
            self.assertEqual(list(file["markers/label"].asstr())[3], "Ton höher\tjetzt")
            self.assertEqual(list(file["markers/client_ns"]), [22, 37, 47, 52, 67, 77, 107])
            self.assertEqual(list(file["events/number"]), [41, 42, 43])
            self.assertEqual(list(file["events/kind"].asstr()), ["session_started", "mass_refused", "fault"])
            told = sum(file["gaps/missed_ticks"]) + sum(file["gaps/lost_ticks"])
            ticks = file["samples/tick"]
            self.assertEqual(int(ticks[-1] - ticks[0]) + 1, len(ticks) + int(told))
            self.assertEqual(len(file["damaged_blocks/number"]), 0)

    # Motion-BIDS

    def recording(self, subject="01", visit="_ses-1", task="reach", run="02", suffix="motion.tsv"):
        folder = self.out / f"sub-{subject}"
        folder = folder / visit[1:] if visit else folder
        return folder / "motion" / f"sub-{subject}{visit}_task-{task}_tracksys-mwidth_run-{run}_{suffix}"

    def check_motion(self, samples, scale):
        """motion.tsv by the names of channels.tsv: present rows to the bit, the others n/a."""
        _, channels = table(self.recording(suffix="channels.tsv"))
        rows = rows_of(self.recording())
        first = samples["tick"][0]
        self.assertEqual(len(rows), samples["tick"][-1] - first + 1)
        present = set((samples["tick"] - first).tolist())
        for number, row in enumerate(rows):
            self.assertEqual(row == ["n/a"] * len(channels), number not in present)
        columns = {channel["name"]: [row[i] for number, row in enumerate(rows) if number in present]
                   for i, channel in enumerate(channels)}
        self.assertEqual(len(columns), len(TRUTH.names) + 1)
        columns["force"] = columns.pop("torque", columns.get("force"))
        for name in TRUTH.names:
            if TRUTH[name].kind != "f":
                self.assertEqual([int(cell) for cell in columns[name]], samples[name].tolist(), name)
                continue
            factor = scale if name in ("position", "velocity", "acceleration") else 1.0
            with numpy.errstate(over="ignore"):
                expected = samples[name] * factor
            finite = numpy.isfinite(expected)
            self.assertEqual([cell == "n/a" for cell in columns[name]], (~finite).tolist(), name)
            read = [float(cell) for cell in columns[name] if cell != "n/a"]
            self.assertTrue(same_bits(read, expected[finite]), name)
        latency_us = [round(float(cell) * 1e6) for cell in columns["latency"]]
        self.assertEqual(latency_us, ((samples["monotonic_ns"] - FIRST_NS) // 1000).tolist())

    def test_bids_of_a_rotary_axis_is_valid_and_has_every_sample_in_degrees(self):
        samples = write_session(self.session)
        self.export("bids")
        self.assertEqual(problems_of(self.out), [])
        errors, warnings = validate(self.out)
        self.assertEqual(errors, [])
        # The validator takes the first row of the head-less motion.tsv for a head; authors are the study's to add.
        self.assertEqual(sorted(warnings), ["CUSTOM_COLUMN_WITHOUT_DESCRIPTION", "NO_AUTHORS"])
        # The same arithmetic as math.degrees: one multiplication by 180/pi.
        self.check_motion(samples, 180.0 / math.pi)
        self.assertEqual(math.degrees(float(samples["position"][5])),
                         float(rows_of(self.recording())[5][1]))
        _, channels = table(self.recording(suffix="channels.tsv"))
        position = channels[1]
        self.assertEqual([position[key] for key in ("name", "component", "type", "tracked_point", "units")],
                         ["position", "n/a", "JNTANG", "elbow", "deg"])
        torque = next(channel for channel in channels if channel["name"] == "torque")
        self.assertEqual((torque["type"], torque["units"]), ("MISC", "N.m"))

    def test_bids_of_a_linear_axis_is_valid_and_in_metres(self):
        samples = write_session(self.session, "--linear")
        self.export("bids")
        self.assertEqual(problems_of(self.out), [])
        self.assertEqual(validate(self.out)[0], [])
        self.check_motion(samples, 1.0)
        _, channels = table(self.recording(suffix="channels.tsv"))
        self.assertEqual([(c["type"], c["component"], c["units"]) for c in channels[1:6]],
                         [("POS", "x", "m"), ("VEL", "x", "m/s"), ("ACCEL", "x", "m/s^2"), ("MISC", "n/a", "N"),
                          ("MISC", "n/a", "kg")])

    def test_bids_events_are_trials_markers_faults_and_gaps_on_the_time_line_of_the_samples(self):
        samples = write_session(self.session)
        self.export("bids")
        _, events = table(self.recording(suffix="events.tsv"))
        markers_ns = [int((samples["monotonic_ns"][-1] - FIRST_NS) // 100 * percent + 7) for percent in (5, 20, 30, 50, 90)]
        trials = [event for event in events if event["trial_type"] == "trial"]
        self.assertEqual([trial["label"] for trial in trials], ["reach 1", 'reach, "2" ', "reach 3"])
        self.assertEqual([round(float(trial["onset"]) * 1e9) for trial in trials],
                         [markers_ns[0], markers_ns[2], markers_ns[4]])
        self.assertEqual(round(float(trials[0]["duration"]) * 1e9), markers_ns[1] - markers_ns[0])
        self.assertEqual(trials[2]["duration"], "n/a")
        self.assertEqual(json.loads(trials[0]["metadata"]), {"target_rad": "0.5"})
        self.assertEqual((trials[0]["end_label"], json.loads(trials[0]["end_metadata"])), ("hit", {"score": "10"}))
        kinds = [event["trial_type"] for event in events]
        self.assertEqual({kind: kinds.count(kind) for kind in ("cue", "marker", "fault", "mass_refused", "trial_end")},
                         {"cue": 1, "marker": 1, "fault": 1, "mass_refused": 1, "trial_end": 0})
        # Gaps lie where the rows of n/a are.
        missing = {number for number, row in enumerate(rows_of(self.recording())) if row[0] == "n/a"}
        told = set()
        for gap in (event for event in events if event["trial_type"] == "gap"):
            begin = round(float(gap["onset"]) * 1000)
            told |= set(range(begin, begin + round(float(gap["duration"]) * 1000)))
        self.assertEqual(told, missing)
        self.assertGreater(len(told), 20)

    def test_bids_sessions_are_merged_into_one_dataset(self):
        sessions = []
        for number, labels in enumerate([("01", "1", 2), ("01", "1", 3), ("01", "2", 1), ("02", "1", 1)]):
            session = self.folder / f"s{number}.sqlite"
            subject, visit, run = labels
            write_session(session, "--subject", subject, "--visit", visit, "--run", run, "--seed", number)
            sessions.append(session)
        self.export("bids", sessions[0])
        # What a study adds is kept.
        description = self.out / "dataset_description.json"
        text = json.loads(description.read_text()) | {"Authors": ["A. Author"], "License": "CC0"}
        description.write_text(json.dumps(text))
        (self.out / "participants.tsv").write_text("participant_id\tage\nsub-01\t31\n")
        (self.out / "README").write_text("A study of reaches with a virtual mass. " * 5)
        before = self.recording().read_bytes()
        self.export("bids", *sessions[1:])
        self.assertEqual(problems_of(self.out), [])
        errors, warnings = validate(self.out)
        self.assertEqual(errors, [])
        self.assertNotIn("NO_AUTHORS", warnings)
        self.assertEqual(self.recording().read_bytes(), before)
        text = json.loads(description.read_text())
        self.assertEqual((text["Authors"], text["License"]), (["A. Author"], "CC0"))
        self.assertEqual(len(text["GeneratedBy"]), 1)
        self.assertEqual(table(self.out / "participants.tsv")[1],
                         [{"participant_id": "sub-01", "age": "31"}, {"participant_id": "sub-02", "age": "n/a"}])
        self.assertEqual(len(table(self.out / "sub-01" / "ses-1" / "sub-01_ses-1_scans.tsv")[1]), 2)
        self.assertTrue((self.out / "README").read_text().startswith("A study"))

    def test_exports_into_one_dataset_at_the_same_time_all_arrive(self):
        sessions = [self.folder / f"s{run}.sqlite" for run in range(1, 7)]
        for run, session in enumerate(sessions, 1):
            write_session(session, "--run", run, "--seed", run)
        with concurrent.futures.ThreadPoolExecutor(len(sessions)) as pool:
            for result in pool.map(lambda session: self.export("bids", session), sessions):
                self.assertEqual(result.stderr, "")
        self.assertEqual(problems_of(self.out), [])
        self.assertEqual(len(table(self.out / "sub-01" / "ses-1" / "sub-01_ses-1_scans.tsv")[1]), len(sessions))

    def test_sessions_without_a_visit_lie_directly_below_the_subject(self):
        write_session(self.session, "--visit", "")
        self.export("bids")
        self.assertTrue(self.recording(visit="").exists())
        self.assertEqual(problems_of(self.out), [])
        self.assertEqual(validate(self.out)[0], [])

    def test_labels_that_bids_cannot_name_are_refused_with_a_way_out(self):
        write_session(self.session, "--task", "reach_fast")
        result = self.export("bids", code=1)
        self.assertIn('its task "reach_fast" is no BIDS label', result.stderr)
        self.assertIn("csv or hdf5", result.stderr)
        self.assertFalse(self.out.exists())

    def test_a_session_whose_server_died_is_exported_with_what_is_there(self):
        samples = write_session(self.session, "--killed")
        for state in ("open", "recovered"):
            with self.subTest(state):
                self.export("csv")
                self.check_csv(samples, ROTARY_UNITS)
                self.assertEqual(json.loads((self.out / "one" / "session.json").read_text())["state"], state)
                self.export("bids")
                self.assertEqual(problems_of(self.out), [])
                self.check_motion(samples, 180.0 / math.pi)
                shutil.rmtree(self.out)
                self.assertEqual(mwidth("session", "recover", self.session).returncode, 0)

    # The checker

    def test_the_checker_finds_what_the_validator_misses(self):
        write_session(self.session)
        self.export("bids")
        # It is optional, and the validator would tell that its table is missing.
        self.recording(suffix="channels.json").unlink()
        channels = self.recording(suffix="channels.tsv")
        events = self.recording(suffix="events.tsv")
        lines = self.recording().read_text().splitlines()
        head, *rows = channels.read_text().splitlines()
        sidecar = json.loads(self.recording(suffix="motion.json").read_text())
        scans = self.out / "sub-01" / "ses-1" / "sub-01_ses-1_scans.tsv"
        event_head, *event_rows = events.read_text().splitlines()
        damages = {
            "channels.tsv is missing": (channels, None, "No such file"),
            "motion.json is missing": (self.recording(suffix="motion.json"), None, "No such file"),
            "a channel too few": (channels, [head, *rows[:-1]], "19 columns, there are 18 channels"),
            "columns too few": (self.recording(), [line.rsplit("\t", 1)[0] for line in lines], "18 columns"),
            "a row too few": (self.recording(), lines[:-1], "are not"),
            "columns in another order": (channels, ["\t".join([*line.split("\t")[1::-1], *line.split("\t")[2:]])
                                                    for line in [head, *rows]], "begins with"),
            "a joint angle in rad": (channels, [head, *(row.replace("\tdeg\t", "\trad\t") for row in rows)], "not in deg"),
            "another duration": (self.recording(suffix="motion.json"),
                                 [json.dumps(sidecar | {"RecordingDuration": 1.0})], "are not"),
            "events out of order": (events, [event_head, *event_rows[::-1]], "not in order"),
            "scans without the recording": (scans, scans.read_text().splitlines()[:1], "0 times"),
        }
        missed = []
        for name, (file, content, problem) in damages.items():
            with self.subTest(name):
                original = file.read_bytes()
                if content is None:
                    file.unlink()
                else:
                    file.write_text("\n".join(content) + "\n")
                self.assertIn(problem, "\n".join(problems_of(self.out)))
                if not validate(self.out)[0]:
                    missed.append(name)
                file.write_bytes(original)
        self.assertEqual(problems_of(self.out), [])
        # Why there is a checker.
        self.assertIn("channels.tsv is missing", missed)
        self.assertIn("columns too few", missed)

    # Damage, and what is there already

    def test_a_damaged_block_is_left_out_and_told_and_the_rest_is_exported(self):
        samples = write_session(self.session)
        first, last = flip_a_bit(self.session, 2)
        kept = samples[(samples["tick"] < first) | (samples["tick"] > last)]
        self.assertLess(len(kept), len(samples))
        self.assertGreater(len(kept), 0)

        self.assertIn(f"block 2, ticks {first} to {last}", self.export("csv", code=1).stderr)
        self.check_csv(kept, ROTARY_UNITS)
        gaps = [gap for gap in self.csv_rows("gaps.csv") if "block 2 is damaged" in gap["reason"]]
        self.assertEqual([(int(gap["after_tick"]) < first, int(gap["before_tick"]) > last) for gap in gaps], [(True, True)])
        session = json.loads((self.out / "one" / "session.json").read_text())
        self.assertEqual([(b["block"], b["first_tick"], b["last_tick"]) for b in session["damaged_blocks"]], [(2, first, last)])
        self.assertEqual(session["exported_samples"], len(kept))

        self.export("hdf5", code=1)
        self.check_hdf5(kept)
        with h5py.File(self.out / "one.h5") as file:
            self.assertEqual(list(file["damaged_blocks/number"]), [2])

        shutil.rmtree(self.out)
        self.export("bids", code=1)
        self.check_motion(kept, 180.0 / math.pi)
        self.assertEqual(problems_of(self.out), [])
        self.assertIn("block 2 is damaged", self.recording(suffix="events.tsv").read_text())

    def test_nothing_is_replaced_without_force(self):
        write_session(self.session)
        for form in ("csv", "hdf5", "bids"):
            with self.subTest(form):
                self.export(form)
                before = {path: path.read_bytes() for path in self.out.rglob("*") if path.is_file()}
                result = self.export(form, code=1)
                self.assertIn("exists already; --force replaces it", result.stderr)
                after = {path: path.read_bytes() for path in self.out.rglob("*") if path.is_file()}
                self.assertEqual(after, before)
                self.export(form, options=["--force"])
                shutil.rmtree(self.out)

    def test_a_full_disk_leaves_nothing_half_written(self):
        write_session(self.session)
        for form in ("csv", "hdf5", "bids"):
            with self.subTest(form):
                # Files of at most 256 KiB: what a disk without room does to each of them.
                result = mwidth("session", "export", self.session, "--to", self.out, "--format", form,
                                preexec_fn=lambda: limit_files(256 * 1024))
                self.assertEqual(result.returncode, 3, result.stdout + result.stderr)
                self.assertIn("cannot write", result.stderr)
                self.assertFalse(self.out.exists())


def limit_files(size):
    """Writes beyond `size` fail with EFBIG."""
    import resource
    import signal

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


if __name__ == "__main__":
    unittest.main()
