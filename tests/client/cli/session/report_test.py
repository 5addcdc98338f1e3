"""The report's numbers against numpy and the Python package's reaches, its HTML, and what a browser makes of it."""

import csv
import html.parser
import json
import math
import os
import pathlib
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import mwidth
from mwidth import reaches

MWIDTH = os.environ["MWIDTH_PROGRAM"]
WRITE_SESSION = os.environ["WRITE_SESSION_PROGRAM"]
NAME = "sub-01_task-reach_run-1"

PERIOD_S = 0.001
DEVICE_MASS, DEVICE_DAMPING = 0.2084, 0.1215
TARGET_RAD = math.radians(30)

VOID = {"meta", "link", "br"}  # of those that the page uses


class Page(html.parser.HTMLParser):
    """Tables by the id of their section, all attributes, and whether every element is closed."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.tables, self.attributes, self.elements, self.open = {}, [], [], []
        self.text, self.section, self.cell = [], None, None
        self.feed(text)
        self.close()
        assert not self.open, f"not closed: {self.open}"

    def handle_starttag(self, tag, attributes):
        self.elements.append(tag)
        self.attributes += [(tag, *attribute) for attribute in attributes]
        attributes = dict(attributes)
        if tag not in VOID:
            self.open.append(tag)
        if tag == "section":
            self.section = attributes["id"]
        if tag == "tr":
            self.tables.setdefault(self.section, []).append([])
        if tag in ("td", "th"):
            self.cell = []
        if tag == "br" and self.cell is not None:
            self.cell.append(" ")

    def handle_startendtag(self, tag, attributes):
        self.elements.append(tag)
        self.attributes += [(tag, *attribute) for attribute in attributes]

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, f"</{tag}> closes {self.open[-1:]}"
        self.open.pop()
        if tag in ("td", "th"):
            self.tables[self.section][-1].append("".join(self.cell).strip())
            self.cell = None

    def handle_data(self, data):
        if self.open[-1:] != ["style"]:
            self.text.append(data)
        if self.cell is not None:
            self.cell.append(data)


def number(text):
    """The first number of a cell, and half a unit of its last place."""
    shown = text.split()[0].rstrip("†‡*").replace("−", "-")
    places = len(shown.partition(".")[2])
    return float(shown), 0.5 * 10.0**-places


class SessionTest(unittest.TestCase):
    """Runs the command line in a folder with one session."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)

    def write(self, *options):
        subprocess.run([WRITE_SESSION, self.folder, *options], check=True)
        return self.folder / "samples.csv"

    def damage(self):
        with sqlite3.connect(self.folder / f"{NAME}.sqlite") as database:
            number, data = database.execute("SELECT number, data FROM blocks ORDER BY number LIMIT 1 OFFSET 2").fetchone()
            data = data[:100] + bytes([data[100] ^ 1]) + data[101:]
            database.execute("UPDATE blocks SET data = ? WHERE number = ?", (data, number))

    def run_mwidth(self, *arguments):
        return subprocess.run([MWIDTH, "session", *arguments], cwd=self.folder, capture_output=True, text=True,
                              env={**os.environ, "MWIDTH_SESSIONS": str(self.folder)}, check=False)


