"""Control over the wire: who may, what is refused and how, and what happens to the mass when a client dies."""

import math
import pathlib
import signal
import subprocess
import sys
import threading
import time
import unittest

from server_process import BUILD, ServerProcess, grpc, rendering, seconds

from google.rpc import error_details_pb2, status_pb2
from mwidth.v1 import stability_pb2 as stability
from mwidth.v1 import telemetry_pb2 as telemetry

DEADLINE_S = 20


def refused(call):
    """The RpcError that `call` raises, with its google.rpc details by message name."""
    try:
        call()
    except grpc.RpcError as error:
        details = {}
        for key, value in error.trailing_metadata() or ():
            if key == "grpc-status-details-bin":
                for packed in status_pb2.Status.FromString(value).details:
                    for message in (error_details_pb2.ErrorInfo(), stability.StabilityReport()):
                        if packed.Unpack(message):
                            details[type(message).__name__] = message
        return error, details
    raise AssertionError("was not refused")


def wait_for(condition):
    end = time.monotonic() + DEADLINE_S
    while not condition():
        if time.monotonic() > end:
            raise AssertionError("did not happen")
        time.sleep(0.005)


class ControlTest(unittest.TestCase):
    def setUp(self):
        self.server = self.enterContext(ServerProcess("--config", "elbow", "--simulation-speed", 1))

    def assert_refused(self, call, code, reason):
        error, details = refused(call)
        self.assertEqual(error.code(), code, error.details())
        self.assertEqual(details["ErrorInfo"].domain, "mwidth")
        self.assertEqual(details["ErrorInfo"].reason, reason)
        self.assertGreater(len(error.details()), 20, "a sentence")
        return error, details

    def rendering_lease(self, mass=0.05, ttl_s=10):
        lease = self.server.acquire(ttl_s)
        self.server.start(lease)
        self.server.set_mass(lease, mass, ramp=seconds(0))
        wait_for(lambda: self.server.state().mass == mass)
        return lease

    def test_an_unstable_mass_is_refused_with_what_would_be_accepted(self):
        lease = self.rendering_lease()
        m_width = self.server.state().m_width
        for mass in (m_width.admitted.max * 1.001, m_width.admitted.min * 1.001):
            _, details = self.assert_refused(lambda: self.server.set_mass(lease, mass),
                                             grpc.StatusCode.FAILED_PRECONDITION, "UNSTABLE_MASS")
            report = details["StabilityReport"]
            self.assertEqual(report.requested_mass, mass)
            self.assertEqual(report.m_width.admitted, m_width.admitted)
            self.assertGreater(report.critical_hz, 0)
            self.assertTrue(report.binding)
            self.assertEqual(self.server.state().mass, 0.05, "the running mass is unchanged")
            self.assertEqual(self.server.state().target_mass, 0.05)
            nearest = report.nearest_admitted_mass
            self.assertEqual(self.server.set_mass(lease, nearest, validate_only=True).mass, nearest)
            loop = stability.LoopParameters(cutoff_hz=report.admitting_cutoff_hz)
            admitted = self.server.stability.GetMWidth(stability.GetMWidthRequest(loop=loop)).m_width.admitted
            self.assertTrue(admitted.min < mass < admitted.max, "the named cut-off admits it")

    def test_a_stream_holds_nothing_from_before_it_was_opened(self):
        lease = self.rendering_lease()
        for _ in range(20):
            stream = self.server.telemetry.StreamSamples(telemetry.StreamSamplesRequest())
            self.assertEqual(set(next(stream).batch.state), {rendering.STATE_RENDERING})
            stream.cancel()
            self.server.rendering.StopRendering(rendering.StopRenderingRequest(lease_id=lease))
            self.server.rendering.StartRendering(rendering.StartRenderingRequest(lease_id=lease))

    def test_bad_requests_get_their_status_and_the_loop_never_notices(self):
        lease = self.rendering_lease()
        stream = self.server.telemetry.StreamSamples(telemetry.StreamSamplesRequest(max_batch=50))
        next(stream)
        invalid, precondition = grpc.StatusCode.INVALID_ARGUMENT, grpc.StatusCode.FAILED_PRECONDITION
        for mass in (math.nan, math.inf, -math.inf):
            self.assert_refused(lambda: self.server.set_mass(lease, mass), invalid, "INVALID_NUMBER")
        self.assert_refused(lambda: self.server.set_mass("", 0.05), precondition, "NO_LEASE")
        self.assert_refused(lambda: self.server.set_mass("feedbeef", 0.05), precondition, "NO_LEASE")
        request = rendering.SetMassRequest(axis="shoulder", lease_id=lease, mass=0.05)
        self.assert_refused(lambda: self.server.rendering.SetMass(request), grpc.StatusCode.NOT_FOUND, "UNKNOWN_AXIS")
        for garbage in (b"\xff" * 40, b"\x0a\xff\xff\xff\xff\x0f", bytes(range(256))):
            raw = self.server.channel.unary_unary("/mwidth.v1.RenderingService/SetMass")
            with self.assertRaises(grpc.RpcError) as caught:
                raw(garbage)
            self.assertEqual(caught.exception.code(), grpc.StatusCode.INTERNAL)
        with self.assertRaises(grpc.RpcError) as caught:
            self.server.channel.unary_unary("/mwidth.v1.RenderingService/NoSuchMethod")(b"")
        self.assertEqual(caught.exception.code(), grpc.StatusCode.UNIMPLEMENTED)

        batches = [next(stream).batch for _ in range(10)]
        stream.cancel()
        for before, after in zip(batches, batches[1:]):
            gap = after.first_tick - before.first_tick - len(before.position)
            self.assertEqual(gap, after.missed_ticks_before + after.dropped_ticks_before)
            self.assertEqual(after.dropped_ticks_before, 0)
            self.assertEqual(set(after.mass), {0.05})
        self.assertEqual(self.server.state().state, rendering.STATE_RENDERING)

    def test_a_second_client_may_watch_but_not_control(self):
        lease = self.rendering_lease(ttl_s=2)
        error, _ = self.assert_refused(lambda: self.server.acquire(name="second"),
                                       grpc.StatusCode.FAILED_PRECONDITION, "CONTROL_HELD")
        self.assertIn("test", error.details(), "names the holder")
        channel = grpc.insecure_channel(self.server.address)
        watch = channel.unary_stream("/mwidth.v1.TelemetryService/StreamSamples",
                                     telemetry.StreamSamplesRequest.SerializeToString,
                                     telemetry.StreamSamplesResponse.FromString)
        self.assertGreater(len(next(watch(telemetry.StreamSamplesRequest())).batch.position), 0)
        channel.close()
        wait_for(lambda: self.server.state().state == rendering.STATE_READY)
        other = self.server.acquire(name="second")
        self.assert_refused(lambda: self.server.set_mass(lease, 0.05), grpc.StatusCode.ABORTED, "LEASE_LOST")
        self.server.start(other)
        self.assertEqual(self.server.state().target_mass, 0, "the mass of another client does not come back")

    def test_the_mass_of_a_killed_client_ramps_to_zero(self):
        batches = []

        def watch():
            try:
                for response in self.server.telemetry.StreamSamples(telemetry.StreamSamplesRequest()):
                    batches.append(response.batch)
            except grpc.RpcError:
                pass  # cancelled with the channel

        threading.Thread(target=watch, daemon=True).start()
        client = subprocess.Popen(
            [sys.executable, pathlib.Path(__file__).parent / "holding_client.py", self.server.address])
        try:
            wait_for(lambda: self.server.state().mass == 0.05)
        finally:
            client.send_signal(signal.SIGKILL)
            client.wait()
        wait_for(lambda: self.server.state().state == rendering.STATE_READY)
        state = self.server.state()
        self.assertEqual((state.mass, state.force, state.controller), (0, 0, ""))
        wait_for(lambda: batches and batches[-1].first_tick > state.tick)
        masses = [m for batch in batches for m in batch.mass]
        last_full = max(i for i, m in enumerate(masses) if m == 0.05)
        ramp = masses[last_full:]
        self.assertTrue(all(a >= b >= 0 for a, b in zip(ramp, ramp[1:])), "down, without a jump up")
        period_s = state.info.loop.period_s
        self.assertLessEqual(ramp.index(0) * period_s, 0.5 + 2 * period_s)
        self.assertGreater(ramp.index(0), 10, "a ramp, not a step")

    def test_an_emergency_stop_needs_no_lease_and_latches(self):
        lease = self.rendering_lease()
        stopped = self.server.rendering.EmergencyStop(rendering.EmergencyStopRequest(reason="test"))
        self.assertEqual(list(stopped.states), [rendering.STATE_FAULT])
        state = self.server.state()
        self.assertEqual((state.state, state.force, state.mass), (rendering.STATE_FAULT, 0, 0))
        self.assertEqual(state.fault.kind, rendering.FAULT_KIND_EMERGENCY_STOP)
        self.assert_refused(lambda: self.server.start(lease), grpc.StatusCode.FAILED_PRECONDITION, "WRONG_STATE")
        clear = rendering.ClearFaultRequest(lease_id=lease)
        self.assertEqual(self.server.rendering.ClearFault(clear).state, rendering.STATE_IDLE)
        self.server.start(lease)
        self.assertEqual(self.server.state().target_mass, 0, "a mass from before the stop does not come back")

    def test_a_request_for_the_lease_of_a_dead_client_waits_for_its_end(self):
        self.server.acquire(ttl_s=0.1, name="gone")
        wait_for(lambda: self.server.state().controller == "")
        self.server.acquire(name="next")
        self.assertEqual(self.server.state().controller, "next")


