"""The Python client against a server that answers as mwidthd does."""

import dataclasses
import math
import pickle
import threading
import unittest

import grpc
import mwidth
import numpy as np
from fake_server import ADMITTED, FakeServer
from mwidth import samples
from mwidth.v1 import rendering_pb2, stability_pb2, telemetry_pb2


class ClientTest(unittest.TestCase):
    def setUp(self):
        self.server = self.enterContext(FakeServer())
        self.client = self.enterContext(mwidth.Client(self.server.address))

    def test_reads_the_state_of_the_only_axis(self):
        self.assertEqual(self.client.state().server_version, "9.9.9")
        self.assertEqual(self.client.axis().info.name, "elbow")

    def test_unknown_axis_is_an_error_with_the_servers_reason(self):
        with self.assertRaises(mwidth.Error) as raised:
            self.client.state("knee")
        self.assertEqual(raised.exception.code, grpc.StatusCode.NOT_FOUND)
        self.assertEqual(raised.exception.reason, "UNKNOWN_AXIS")
        self.assertEqual(str(raised.exception), "no such axis")

    def test_no_server_is_an_error(self):
        with mwidth.Client("127.0.0.1:1") as nobody, self.assertRaises(mwidth.Error) as raised:
            nobody.state()
        self.assertEqual(raised.exception.code, grpc.StatusCode.UNAVAILABLE)

    def test_m_width_sends_only_the_overrides_that_are_given(self):
        response = self.client.m_width(hand_stiffness=0)
        self.assertTrue(self.server.last_request.loop.HasField("hand_stiffness"))
        self.assertFalse(self.server.last_request.loop.HasField("cutoff_hz"))
        self.assertFalse(self.server.last_request.HasField("envelope"))
        self.assertEqual(response.loop.hand_stiffness, 0)
        self.assertEqual(response.m_width.admitted.max, ADMITTED[1])

    def test_an_envelope_is_given_as_ranges_or_as_a_message(self):
        self.client.m_width(envelope={"stiffness": (100, 2000), "include_released_hand": True})
        envelope = self.server.last_request.envelope
        self.assertEqual((envelope.stiffness.min, envelope.stiffness.max), (100, 2000))
        self.assertFalse(envelope.HasField("damping"))
        self.assertTrue(envelope.include_released_hand)
        self.assertFalse(self.server.last_request.HasField("tolerance"))
        self.client.m_width(envelope=envelope, tolerance={"mass": (0.04, 0.06)})
        self.assertEqual(self.server.last_request.envelope, envelope)
        self.assertEqual(self.server.last_request.tolerance.mass.max, 0.06)
        # Without a range, any hand like the axis's own: an envelope all the same.
        self.client.m_width(envelope={})
        self.assertTrue(self.server.last_request.HasField("envelope"))
        with self.assertRaises(ValueError):
            self.client.m_width(envelope={"strength": (1, 2)})

    def test_estimators_go_by_the_names_of_the_configuration(self):
        self.assertEqual(
            self.client.m_width(estimator="late-filtered-difference").loop.estimator,
            stability_pb2.ESTIMATOR_KIND_LATE_FILTERED_DIFFERENCE,
        )
        response = self.client.frequency_response(0.1, estimator=stability_pb2.ESTIMATOR_KIND_KALMAN)
        self.assertEqual(response.loop.estimator, stability_pb2.ESTIMATOR_KIND_KALMAN)
        for unknown in ("guess", "unspecified", ""):
            with self.assertRaisesRegex(ValueError, "butterworth, kalman"):
                self.client.m_width(estimator=unknown)

    def test_a_frequency_response_is_asked_for_by_mass_and_range(self):
        response = self.client.frequency_response(0.1, min_hz=1, count=2, continuous=True, cutoff_hz=20)
        self.assertEqual(list(response.frequency_hz), [1, 2])
        request = self.server.last_request
        self.assertEqual((request.mass, request.min_hz, request.max_hz, request.count), (0.1, 1, 0, 2))
        self.assertEqual(request.model, stability_pb2.RESPONSE_MODEL_CONTINUOUS)
        self.assertEqual(request.loop.cutoff_hz, 20)

    def test_accuracy_is_asked_for_by_mass_and_motion(self):
        response = self.client.accuracy(0.1, max_hz=2, simulate=True, delay_s=0.001)
        self.assertAlmostEqual(response.accuracy.ideal_mass, 0.15)
        self.assertEqual(self.server.last_request.band.max_hz, 2)
        self.assertTrue(self.server.last_request.simulate)
        self.assertEqual(response.loop.delay_s, 0.001)

    def test_a_sweep_is_arrays(self):
        sweep = self.client.sweep(
            mwidth.sweep_range("cutoff_hz", 1, 3, count=3), mwidth.sweep_range("hand_damping", 5, 6, logarithmic=True)
        )
        self.assertTrue(self.server.last_request.y.logarithmic)
        self.assertEqual(self.server.last_request.x.parameter, stability_pb2.SWEEP_PARAMETER_CUTOFF_HZ)
        np.testing.assert_array_equal(sweep.x, [1, 2, 3])
        np.testing.assert_array_equal(sweep.y, [5, 6])
        np.testing.assert_array_equal(sweep.min, [[-1, -2, -3]] * 2)
        np.testing.assert_array_equal(sweep.max, [[1, 2, math.nan]] * 2)
        self.assertEqual(self.client.sweep(mwidth.sweep_range("delay_s", 0, 0.001)).min.shape, (1, 21))
        with self.assertRaisesRegex(ValueError, "cutoff_hz, delay_s"):
            mwidth.sweep_range("cut-off", 1, 2)
        with self.assertRaises(mwidth.Error) as raised:
            self.client.sweep(mwidth.sweep_range("delay_s", 0, 0.001), axis="knee")
        self.assertEqual(raised.exception.reason, "UNKNOWN_AXIS")

    def test_emergency_stop_needs_no_control(self):
        self.server.held_by_another = True
        self.assertEqual(self.client.emergency_stop("strap came loose").states, [rendering_pb2.STATE_FAULT])
        self.assertEqual(self.server.stop_reason, "strap came loose")