class ReportTest(SessionTest):
    def report(self, *options):
        samples = self.write(*options)
        result = self.run_mwidth("report", NAME, "--to", "report.html")
        self.assertEqual(result.returncode, 0, result.stderr)
        text = (self.folder / "report.html").read_text(encoding="utf-8")
        return text, samples

    def assert_shown(self, cell, value, what):
        shown, half_unit = number(cell)
        self.assertLessEqual(abs(shown - value), half_unit * 1.001 + 1e-9, f"{what}: {cell} is not {value}")

    def assert_peak_at(self, cell, velocity):
        """Of two samples that are equal but for rounding (here in the last of 12 digits) either may be the peak."""
        self.assertAlmostEqual(velocity[round(number(cell)[0] / PERIOD_S)] / velocity.max(), 1, places=10)

    def test_every_movement_is_what_the_python_package_makes_of_the_same_samples(self):
        text, samples = self.report()
        rows = Page(text).tables["movements"][1:]
        trials = marked_trials(samples)
        self.assertEqual(len(rows), len(trials))
        for row, trial in zip(rows, trials):
            moved = reaches.motion(trial, PERIOD_S)
            expected = figures_of(moved, trial.mass[0])
            for column, what in enumerate(
                ["mass", "start_deg", "target_deg", "overshoot", "end_error_deg", "movement_time_s", None,
                 "peak_velocity_deg_s", "peak_force", "rms_force", "perceived_mass", "error"], start=1
            ):
                if what is not None:
                    self.assert_shown(row[column], expected[what], f"{row[0]} {what}")
            self.assert_peak_at(row[7], moved.velocity[expected["slice"]])
            self.assertEqual(row[6].endswith("†"), not expected["came_to_rest"], row[0])

    def test_overshoot_and_onset_are_those_of_find_reaches(self):
        text, samples = self.report()
        rows = Page(text).tables["movements"][1:]
        for row, trial in zip(rows, marked_trials(samples)):
            moved = reaches.motion(trial, PERIOD_S)
            found = reaches.find_reaches(moved, 0, TARGET_RAD, before_s=0, after_s=0.9)
            self.assertEqual(len(found), 1)
            self.assert_shown(row[4], 100 * reaches.overshoot(found, 0, TARGET_RAD), "overshoot")
            self.assert_peak_at(row[7], found[0].velocity)

    def test_groups_have_mean_and_standard_deviation_of_their_movements(self):
        text, samples = self.report()
        rows = Page(text).tables["masses"][1:]
        by_mass = {}
        for trial in marked_trials(samples):
            figures = figures_of(reaches.motion(trial, PERIOD_S), trial.mass[0])
            by_mass.setdefault(float(trial.mass[0]), []).append(figures)
        self.assertEqual([number(row[0])[0] for row in rows], sorted(by_mass))
        for row, (mass, group) in zip(rows, sorted(by_mass.items())):
            self.assertEqual(row[1], str(len(group)))
            for column, what in ((2, "overshoot"), (3, "movement_time_s"), (5, "peak_force"), (7, "perceived_mass"),
                                 (8, "error")):
                values = [figures[what] for figures in group if what != "movement_time_s" or figures["came_to_rest"]]
                if not values:
                    self.assertEqual(row[column], "–")
                    continue
                self.assert_shown(row[column], np.mean(values), f"{mass}: mean {what}")
                self.assert_shown(row[column].partition("±")[2], np.std(values, ddof=1), f"{mass}: sd {what}")
            self.assert_shown(row[6], DEVICE_MASS + mass, "device + M")

    def test_an_expected_error_is_that_of_the_filter_on_the_smooth_motion(self):
        text, samples = self.report()
        rows = Page(text).tables["movements"][1:]
        for row, trial in zip(rows, marked_trials(samples)):
            moved = reaches.motion(trial, PERIOD_S)
            figures = figures_of(moved, trial.mass[0])
            smooth = reaches.filtered(moved.position, PERIOD_S)
            pole = math.exp(-2 * math.pi * 20 * PERIOD_S)
            difference = np.diff(smooth, 2, prepend=[smooth[0], smooth[0]]) / PERIOD_S**2
            estimate = np.zeros(len(smooth))
            for k in range(1, len(smooth)):
                estimate[k] = pole * estimate[k - 1] + (1 - pole) * difference[k]
            force = reaches.filtered(trial.mass[0] * estimate, PERIOD_S)
            part = moved[figures["slice"]]
            hand = DEVICE_MASS * part.acceleration + DEVICE_DAMPING * part.velocity + force[figures["slice"]]
            perceived = part.acceleration @ hand / (part.acceleration @ part.acceleration)
            self.assert_shown(row[13], 100 * reaches.perceived_mass_error(perceived, DEVICE_MASS, trial.mass[0]),
                              f"{row[0]} expected error")

    def test_without_markers_it_judges_the_times_under_one_mass(self):
        text, _ = self.report("--unmarked")
        rows = Page(text).tables["movements"][1:]
        self.assertEqual({row[1] for row in rows}, {"0", "0.1", "−0.04"})
        # To and fro: the same number each way, but for what a change of mass cuts off.
        ways = [number(row[8])[0] > 0 for row in rows]
        self.assertEqual(ways.count(True), 9)
        self.assertGreaterEqual(ways.count(False), 6)

    def test_it_needs_nothing_but_itself(self):
        text, _ = self.report()
        page = Page(text)
        self.assertNotIn("script", page.elements)
        for _, name, value in page.attributes:
            self.assertFalse(name.startswith("on"), name)
            if name in ("href", "src", "xlink:href"):
                self.assertRegex(value, r"^(#[a-z0-9-]+|data:,)$")
        self.assertNotIn("url(", text)
        self.assertNotIn("@import", text)
        ids = [value for _, name, value in page.attributes if name == "id"]
        self.assertEqual(len(ids), len(set(ids)))
        for _, name, value in page.attributes:
            if name == "href" and value.startswith("#"):
                self.assertIn(value[1:], ids)

    def test_foreign_text_stays_text(self):
        harmless = Page(self.report()[0])
        (self.folder / f"{NAME}.sqlite").unlink()
        text, _ = self.report("--hostile")
        page = Page(text)
        self.assertNotIn("script", page.elements)
        self.assertEqual(set(page.elements), set(harmless.elements))
        self.assertEqual({name for _, name, _ in page.attributes}, {name for _, name, _ in harmless.attributes})
        self.assertIn("<script>alert('x')</script>\"'&<img src=http://evil.example/x onerror=alert(1)>\ufffd",
                      "".join(page.text))

    def test_lost_samples_are_told(self):
        text, _ = self.report("--lossy")
        page = Page(text)
        self.assertIn("400 samples were lost", "".join(page.text))
        row = next(row for row in page.tables["overview"] if "lost in a test" in row)
        self.assertEqual(row, ["5000", "5401", "0", "400", "lost in a test"])
        self.assertIn("not judged: too many ticks in a row have no position", "".join(page.text))

    def test_margins_are_those_of_the_mass_in_force(self):
        text, _ = self.report()
        facts = {}
        for row in Page(text).tables["trials"]:
            facts.setdefault(row[0], []).append(row[1])
        self.assertEqual([cell.split()[0] for cell in facts["Mass that was admitted"]],
                         3 * ["0"] + 3 * ["0.1"] + 3 * ["−0.04"])
        self.assertEqual(facts["Commanded mass"][3], "0.1 kg m²; with the device 0.3084 kg m²")
        self.assertRegex(facts["Margins to instability"][0], r"^gain ∞, ")
        self.assertRegex(facts["Margins to instability"][8],
                         r"^gain 15\.5 dB, phase ∞, delay [0-9.]+ ms, modulus 0\.[0-9]+$")
        self.assertEqual(set(facts["Admitted masses then"]), {"−0.1696 to 3.328 kg m²"})

    def test_refusals_are_told(self):
        text, _ = self.report()
        page = Page(text)
        self.assertIn("3 mass requests admitted, 1 refused.", "".join(page.text))
        self.assertIn(["36.000", "mass refused", "A virtual mass of -0.5 kg m^2 would make the loop unstable."],
                      page.tables["log"])

    def test_a_session_that_nobody_ended_is_told(self):
        text, _ = self.report("--open")
        self.assertIn("The session has not been ended", "".join(Page(text).text))

    def test_a_damaged_block_is_told_and_the_rest_reported(self):
        self.write()
        self.damage()
        result = self.run_mwidth("report", NAME, "--to", "report.html")
        self.assertEqual(result.returncode, 1)
        self.assertIn("cannot be trusted", result.stderr)
        page = Page((self.folder / "report.html").read_text(encoding="utf-8"))
        self.assertIn("1 block of the file cannot be trusted", "".join(page.text))
        self.assertEqual(len(page.tables["movements"]), 1 + 8)  # One trial lies in its 4096 samples.

    def test_a_page_that_cannot_be_written_leaves_nothing(self):
        self.write()
        result = self.run_mwidth("report", NAME, "--to", "no/such/folder/report.html")
        self.assertEqual(result.returncode, 3)
        self.assertIn("cannot write no/such/folder/report.html", result.stderr)

    def test_a_browser_shows_it_without_a_word_on_its_console(self):
        self.report("--hostile")
        with tempfile.TemporaryDirectory() as profile:
            result = subprocess.run(
                ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--log-level=0",
                 f"--user-data-dir={profile}", "--host-resolver-rules=MAP * ~NOTFOUND", "--disable-background-networking",
                 "--dump-dom", (self.folder / "report.html").as_uri()],
                capture_output=True, text=True, timeout=120, check=True)
        self.assertNotIn(":CONSOLE", result.stderr)
        dom = Page(result.stdout)
        # The browser found the same elements: nothing had to be mended.
        self.assertEqual(dom.elements, Page((self.folder / "report.html").read_text(encoding="utf-8")).elements)

    def test_a_browsers_console_would_be_seen(self):
        broken = self.folder / "broken.html"
        broken.write_text("<!DOCTYPE html><title>x</title><script>console.error('seen')</script>")
        with tempfile.TemporaryDirectory() as profile:
            result = subprocess.run(
                ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--log-level=0",
                 f"--user-data-dir={profile}", "--dump-dom", broken.as_uri()],
                capture_output=True, text=True, timeout=120, check=True)
        self.assertIn(":CONSOLE", result.stderr)