class FilterTest(unittest.TestCase):
    def test_the_filter_changes_while_a_mass_is_rendered_and_the_mass_comes_back(self):
        with ServerProcess("--config", "paper") as server:
            lease = server.acquire()
            server.set_mass(lease, 0.3)
            server.start(lease)
            answer = server.set_filter(lease, 12, estimator=stability.ESTIMATOR_KIND_KALMAN)
            self.assertEqual(answer.loop.cutoff_hz, 12)
            self.assertGreater(answer.tick, 0)
            self.wait_for_mass(server, 0.3)
            state = server.state()
            self.assertEqual(state.state, rendering.STATE_RENDERING)
            self.assertEqual(state.info.loop, answer.loop)
            self.assertEqual(state.m_width, answer.stability.m_width)

    def test_a_filter_that_the_mass_is_not_stable_with_is_refused_and_both_stay(self):
        with ServerProcess("--config", "paper") as server:
            lease = server.acquire()
            server.set_mass(lease, 1.5)
            with self.assertRaises(grpc.RpcError) as caught:
                server.set_filter(lease, 100)
            self.assertEqual(caught.exception.code(), grpc.StatusCode.FAILED_PRECONDITION)
            self.assertEqual(server.state().info.loop.cutoff_hz, 10)
            server.start(lease)
            self.wait_for_mass(server, 1.5)

    def test_the_command_line_changes_the_filter_unless_another_has_control(self):
        def mwidth(*arguments):
            return subprocess.run([BUILD / "bin" / "mwidth", "--server", server.address, *arguments],
                                  capture_output=True, text=True, timeout=60)

        with ServerProcess("--config", "paper") as server:
            changed = mwidth("set-filter", "--estimator", "butterworth", "15")
            self.assertEqual(changed.returncode, 0, changed.stderr)
            loop = server.state().info.loop
            self.assertEqual((loop.estimator, loop.cutoff_hz), (stability.ESTIMATOR_KIND_BUTTERWORTH, 15))
            self.assertEqual(server.state().controller, "")
            self.assertIn("butterworth, cut-off 15 Hz", mwidth("state").stdout)
            self.assertEqual(mwidth("set-filter", "491").returncode, 1, "above 0.49 of the rate")
            self.assertEqual(mwidth("set-filter", "30", "--validate-only").returncode, 0)
            server.acquire(name="somebody")
            held = mwidth("set-filter", "20")
            self.assertEqual(held.returncode, 1)
            self.assertIn("'somebody' has control", held.stderr)
            self.assertEqual(server.state().info.loop.cutoff_hz, 15)

    def wait_for_mass(self, server, mass):
        for _ in range(500):
            if server.state().mass == mass:
                return
            time.sleep(0.01)
        self.fail(f"the mass did not reach {mass}: {server.state().mass}")


if __name__ == "__main__":
    unittest.main()
