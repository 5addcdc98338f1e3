#!/usr/bin/python3
"""A small study: the same reach with no virtual mass, a positive and a negative one, and a mass that is refused.

The simulated hand of mwidthd reaches for 30 degrees (--config elbow), back, and again. This program renders each mass
over gRPC, records some reaches, and compares what was commanded with what the hand could feel.

After a build: build/release/python/reach_study.py --server HOST:PORT --output FOLDER
"""

import argparse
import contextlib
import csv
import dataclasses
import math
import pathlib
import sys
import textwrap

import matplotlib

matplotlib.use("Agg")  # draws into files; needs no display
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

import mwidth  # noqa: E402
from mwidth import reaches as analysis  # noqa: E402
from mwidth.v1 import rendering_pb2  # noqa: E402

# The task of --config elbow.
START_RAD = 0.0
TARGET_RAD = math.radians(30)
BEFORE_S = 0.2  # of each reach shown and analysed, before and after its onset
AFTER_S = 1.6
RAMP_S = 0.2
PATIENCE_S = 60
COLORS = {"none": "#444444", "positive": "#0072B2", "negative": "#D55E00"}  # told apart by colour-blind readers too


class StudyError(Exception):
    """The study could not be made as intended; the message says why."""


@dataclasses.dataclass(frozen=True)
class Trial:
    """Reaches under one virtual mass."""

    name: str
    mass: float
    gain_margin_db: float
    reaches: list
    missing_ticks: int


def choose_masses(axis):
    """The three masses to render, and one to be refused: fractions of what the server admits."""
    admitted = axis.m_width.admitted
    nominal = axis.m_width.nominal
    if admitted.empty:
        raise StudyError(f"no mass is admitted: {admitted.empty_reason}")
    device_mass = axis.info.loop.device_mass
    # A positive mass could be many times the device's. Half of that is felt, and swings out between reaches.
    positive = min(0.5 * admitted.max, axis.info.mass_max, 0.5 * device_mass)
    negative = max(0.75 * admitted.min, axis.info.mass_min, -0.75 * device_mass)
    for unstable in (1.5 * nominal.max, 1.5 * nominal.min):
        if axis.info.mass_min <= unstable <= axis.info.mass_max:
            return {"none": 0.0, "positive": positive, "negative": negative}, unstable
    raise StudyError("the configured limits of the mass lie inside the M-width: no unstable mass can be asked for")


def find_in(segments, period_s):
    """The complete reaches in lists of batches without a long gap inside."""
    found = []
    for batches in segments:
        # The filter's window is shorter than this, and a reach is longer.
        if sum(len(batch) for batch in batches) * period_s > BEFORE_S + AFTER_S:
            moved = analysis.motion(mwidth.concatenate(batches), period_s)
            found += analysis.find_reaches(moved, START_RAD, TARGET_RAD, BEFORE_S, AFTER_S)
    return found


def record(client, mass, period_s, count):
    """`count` complete reaches under a mass that no longer ramps, and the number of ticks without a sample."""
    segments = [[]]
    recorded_s = 0
    with client.stream() as stream:
        for batch in stream:
            if not np.all(batch.state == rendering_pb2.STATE_RENDERING):
                fault = client.axis().fault
                raise StudyError(f"the server stopped rendering: {fault.message}" if fault.message else
                                 "the server stopped rendering")
            if not np.all(batch.mass == mass):
                continue
            if (batch.missed_ticks_before + batch.dropped_ticks_before) * period_s > analysis.MAX_GAP_S:
                segments.append([])
            segments[-1].append(batch)
            recorded_s += len(batch) * period_s
            # Looking for reaches costs more than receiving them: once a second is enough.
            if math.floor(recorded_s) > math.floor(recorded_s - len(batch) * period_s):
                found = find_in(segments, period_s)
                if len(found) >= count:
                    return found[:count], stream.missed_ticks + stream.dropped_ticks
            if recorded_s > PATIENCE_S:
                raise StudyError(f"no {count} complete reaches in {PATIENCE_S} s: does the hand move, undisturbed?")


def run_trials(client, control, session, masses, axis, count):
    trials = []
    for name, mass in masses.items():
        print(f"  {count} reaches with a virtual mass of {mass:+.4g} kg m² ...", flush=True)
        answer = control.set_mass(mass, ramp_s=RAMP_S)
        with trial_of(session, name):
            found, missing = record(client, mass, axis.info.loop.period_s, count)
        trials.append(Trial(name, mass, answer.stability.gain_margin_db, found, missing))
    return trials


def session_of(client, subject):
    """The session that the server records, or None without a subject; for a with statement."""
    return client.session(subject=subject, task="reach") if subject else contextlib.nullcontext()


def trial_of(session, name):
    if session is None:
        return contextlib.nullcontext()
    return session.trial(name, start_deg=math.degrees(START_RAD), target_deg=round(math.degrees(TARGET_RAD), 6))


def ask_for_unstable(client, control, unstable):
    """The refusal; raises where the mass is not refused or the rendered mass changes."""
    before = client.axis().target_mass
    try:
        control.set_mass(unstable)
    except mwidth.Refused as refusal:
        if client.axis().target_mass != before:
            raise StudyError("a refused request changed the rendered mass") from refusal
        return refusal
    raise StudyError(f"a mass of {unstable:g} kg m² was not refused")


