"""Runs mwidth_bench and another program by turns, and says by what factor they differ."""

import argparse
import json
import pathlib
import statistics
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]


def arguments(description, rounds):
    """The options that all comparisons share."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument(
        "--bench", type=pathlib.Path, default=ROOT / "build/release/bin/mwidth_bench", help="the built mwidth_bench"
    )
    parser.add_argument("--rounds", type=int, default=rounds, help="turns of each side (default: %(default)s)")
    return parser


def run_bench(bench, names, min_time_s=0.1):
    """Runs the named benchmarks once, in one process; name -> Google Benchmark's record, with times in ns: cpu_ns of
    CPU, real_ns on the wall."""
    if not bench.exists():
        raise SystemExit(
            f"{bench} is missing. It is built where libbenchmark-dev is installed:\n"
            "  cmake --preset release && cmake --build --preset release --target mwidth_bench"
        )
    pattern = "^(" + "|".join(names) + ")$"
    command = [bench, f"--benchmark_filter={pattern}", f"--benchmark_min_time={min_time_s}", "--benchmark_format=json"]
    report = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    records = {}
    for record in report["benchmarks"]:
        if record.get("error_occurred"):
            raise SystemExit(f"{record['name']}: {record['error_message']}")
        scale = {"ns": 1, "us": 1e3, "ms": 1e6}[record["time_unit"]]
        times = {"cpu_ns": record["cpu_time"] * scale, "real_ns": record["real_time"] * scale}
        records[record["name"]] = {**record, **times}
    missing = set(names) - set(records)
    if missing:
        raise SystemExit(f"mwidth_bench has no {', '.join(sorted(missing))}")
    return records


def spread(values):
    """Median and quartiles, as text."""
    if len(values) < 3:
        return f"{statistics.median(values):.3g}"
    low, middle, high = statistics.quantiles(values, n=4)
    return f"{middle:.3g} ({low:.3g} to {high:.3g})"
