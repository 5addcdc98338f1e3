"""Recorded sessions: begun, marked, ended."""

import contextlib
import time

from mwidth import failure
from mwidth.v1 import session_pb2


class Session:
    """An axis that is being recorded. Made by Client.session; ends with the with block, or by end().

        with client.session(subject="sub-01", task="reach") as session:
            with session.trial("reach 1", target_rad=0.5):
                ...
            session.mark("question asked", at_ns=asked_ns)

    Times given to it are this process's time.monotonic_ns(); they are put on the axis's clock by `clock`, measured when
    the session begins and whenever sync_clock() is called. A simulation whose time runs faster or slower has no such
    `clock` (None): then moments are marked as they reach the server, and no other can be. All methods may be called from
    any thread and raise Error.
    """

    def __init__(self, client, axis, start):
        self._client = client
        self._axis = axis
        self._ended = False
        # Before it begins: if this fails, nothing is left recording.
        self.sync_clock()
        self.info = start()  # mwidth.v1.Session, as it began; after end() as it ended

    @property
    def session_id(self):
        return self.info.session_id

    def __enter__(self):
        return self

    def __exit__(self, exception_type, *_):
        if exception_type is None:
            self.end()
        else:
            # What went wrong in the block is what the caller must hear of.
            with contextlib.suppress(failure.Error):
                self.end()

    def sync_clock(self):
        """Measures the clock anew; every minute or so."""
        before = self._client.sync_clock(self._axis)
        after = self._client.sync_clock(self._axis)
        self.clock = after if after.agrees_with(before) else None

    def mark(self, label, kind="", metadata=None, at_ns=None):
        """Marker: marks the moment at_ns, by default now. Metadata are kept as text."""
        request = session_pb2.AddMarkerRequest(
            axis=self._axis,
            label=label,
            kind=kind,
            metadata={key: str(value) for key, value in (metadata or {}).items()},
        )
        if self.clock is not None:
            request.time.client_ns = time.monotonic_ns() if at_ns is None else at_ns
            request.time.offset_ns = self.clock.offset_ns
            request.time.error_ns = self.clock.error_ns
        elif at_ns is not None:
            raise ValueError("the axis's time is simulated and runs at another pace: mark moments as they come")
        return self._client._call(self._client._sessions.AddMarker, request).marker

    @contextlib.contextmanager
    def trial(self, label, **metadata):
        """Marks the begin and the end of a trial, which reports and exports know. Of its metadata, target_rad, target_deg
        or target_m is where the reach should end; where the trial failed, the end says so.
        """
        self.mark(label, "trial_start", metadata)
        try:
            yield
        except BaseException:
            with contextlib.suppress(failure.Error):
                self.mark(label, "trial_end", {"outcome": "failed"})
            raise
        self.mark(label, "trial_end")

    def end(self):
        """mwidth.v1.Session: ends it; everything is on the server's disk then. Does no harm twice."""
        if not self._ended:
            request = session_pb2.EndSessionRequest(session_id=self.session_id)
            self.info = self._client._call(self._client._sessions.EndSession, request).session
            self._ended = True
        return self.info
