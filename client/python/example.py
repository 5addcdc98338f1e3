#!/usr/bin/python3
"""Takes control of an axis, renders a mass, prints a second of samples and shows what a refusal looks like.

After a build: build/release/python/example.py [HOST:PORT]. Without it, MWIDTH_SERVER or 127.0.0.1:50051.
"""

import os
import sys

import mwidth


def run(address):
    with mwidth.Client(address) as client:
        admitted = client.m_width().m_width.admitted

        with client.control("example") as control:  # renewed in the background, released at the end of the block
            control.start_rendering()
            answer = control.set_mass(admitted.max / 2)
            print(f"rendering {answer.mass:g}, gain margin {answer.stability.gain_margin_db:.1f} dB")

            with client.stream(decimation=100, max_batch=1) as stream:
                first_ns = None
                for batch in stream:
                    first_ns = batch.monotonic_ns[0] if first_ns is None else first_ns
                    time_s = 1e-9 * (batch.monotonic_ns[0] - first_ns)
                    print(f"{time_s:6.3f} s  position {batch.position[0]:9.6f}  force {batch.force[0]:9.6f}")
                    if time_s >= 1:
                        break

            try:
                control.set_mass(admitted.max * 2)
            except mwidth.Refused as refusal:
                print(f"refused ({refusal.reason}): {refusal}")
                print(f"nearest admitted mass: {refusal.stability.nearest_admitted_mass:g}")
            control.stop_rendering()


if __name__ == "__main__":
    try:
        run(sys.argv[1] if len(sys.argv) > 1 else os.environ.get("MWIDTH_SERVER", "127.0.0.1:50051"))
    except mwidth.Error as error:
        sys.exit(str(error))