class ControlTest(unittest.TestCase):
    def setUp(self):
        self.server = self.enterContext(FakeServer())
        self.client = self.enterContext(mwidth.Client(self.server.address))

    def test_renders_a_mass_and_releases_at_the_end_of_the_block(self):
        with self.client.control("test") as control:
            self.assertEqual(control.start_rendering().state, rendering_pb2.STATE_RENDERING)
            self.assertEqual(control.set_mass(-0.02, ramp_s=1.5).mass, -0.02)
            self.assertEqual(self.server.last_request.ramp.ToMilliseconds(), 1500)
            control.stop_rendering()
        self.assertEqual(
            self.server.calls, ["AcquireControl", "StartRendering", "SetMass", "StopRendering", "ReleaseControl"]
        )

    def test_releases_when_the_block_fails_too(self):
        with self.assertRaises(ZeroDivisionError), self.client.control("test"):
            raise ZeroDivisionError
        self.assertEqual(self.server.calls, ["AcquireControl", "ReleaseControl"])

    def test_a_refused_mass_carries_its_report(self):
        with self.client.control("test") as control, self.assertRaises(mwidth.Refused) as raised:
            control.set_mass(0.8)
        self.assertEqual(raised.exception.reason, "UNSTABLE_MASS")
        self.assertEqual(raised.exception.stability.nearest_admitted_mass, ADMITTED[1])
        self.assertEqual(raised.exception.stability.admitting_cutoff_hz, 4.5)
        self.assertNotIn("SetMass", self.server.calls)

    def test_a_mass_that_is_no_number_is_an_error_and_no_refusal(self):
        with self.client.control("test") as control, self.assertRaises(mwidth.Error) as raised:
            control.set_mass(math.nan)
        self.assertNotIsInstance(raised.exception, mwidth.Refused)
        self.assertEqual(raised.exception.code, grpc.StatusCode.INVALID_ARGUMENT)

    def test_validate_only_changes_nothing(self):
        with self.client.control("test") as control:
            control.set_mass(0.1, validate_only=True)
            self.assertFalse(self.server.last_request.HasField("ramp"))
        self.assertNotIn("SetMass", self.server.calls)

    def test_a_filter_is_changed(self):
        with self.client.control("test") as control:
            answer = control.set_filter(20, estimator="kalman")
            self.assertEqual(answer.loop.cutoff_hz, 20)
            self.assertEqual(answer.loop.estimator, stability_pb2.ESTIMATOR_KIND_KALMAN)
            control.set_filter(30, validate_only=True)
            self.assertEqual(self.server.last_request.estimator, stability_pb2.ESTIMATOR_KIND_UNSPECIFIED)
        self.assertEqual(self.server.calls, ["AcquireControl", "SetFilter", "ReleaseControl"])

    def test_a_filter_that_the_mass_is_unstable_with_is_refused(self):
        with self.client.control("test") as control:
            control.set_mass(0.1)
            with self.assertRaises(mwidth.Refused) as raised:
                control.set_filter(100)
            self.assertEqual(raised.exception.stability.requested_mass, 0.1)
        self.assertNotIn("SetFilter", self.server.calls)

    def test_control_held_by_another_is_an_error(self):
        self.server.held_by_another = True
        with self.assertRaises(mwidth.Error) as raised:
            self.client.control("test")
        self.assertEqual(raised.exception.reason, "CONTROL_HELD")

    def test_renews_in_the_background(self):
        with self.client.control("test", ttl_s=1) as control:
            self.assertTrue(self.server.wait_for_renewals(3))
            self.assertIsNone(control.loss)

    def test_a_lost_lease_ends_every_further_call_and_is_not_released(self):
        self.server.renewal_code = grpc.StatusCode.ABORTED
        with self.client.control("test", ttl_s=0.3) as control:
            control._renewal.join(timeout=60)
            self.assertIsInstance(control.loss, mwidth.LeaseLost)
            with self.assertRaises(mwidth.LeaseLost):
                control.set_mass(0.1)
        self.assertEqual(self.server.renewals, 1)
        self.assertEqual(self.server.calls, ["AcquireControl"])

    def test_a_silent_server_is_asked_again_until_the_time_to_live_is_over(self):
        self.server.renewal_code = grpc.StatusCode.UNAVAILABLE
        with self.client.control("test", ttl_s=0.3) as control:
            control._renewal.join(timeout=60)
            self.assertEqual(control.loss.code, grpc.StatusCode.UNAVAILABLE)
        self.assertGreaterEqual(self.server.renewals, 2)