def table(trials, axis):
    device_mass, device_damping = axis.info.loop.device_mass, axis.info.loop.device_damping
    rows = [f"{'virtual mass':>13} {'device + virtual':>17} {'perceived mass':>15} {'error':>8} "
            f"{'overshoot':>10} {'gain margin':>12}",
            f"{'M, kg m²':>13} {'m + M, kg m²':>17} {'kg m²':>15} {'':>8} {'of 30 deg':>10} {'dB':>12}"]
    for trial in trials:
        perceived = analysis.perceived_mass(trial.reaches, device_mass, device_damping)
        error = analysis.perceived_mass_error(perceived, device_mass, trial.mass)
        rows.append(
            f"{trial.mass:>+13.5f} {device_mass + trial.mass:>17.5f} {perceived:>15.5f} {100 * error:>+7.1f}% "
            f"{100 * analysis.overshoot(trial.reaches, START_RAD, TARGET_RAD):>9.1f}% {trial.gain_margin_db:>12.1f}"
        )
    missing = sum(trial.missing_ticks for trial in trials)
    if missing > 0:
        rows.append(f"{missing} ticks had no sample; gaps up to {1e3 * analysis.MAX_GAP_S:g} ms are interpolated.")
    return "\n".join(rows)


def describe(refusal):
    asked = f"A virtual mass of {refusal.stability.requested_mass:+.4g} kg m² was refused ({refusal.reason}):"
    words = textwrap.fill(str(refusal), width=100, initial_indent="  ", subsequent_indent="  ")
    return f"{asked}\n{words}\nThe rendered mass was checked: it stayed as it was."


def write_csv(path, trials):
    with path.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["mass_kg_m2", "reach", "time_s", "position_rad", "velocity_rad_per_s",
                       "acceleration_rad_per_s2", "force_n_m"])
        for trial in trials:
            for number, reach in enumerate(trial.reaches, start=1):
                columns = (reach.time_s, reach.position, reach.velocity, reach.acceleration, reach.force)
                for sample in zip(*columns):
                    rows.writerow([repr(trial.mass), number, *(repr(float(value)) for value in sample)])


def draw(path, trials):
    figure, (positions, forces) = plt.subplots(2, 1, figsize=(7.5, 7), sharex=True, height_ratios=(2, 1))
    for trial in trials:
        for number, reach in enumerate(trial.reaches):
            label = f"M = {trial.mass:+.3g} kg m²" if trial.name != "none" else "no virtual mass"
            style = {"color": COLORS[trial.name], "lw": 1.5, "alpha": 0.8, "label": label if number == 0 else None}
            positions.plot(reach.time_s, np.degrees(reach.position), **style)
            forces.plot(reach.time_s, reach.force, **style)
    positions.axhline(math.degrees(TARGET_RAD), color="black", lw=1, ls="--", zorder=0, label="target")
    positions.set_ylabel("elbow angle (degrees)")
    positions.set_title("The same reach under three virtual masses")
    positions.legend(loc="lower right", frameon=False)
    forces.axhline(0, color="black", lw=0.5, zorder=0)
    forces.set_ylabel("rendered force $F_a$ (N m)")
    forces.set_xlabel("time from movement onset (s)")
    for axes in (positions, forces):
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(alpha=0.25)
    forces.set_xlim(-BEFORE_S, AFTER_S)
    figure.align_ylabels()
    figure.tight_layout()
    figure.savefig(path, dpi=150)
    plt.close(figure)


def run(address, output, count, with_motor, subject):
    with mwidth.Client(address) as client:
        axis = client.axis()
        if axis.info.kind != rendering_pb2.AXIS_KIND_ROTARY:
            raise StudyError("this study needs a rotary joint: start mwidthd with --config elbow")
        if not (axis.info.simulated or with_motor):
            raise StudyError("a motor would move: give --with-motor if that is meant")
        masses, unstable = choose_masses(axis)
        with session_of(client, subject) as session, client.control("reach study") as control:
            control.start_rendering()
            trials = run_trials(client, control, session, masses, axis, count)
            refusal = ask_for_unstable(client, control, unstable)
            control.stop_rendering()
    print(f"\n{table(trials, axis)}\n\n{describe(refusal)}\n")
    output.mkdir(parents=True, exist_ok=True)
    write_csv(output / "reaches.csv", trials)
    draw(output / "reaches.png", trials)
    print(f"Picture: {output / 'reaches.png'}\nData:    {output / 'reaches.csv'}")
    if session is not None:
        print(f"Session: {session.session_id}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--server", default="127.0.0.1:50051", metavar="HOST:PORT")
    parser.add_argument("--output", default="demo-output", type=pathlib.Path, metavar="FOLDER")
    parser.add_argument("--reaches", default=2, type=int, metavar="N", help="reaches under each mass")
    parser.add_argument("--with-motor", action="store_true", help="run it although the drive is no simulation")
    parser.add_argument("--subject", metavar="LABEL", help="let the server record it as a session of this subject")
    arguments = parser.parse_args()
    try:
        run(arguments.server, arguments.output, arguments.reaches, arguments.with_motor, arguments.subject)
    except (StudyError, mwidth.Error) as error:
        sys.exit(f"reach study: {error}")
    except KeyboardInterrupt:
        sys.exit(130)  # what a shell expects after Ctrl-C; control was released on the way here


if __name__ == "__main__":
    main()
