"""Reaching sessions over a link inside the virtual machine, and the same session in a simulation with the same delay."""

import csv
import dataclasses
import json
import pathlib
import sys
import tempfile
import types

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "integration"))
from server_process import ServerProcess, rendering  # noqa: E402

import mwidth  # noqa: E402
from mwidth import reaches  # noqa: E402

CONFIG = pathlib.Path(__file__).resolve().parents[2] / "deploy" / "config"
# The hand that moves an emulated drive by default, and the simulated one here: a reach, a rest, and back.
TARGET_RAD = np.radians(30)
HAND_MOTION = f"[axis.drive.hand_motion]\namplitude = {float(TARGET_RAD)!r}\nduration_s = 0.6\nhold_s = 0.9\n"
MASSES = (0.1042, -0.12)  # kg m^2; the joint has 0.2084
LENGTH_S = 5.0  # of the samples under one mass: a whole reach at least, whenever they begin

# Waits for what a program prints or writes, in the machine's time.
PRELUDE = """
fail() { echo "$1"; cat *.log; exit 1; }
await() { for i in $(seq 200); do grep -q "$1" $2 && return; sleep 0.05; done; fail "no '$1' in $2"; }
"""

SESSION = """
echo "== {name}"
mwidth-drive --config {name}.toml {drive_arguments} >{name}-drive.log 2>&1 & drive=$!
await 'listening on' {name}-drive.log
mwidthd --config {name}.toml --listen 127.0.0.1:50051 {server_arguments} >{name}-server.log 2>&1 & server=$!
await 'listening on' {name}-server.log
for mass in {masses}; do
  mwidth set-mass $mass --hold {hold_s} >>{name}.log 2>&1 & setting=$!
  sleep 0.7
  mwidth stream --csv {name}$mass.csv --seconds {length_s} >>{name}.log 2>&1 || fail "no samples"
  wait $setting || fail "the mass was not held"
done
mwidth state --json >{name}.json || fail "no state"
kill $server; wait $server || fail "the server did not end in order"
kill $drive; wait $drive || fail "the drive did not end in order"
"""


@dataclasses.dataclass(frozen=True)
class Link:
    """A configuration, where the emulated drive stands, and where the server looks for it."""

    name: str
    example: str
    replacements: tuple = ()
    drive_arguments: str = ""
    # $(address) is what the drive says that it listens on.
    server_arguments: str = ""
    # Periods that pass between a position and its force besides the time that the exchange takes.
    delay_periods: int = 0
    # What the link itself may cost.
    most_missed_ticks: int = 0

    def configuration(self):
        text = (CONFIG / self.example).read_text()
        for old, new in self.replacements:
            if old not in text:
                raise AssertionError(f"{self.example} has no '{old}'")
            text = text.replace(old, new, 1)
        return text

    def script(self):
        address = f"$(sed -n 's/^listening on //p' {self.name}-drive.log)"
        return SESSION.format(name=self.name, drive_arguments=self.drive_arguments, masses=" ".join(map(str, MASSES)),
                              server_arguments=self.server_arguments.replace("$(address)", address),
                              length_s=LENGTH_S, hold_s=LENGTH_S + 3)


def simulation(configuration, delay_s):
    """The same axis with a simulated drive, the same encoder, a motor of fine steps, and a delay."""
    loop, drive = configuration.split("[axis.drive]\n", 1)
    lines = [f"delay_s = {delay_s!r}" if line.startswith("delay_s") else line for line in loop.splitlines()]
    quanta = [line.split("=")[1] for line in drive.splitlines() if line.startswith("scale")]
    return "\n".join([*lines, '[axis.drive]', 'type = "simulated"', f"position_quantum = {quanta[0]}",
                      "force_quantum = 0.001", HAND_MOTION])


def read_csv(path):
    """What the analysis of reaches needs of `mwidth stream --csv`."""
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    if {row["state"] for row in rows} != {"rendering"}:
        raise AssertionError(f"{path.name} holds ticks that were not rendered")
    return types.SimpleNamespace(tick=np.array([row["tick"] for row in rows], dtype=np.uint64),
                                 position=np.array([row["position_rad"] for row in rows], dtype=float),
                                 force=np.array([row["force_n_m"] for row in rows], dtype=float))


def read_axis(path):
    return json.loads(path.read_text())["axes"][0]


def simulate(configuration, mass):
    """Samples of the session in lock step with a simulated clock, on this host."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "simulation.toml")
        path.write_text(configuration)
        with ServerProcess("--config", path, "--simulation-speed", 20) as server, mwidth.Client(server.address) as client:
            lease = server.acquire(ttl_s=60)  # of the simulated clock
            server.start(lease)
            server.set_mass(lease, mass)
            count = LENGTH_S / client.axis().info.loop.period_s
            batches = []
            for batch in client.stream():
                if np.all(batch.state != rendering.STATE_RENDERING):
                    raise AssertionError("the simulation ended")
                if np.all(batch.mass == mass):
                    batches.append(batch)
                if sum(map(len, batches)) >= count:
                    return mwidth.concatenate(batches)


def perceived_mass(samples, loop):
    """Over the complete reaches of the session; `loop` with device_mass, device_damping and period_s."""
    moved = reaches.motion(samples, loop["period_s"])
    found = reaches.find_reaches(moved, 0.0, TARGET_RAD, before_s=0.2, after_s=1.6)
    if not found:
        raise AssertionError("no complete reach")
    return reaches.perceived_mass(found, loop["device_mass"], loop["device_damping"])
