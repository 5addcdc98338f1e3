"""Python client of mwidthd, the server that renders virtual mass.

    import mwidth

    client = mwidth.Client("127.0.0.1:50051")
    with client.control("my study") as control:
        control.start_rendering()
        control.set_mass(0.1)
        for batch in client.stream():
            ...  # batch.position, batch.force: numpy arrays
"""

from mwidth.analyses import Sweep, sweep_range
from mwidth.client import Client
from mwidth.control import Control
from mwidth.failure import Error, LeaseLost, Refused
from mwidth.samples import SampleBatch, SampleStream, concatenate

__all__ = [
    "Client",
    "Control",
    "Error",
    "LeaseLost",
    "Refused",
    "SampleBatch",
    "SampleStream",
    "Sweep",
    "concatenate",
    "sweep_range",
]
