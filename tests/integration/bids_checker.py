"""Checks a Motion-BIDS dataset against the standard, written from its text and from nothing of the exporter.

Covers what the legacy bids-validator misses: a recording without channels.tsv or motion.json, columns that are not as
many as the channels, units, a grid that does not fit its duration, events out of order, recordings that scans.tsv does not
list. `python3 bids_checker.py FOLDER` prints what is wrong.
"""

import json
import pathlib
import re
import sys

NAME = re.compile(
    r"sub-[a-zA-Z0-9]+(_ses-[a-zA-Z0-9]+)?_task-(?P<task>[a-zA-Z0-9]+)_tracksys-(?P<tracksys>[a-zA-Z0-9]+)"
    r"(_acq-[a-zA-Z0-9]+)?(_run-[0-9]+)?_motion\.tsv")
REQUIRED_COLUMNS = ["name", "component", "type", "tracked_point", "units"]
COMPONENTS = {"x", "y", "z", "quat_x", "quat_y", "quat_z", "quat_w", "n/a"}
TYPES = {"ACCEL", "ANGACCEL", "GYRO", "JNTANG", "LATENCY", "MAGN", "MISC", "ORNT", "POS", "VEL"}
# Types that have a component for the axis.
SPATIAL = {"ACCEL", "ANGACCEL", "GYRO", "MAGN", "ORNT", "POS", "VEL"}
NUMBER = re.compile(r"-?[0-9]+(\.[0-9]+)?([eE][-+]?[0-9]+)?")
LATENCY = re.compile(r"[0-9]+(\.[0-9]{6})?")
TIME = re.compile(r"[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9]{2}:[0-9]{2}:[0-9]{2}(\.[0-9]{1,6})?Z?")


def cells(line):
    """The standard has tabs, and quotes only around cells that begin with one."""
    return [cell[1:-1].replace('""', '"') if cell.startswith('"') else cell for cell in line.split("\t")]


def rows_of(path):
    text = path.read_text(encoding="utf-8")
    if not text.endswith("\n"):
        raise ValueError("does not end with a line break")
    return [cells(line) for line in text[:-1].split("\n")]


def table(path):
    """A table with a head as a list of dictionaries."""
    head, *rows = rows_of(path)
    if len(set(head)) != len(head) or not all(head):
        raise ValueError(f"columns twice or without a name: {head}")
    for number, row in enumerate(rows, 2):
        if len(row) != len(head) or not all(row):
            raise ValueError(f"line {number} has {len(row)} cells, or empty ones; the head has {len(head)}")
    return head, [dict(zip(head, row)) for row in rows]


