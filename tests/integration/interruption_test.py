"""What the world does to a running server: signals, a process that is stopped, a wall clock that jumps."""

import os
import pathlib
import signal
import struct
import tempfile
import time
import unittest

from server_process import ServerProcess, grpc, rendering, seconds

from mwidth.v1 import telemetry_pb2 as telemetry

MASS = 0.05
STOP_S = 2
HOUR_S = 3600
TTL_S = 10
TRIES = 10


def render(server, lease):
    """Renders MASS at once, clearing a fault that a stalling host has caused."""
    if server.state().state == rendering.STATE_FAULT:
        server.rendering.ClearFault(rendering.ClearFaultRequest(lease_id=lease))
    server.start(lease)
    server.set_mass(lease, MASS, ramp=seconds(0))


def batches(stream):
    """Until the server ends it."""
    try:
        for response in stream:
            yield response.batch
    except grpc.RpcError:
        pass


class InterruptionTest(unittest.TestCase):
    def test_sigterm_ramps_the_mass_to_zero_before_the_end(self):
        with ServerProcess("--config", "elbow", "--simulation-speed", 1) as server:
            lease = server.acquire()
            render(server, lease)
            stream = server.telemetry.StreamSamples(telemetry.StreamSamplesRequest())
            masses = list(next(stream).batch.mass)
            server.process.send_signal(signal.SIGTERM)
            for batch in batches(stream):
                masses += batch.mass
            self.assertEqual(server.process.wait(timeout=30), 0)
        ramp = masses[len(masses) - 1 - masses[::-1].index(MASS):]
        self.assertEqual(ramp[-1], 0)
        self.assertGreater(len(ramp), 150, "0.2 s at 1 kHz, not a cut")
        steps = [before - after for before, after in zip(ramp, ramp[1:])]
        self.assertGreaterEqual(min(steps), 0)
        self.assertLess(max(steps), MASS / 100)

    def test_a_server_that_was_stopped_resumes_in_fault(self):
        with ServerProcess("--config", "elbow") as server:
            lease = server.acquire(ttl_s=60)
            for _ in range(TRIES):
                render(server, lease)
                server.process.send_signal(signal.SIGSTOP)
                time.sleep(STOP_S)
                server.process.send_signal(signal.SIGCONT)
                state = server.state()
                # A stall of the host just before the stop is a fault of its own: that says nothing of the stop.
                if state.fault.value >= 100:
                    break
            self.assertEqual(state.state, rendering.STATE_FAULT)
            self.assertEqual(state.fault.kind, rendering.FAULT_KIND_OVERRUN)
            self.assertGreater(state.fault.value, 0.9 * STOP_S * 1000, "ticks missed at once")
            self.assertEqual((state.mass, state.force), (0, 0))
            self.assertGreaterEqual(state.tick_statistics.overruns, 1)
            self.assertGreater(state.tick_statistics.wake_latency.max_s, 0.9 * STOP_S)
            self.assertGreaterEqual(state.missed_ticks, state.fault.value)
            with self.assertRaises(grpc.RpcError):
                server.set_mass(lease, MASS)  # The fault is latched.


class WallClockTest(unittest.TestCase):
    """tests/support/wall_clock.cc shows the server a wall clock that the test moves; the monotonic one stays true."""

    def setUp(self):
        self.clock = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory())) / "offset"
        self.clock.write_bytes(bytes(8))
        if "-fsanitize" in os.environ["MWIDTH_CXX_FLAGS"]:
            self.skipTest("a sanitizer's library must be the first one")
        self.environment = {"LD_PRELOAD": os.environ["WALL_CLOCK_LIBRARY"], "WALL_CLOCK_OFFSET_FILE": str(self.clock)}

    def set_clock(self, offset_s):
        with self.clock.open("r+b") as file:  # In place: the server has it mapped.
            file.write(struct.pack("=q", offset_s * 10**9))

    def expiry_s(self, server, lease):
        """When the lease expires, by the server's wall clock, from now by the true one."""
        answer = server.rendering.RenewControl(rendering.RenewControlRequest(lease_id=lease))
        return answer.lease.expire_time.ToNanoseconds() / 1e9 - time.time()

    def assert_unmoved(self, server, stream, lease, offset_s, expected_s):
        before = server.state()
        self.set_clock(offset_s)
        self.assertAlmostEqual(self.expiry_s(server, lease), expected_s, delta=60, msg="the wall clock did jump")
        # Three more seconds of the loop: a timer that waited on the wall clock would hang, or fire, by then.
        last = next(stream).batch
        while last.first_tick < before.tick + 3000:
            batch = next(stream).batch
            gap = batch.first_tick - last.first_tick - len(last.position)
            self.assertEqual(gap, batch.missed_ticks_before)
            self.assertEqual(batch.dropped_ticks_before, 0)
            last = batch
        self.expiry_s(server, lease)
        after = server.state()
        self.assertEqual(after.controller, "test")
        self.assertLess(after.missed_ticks - before.missed_ticks, 1000, "an hour has 3,600,000")
        return after

    def test_a_jump_of_an_hour_changes_nothing(self):
        for arguments in ((), ("--simulation-speed", 1)):
            with self.subTest(arguments=arguments):
                self.set_clock(0)
                with ServerProcess("--config", "elbow", *arguments, environment=self.environment) as server:
                    lease = server.acquire(ttl_s=TTL_S)
                    render(server, lease)
                    stream = server.telemetry.StreamSamples(telemetry.StreamSamplesRequest())
                    for offset_s, expected_s in ((HOUR_S, HOUR_S + TTL_S), (-HOUR_S, TTL_S - HOUR_S)):
                        state = self.assert_unmoved(server, stream, lease, offset_s, expected_s)
                        if arguments:  # Where no deadline can be missed, rendering must not have ended.
                            self.assertEqual((state.state, state.mass), (rendering.STATE_RENDERING, MASS))
                    stream.cancel()


if __name__ == "__main__":
    unittest.main()
