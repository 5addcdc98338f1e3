"""Python client of mwidthd, the server that renders virtual mass.

    import mwidth

    client = mwidth.Client("127.0.0.1:50051")
    with client.control("my study") as control:
        control.start_rendering()
        control.set_mass(0.1)
        for batch in client.stream():
            ...  # batch.position, batch.force: numpy arrays

    with client.session(subject="sub-01", task="reach") as session:  # recorded in one file of the server's
        with session.trial("reach 1", target_rad=0.5):
            ...
"""

from mwidth.analyses import Sweep, sweep_range
from mwidth.client import Client
from mwidth.clock import ClockOffset
from mwidth.control import Control
from mwidth.events import EventStream
from mwidth.failure import Error, LeaseLost, Refused
from mwidth.samples import SampleBatch, SampleStream, concatenate
from mwidth.session import Session
from mwidth.stored import StoredSession

__all__ = [
    "Client",
    "ClockOffset",
    "Control",
    "Error",
    "EventStream",
    "LeaseLost",
    "Refused",
    "SampleBatch",
    "SampleStream",
    "Session",
    "StoredSession",
    "Sweep",
    "concatenate",
    "sweep_range",
]