class Checker:
    def __init__(self, dataset):
        self.dataset = pathlib.Path(dataset)
        self.problems = []

    def expect(self, good, path, text):
        if not good:
            self.problems.append(f"{path.relative_to(self.dataset)}: {text}")
        return good

    def read(self, reader, path):
        """What `reader` makes of the file, or None and a problem."""
        try:
            return reader(path)
        except (OSError, ValueError) as error:
            self.expect(False, path, str(error))
            return None

    def run(self):
        description = self.read(lambda path: json.loads(path.read_text()), self.dataset / "dataset_description.json")
        if description is not None:
            for key in ("Name", "BIDSVersion"):
                self.expect(isinstance(description.get(key), str), self.dataset / "dataset_description.json", f"no {key}")
        self.expect(any(self.dataset.glob("README*")), self.dataset / "README", "is missing")
        recordings = sorted(self.dataset.glob("sub-*/**/*_motion.tsv"))
        self.expect(recordings, self.dataset / "sub-", "no recording")
        for recording in recordings:
            self.check_recording(recording)
        self.check_participants({recording.relative_to(self.dataset).parts[0] for recording in recordings})
        return self.problems

    def check_participants(self, subjects):
        path = self.dataset / "participants.tsv"
        participants = self.read(table, path)
        if participants is not None:
            head, rows = participants
            self.expect(head[0] == "participant_id", path, "participant_id is not the first column")
            listed = [row.get("participant_id") for row in rows]
            self.expect(sorted(listed) == sorted(subjects), path, f"lists {listed}, there are {sorted(subjects)}")

    def check_recording(self, path):
        name = NAME.fullmatch(path.name)
        if not self.expect(name, path, "is no name of a recording"):
            return
        self.expect(path.parent.name == "motion" and path.name.startswith("_".join(path.parent.parent.relative_to(
            self.dataset).parts) + "_"), path, "is not in the folder of its name")
        channels = self.check_channels(path.with_name(path.name.replace("_motion.tsv", "_channels.tsv")))
        rows = self.check_rows(path, channels)
        self.check_sidecar(path.with_suffix(".json"), name, channels, rows)
        self.check_events(path.with_name(path.name.replace("_motion.tsv", "_events.tsv")))
        self.check_scans(path)

    def check_channels(self, path):
        channels = self.read(table, path)
        if channels is None:
            return None
        head, rows = channels
        self.expect(head[:5] == REQUIRED_COLUMNS, path, f"begins with {head[:5]}")
        names = [row.get("name") for row in rows]
        self.expect(len(set(names)) == len(names), path, "has a name twice")
        for row in rows:
            component, kind = row.get("component"), row.get("type")
            self.expect(component in COMPONENTS, path, f"{component} is no component")
            if self.expect(kind in TYPES, path, f"{kind} is no type"):
                self.expect((component == "n/a") == (kind not in SPATIAL), path, f"a {kind} with component {component}")
            self.expect(kind != "JNTANG" or row.get("units") == "deg", path, "a joint angle not in deg")
        return rows

    def check_rows(self, path, channels):
        """Number of rows."""
        rows = self.read(rows_of, path)
        if rows is None:
            return None
        latencies = [i for i, c in enumerate(channels or []) if c.get("type") == "LATENCY"]
        last = -1.0
        for number, row in enumerate(rows, 1):
            if channels is not None and not self.expect(
                    len(row) == len(channels), path, f"line {number} has {len(row)} columns, there are {len(channels)} channels"):
                return len(rows)
            good = all(cell == "n/a" or NUMBER.fullmatch(cell) for cell in row)
            if not self.expect(good, path, f"line {number} has cells that are no numbers"):
                return len(rows)
            for i in latencies:
                if row[i] != "n/a":
                    good = LATENCY.fullmatch(row[i]) and float(row[i]) > last
                    last = float(row[i])
                    if not self.expect(good, path, f"line {number} has latency {row[i]}"):
                        return len(rows)
        return len(rows)

    def check_sidecar(self, path, name, channels, rows):
        sidecar = self.read(lambda file: json.loads(file.read_text()), path)
        if sidecar is None:
            return
        for key in ("TaskName", "SamplingFrequency", "TrackingSystemName"):
            self.expect(key in sidecar, path, f"no {key}")
        self.expect(re.sub("[^a-zA-Z0-9]", "", sidecar.get("TaskName", "")) == name["task"], path, "another task")
        self.expect(sidecar.get("TrackingSystemName") == name["tracksys"], path, "another tracking system")
        frequency = sidecar.get("SamplingFrequency", 0)
        if rows is not None and self.expect(frequency > 0, path, "no frequency"):
            duration = sidecar.get("RecordingDuration", 0)
            self.expect(abs(duration * frequency - rows) < 0.5, path,
                        f"{duration} s at {frequency} Hz are not {rows} rows")
        if channels is not None:
            self.expect(sidecar.get("MotionChannelCount") == len(channels), path, "another number of channels")
            for kind in TYPES:
                count = sum(channel.get("type") == kind for channel in channels)
                self.expect(sidecar.get(kind + "ChannelCount", count) == count, path, f"another number of {kind}")

    def check_events(self, path):
        if not path.exists():
            return
        events = self.read(table, path)
        if events is None:
            return
        head, rows = events
        self.expect(head[:2] == ["onset", "duration"], path, f"begins with {head[:2]}")
        onsets = [float(row["onset"]) for row in rows]
        self.expect(onsets == sorted(onsets), path, "is not in order")
        for row in rows:
            self.expect(row["duration"] == "n/a" or float(row["duration"]) >= 0, path, "a negative duration")
        sidecar = self.read(lambda file: json.loads(file.read_text()), path.with_suffix(".json"))
        if sidecar is not None:
            self.expect(set(head) <= set(sidecar), path, f"columns without a description: {set(head) - set(sidecar)}")

    def check_scans(self, path):
        folder = path.parent.parent
        scans = folder / ("_".join(folder.relative_to(self.dataset).parts) + "_scans.tsv")
        listed = self.read(table, scans)
        if listed is None:
            return
        rows = [row for row in listed[1] if row.get("filename") == f"motion/{path.name}"]
        if self.expect(len(rows) == 1, scans, f"lists {path.name} {len(rows)} times"):
            self.expect(TIME.fullmatch(rows[0].get("acq_time", "")), scans, f"acq_time {rows[0].get('acq_time')}")
        for row in listed[1]:
            self.expect((folder / row.get("filename", "")).is_file(), scans, f"lists {row.get('filename')}, which is not there")


def problems_of(dataset):
    """What is wrong with the dataset, one line each; empty where nothing is."""
    return Checker(dataset).run()


if __name__ == "__main__":
    found = problems_of(sys.argv[1])
    print("\n".join(found) or "nothing is wrong")
    sys.exit(1 if found else 0)
