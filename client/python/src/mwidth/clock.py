"""The server's clock, for a study that has its own."""

import dataclasses
import time


@dataclasses.dataclass(frozen=True)
class ClockOffset:
    """What to add to this process's clock to have the axis's, ns, and how far off that may be.

    Clocks drift apart, by some 50 us a second at worst: ask anew every minute or so.
    """

    offset_ns: int
    error_ns: int

    def to_axis_ns(self, client_ns):
        """The time on the axis's clock, as samples and events have it, of a time of time.monotonic_ns()."""
        return client_ns + self.offset_ns

    def agrees_with(self, other):
        """False where the two, measured one right after the other, cannot both be right: the clocks' paces differ."""
        return abs(self.offset_ns - other.offset_ns) <= self.error_ns + other.error_ns


def measure(ask, count):
    """ClockOffset of the best of `count` exchanges; ask(client_ns) returns a SyncClockResponse.

    With the client's times t0, t3 and the server's t1, t2, and however the way's time splits between there and back, the
    offset lies between t2 - t3 and t1 - t0; the exchange with the shortest way bounds it best.
    """
    best = None
    for _ in range(count):
        t0 = time.monotonic_ns()
        answer = ask(t0)
        t3 = time.monotonic_ns()
        least, greatest = answer.server_send_ns - t3, answer.server_receive_ns - t0
        offset = ClockOffset((least + greatest) // 2, (greatest - least + 1) // 2)
        if best is None or offset.error_ns < best.error_ns:
            best = offset
    return best