class ReplayTest(SessionTest):
    """`mwidth session replay`, on the same sessions."""

    def test_a_recorded_session_is_proved(self):
        self.write()
        result = self.run_mwidth("replay", NAME)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn("35999 of 36000 samples computed again from their counts", result.stdout)

    def test_an_altered_force_is_named(self):
        self.write("--altered")
        result = self.run_mwidth("replay", NAME)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("1 of 36000 samples DIFFER", result.stdout)
        self.assertIn("tick 20001: force_counts recorded", result.stdout)

    def test_a_loss_begins_anew(self):
        self.write("--lossy")
        result = self.run_mwidth("replay", NAME)
        self.assertEqual(result.returncode, 0, result.stdout)
        self.assertIn("35598 of 35600 samples", result.stdout)

    def test_a_damaged_block_proves_nothing(self):
        self.write()
        self.damage()
        result = self.run_mwidth("replay", NAME)
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertIn("1 blocks of the file cannot be trusted", result.stdout)

    def test_json_has_every_figure(self):
        self.write("--altered")
        result = subprocess.run([MWIDTH, "--json", "session", "--folder", self.folder, "replay", NAME],
                                capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, 1)
        (told,) = json.loads(result.stdout)
        self.assertEqual((told["session"], told["equal"], told["samples"], told["compared"], told["different"]),
                         (NAME, False, 36000, 35999, 1))
        self.assertEqual([difference["column"] for difference in told["first_differences"]],
                         ["force_counts", "force"])