class SampleStreamTest(unittest.TestCase):
    def setUp(self):
        self.server = self.enterContext(FakeServer())
        self.client = self.enterContext(mwidth.Client(self.server.address))

    def test_batches_are_arrays_with_their_ticks_and_gaps(self):
        with self.client.stream(decimation=2, max_batch=3) as stream:
            first, second, third = next(stream), next(stream), next(stream)
        np.testing.assert_array_equal(first.tick, [1000, 1002, 1004])
        np.testing.assert_array_equal(second.monotonic_ns, [1006000000, 1008000000, 1010000000])
        np.testing.assert_array_equal(third.position_counts, [-1017, -1019, -1021])
        np.testing.assert_array_equal(third.saturated, [True, True, True])
        self.assertEqual((third.missed_ticks_before, third.dropped_ticks_before), (2, 3))
        self.assertEqual((stream.missed_ticks, stream.dropped_ticks), (2, 3))
        self.assertEqual(len(third), 3)

    def test_a_stream_asks_for_batches_and_reductions_by_name(self):
        with self.client.stream(decimation=10, min_batch=5, max_batch=50, reduction="min-max") as stream:
            next(stream)
        request = self.server.last_request
        self.assertEqual((request.decimation, request.min_batch, request.max_batch), (10, 5, 50))
        self.assertEqual(request.reduction, telemetry_pb2.REDUCTION_MIN_MAX)
        with self.assertRaises(ValueError):
            self.client.stream(reduction="mean")

    def test_samples_have_their_extremes_where_they_were_asked_for(self):
        batch = telemetry_pb2.SampleBatch(position=[1, 2], position_min=[0.5, 1.5], force_max=[3, 4])
        got = samples.from_message(batch)
        self.assertEqual(got.position_min.tolist(), [0.5, 1.5])
        self.assertEqual(got.force_max.tolist(), [3, 4])
        self.assertIsNone(got.velocity_min)
        joined = mwidth.concatenate([got, got])
        self.assertEqual(joined.position_min.tolist(), [0.5, 1.5, 0.5, 1.5])
        self.assertIsNone(joined.velocity_min)

    def test_a_received_batch_is_a_dataclass_like_any_other(self):
        got = samples.from_message(
            telemetry_pb2.SampleBatch(first_tick=5, decimation=2, position=[1, 2], force=[3, 4], state=[1, 2]))
        self.assertEqual(len(got), 2)
        again = pickle.loads(pickle.dumps(got))
        self.assertEqual((again.tick.tolist(), again.force.tolist()), ([5, 7], [3, 4]))
        moved = dataclasses.replace(got, position=got.position + 1)
        self.assertEqual((moved.position.tolist(), moved.force.tolist(), len(moved)), ([2, 3], [3, 4], 2))
        with self.assertRaises(AttributeError):
            got.nothing
        with self.assertRaises(dataclasses.FrozenInstanceError):
            got.position = moved.position

    def test_what_follows_a_batch_in_its_message_goes_on_with_it_and_stands_in_place_of_its_fields(self):
        """As mwidthd joins batches that waited, and tells a slow reader alone what it lost."""
        parts = [telemetry_pb2.SampleBatch(first_tick=10, dropped_ticks_before=1, position=[0.5, 1.5]),
                 telemetry_pb2.SampleBatch(first_tick=12, position=[2.5], state=[1]),
                 telemetry_pb2.SampleBatch(first_tick=10, missed_ticks_before=3, dropped_ticks_before=400)]
        data = b"".join(telemetry_pb2.StreamSamplesResponse(batch=part).SerializeToString() for part in parts)
        got = samples.from_message(telemetry_pb2.StreamSamplesResponse.FromString(data).batch)
        self.assertEqual(got.position.tolist(), [0.5, 1.5, 2.5])
        self.assertEqual(got.tick.tolist(), [10, 11, 12])
        self.assertEqual((got.missed_ticks_before, got.dropped_ticks_before), (3, 400))

    def test_concatenate_keeps_order_and_inner_gaps(self):
        with self.client.stream(max_batch=2) as stream:
            batches = [next(stream) for _ in range(4)]
        joined = mwidth.concatenate(batches[1:])
        np.testing.assert_array_equal(joined.tick, [1002, 1003, 1009, 1010, 1011, 1012])
        self.assertEqual(joined.missed_ticks_before, 2)
        self.assertEqual(mwidth.concatenate(batches[2:]).missed_ticks_before, 0)

    def test_cancel_from_another_thread_ends_the_iteration(self):
        stream = self.client.stream()
        canceller = threading.Thread(target=stream.cancel)
        next(stream)
        canceller.start()
        for _ in stream:
            pass
        canceller.join()

    def test_an_end_by_the_server_is_an_error(self):
        self.server.end_stream_after = 2
        stream = self.client.stream()
        next(stream)
        with self.assertRaises(mwidth.Error) as raised:
            next(stream)
        self.assertEqual(str(raised.exception), "the server shuts down")


if __name__ == "__main__":
    unittest.main()