def marked_trials(samples):
    """A SampleBatch for each trial: from 0.7 s on, every 4 s, 2.2 s long (reach_session.h)."""
    columns = np.genfromtxt(samples, delimiter=",", names=True)
    zero = np.zeros(len(columns))
    whole = {"tick": columns["tick"].astype(np.uint64), "monotonic_ns": 1_000_000 * columns["tick"].astype(np.int64),
             "position": columns["position"], "force": columns["force"], "mass": columns["mass"]}
    trials = []
    for start in range(700, len(columns), 4000):
        # A marker is at the last sample before it.
        part = slice(start - 1, start - 1 + 2200)
        trials.append(mwidth.SampleBatch(**{name: column[part] for name, column in whole.items()},
                                         **{name: zero[part] for name in (
                                             "velocity", "acceleration", "state", "saturated", "position_counts",
                                             "force_counts", "acceleration_counts")}))
    return trials


def figures_of(moved, mass):
    """Everything in a row of the report, from its definitions."""
    threshold = 0.05 * moved.velocity.max()
    middle = np.argmax(moved.position > TARGET_RAD / 2)
    onset = np.flatnonzero(moved.velocity[:middle] < threshold)[-1]
    slow = np.abs(moved.velocity) < threshold
    rests = [k for k in range(middle, len(slow) - 99) if slow[k:k + 100].all()]
    end = rests[0] if rests else len(slow) - 1
    settled = end + 99 if rests else end
    part = moved[onset:end + 1]
    perceived = reaches.perceived_mass([part], DEVICE_MASS, DEVICE_DAMPING)
    return {
        "mass": mass,
        "start_deg": 0.0,
        "target_deg": 30.0,
        "overshoot": 100 * (moved.position[onset:settled + 1].max() - TARGET_RAD) / TARGET_RAD,
        "end_error_deg": math.degrees(moved.position[settled] - TARGET_RAD),
        "movement_time_s": (end - onset) * PERIOD_S,
        "peak_velocity_deg_s": math.degrees(part.velocity.max()),
        "peak_force": np.abs(part.force).max(),
        "rms_force": math.sqrt(np.mean(part.force**2)),
        "perceived_mass": perceived,
        "error": 100 * reaches.perceived_mass_error(perceived, DEVICE_MASS, mass),
        "came_to_rest": bool(rests),
        "slice": slice(onset, end + 1),
    }


if __name__ == "__main__":
    sys.exit(unittest.main())
