"""Sweeps, frequency responses, accuracy and envelopes over the wire: the paper's figures, the grid point by point, and
what is refused."""

import math
import pathlib
import tempfile
import time
import unittest

from server_process import ServerProcess, grpc

from google.rpc import error_details_pb2, status_pb2
from mwidth.v1 import stability_pb2 as stability

M = 0.070  # device mass of the paper


def detail(error, message):
    """The message of this type in the details of a grpc.RpcError."""
    details = dict(error.trailing_metadata())["grpc-status-details-bin"]
    for packed in status_pb2.Status.FromString(details).details:
        if packed.Unpack(message):
            return message
    raise AssertionError(f"no {message.DESCRIPTOR.full_name} in the details")


def error_info(error):
    return detail(error, error_details_pb2.ErrorInfo())


def stability_report(error):
    return detail(error, stability.StabilityReport())


def hands(columns, rows):
    """A sweep of the hand's damping by its stiffness."""
    return stability.SweepMWidthRequest(
        x=stability.SweepRange(parameter=stability.SWEEP_PARAMETER_HAND_DAMPING, min=1, max=20, count=columns),
        y=stability.SweepRange(parameter=stability.SWEEP_PARAMETER_HAND_STIFFNESS, min=10, max=5000, count=rows,
                               logarithmic=True))


class ModelServicesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = ServerProcess("--config", "paper")
        cls.addClassCleanup(cls.server.__exit__, None)

    def accuracy(self, mass, **more):
        request = stability.GetAccuracyRequest(mass=mass, **more)
        return self.server.stability.GetAccuracy(request).accuracy

    def assert_refused(self, field, call):
        with self.assertRaises(grpc.RpcError) as caught:
            call()
        self.assertEqual(caught.exception.code(), grpc.StatusCode.INVALID_ARGUMENT, field)
        info = error_info(caught.exception)
        self.assertEqual((info.domain, info.reason), ("mwidth", "INVALID_NUMBER"))
        self.assertEqual(info.metadata["field"], field)
        self.assertIn(field, caught.exception.details())
        self.assertIn(info.metadata["allowed"], caught.exception.details())

    def test_figure_9(self):
        for mass, error in ((3 * M, -0.100), (-0.5 * M, 0.160)):
            accuracy = self.accuracy(mass, simulate=True)
            self.assertAlmostEqual(accuracy.simulated_error, error, delta=0.01)
            self.assertAlmostEqual(accuracy.error, error, delta=0.01)
            self.assertAlmostEqual(accuracy.ideal_mass, M + mass)
            self.assertAlmostEqual(accuracy.simulated_perceived_mass, (1 + error) * (M + mass), delta=0.01 * M * 4)
            self.assertGreater(accuracy.force_noise, 0)

    def test_errors_shrink_as_the_cut_off_grows(self):
        for mass in (3 * M, -0.5 * M):
            errors = [abs(self.accuracy(mass, loop=stability.LoopParameters(cutoff_hz=cutoff_hz)).error)
                      for cutoff_hz in (5, 10, 20, 40, 80)]
            self.assertEqual(errors, sorted(errors, reverse=True))

    def test_an_unstable_mass_is_said_to_be_unstable(self):
        for mass in (36 * M, -2 * M):
            accuracy = self.accuracy(mass, simulate=True)
            self.assertIn("unstable", accuracy.unavailable_reason)
            for field in ("perceived_mass", "error", "simulated_perceived_mass", "simulated_error", "force_noise"):
                self.assertFalse(accuracy.HasField(field), field)

    def test_set_mass_tells_the_accuracy_to_expect(self):
        granted = self.server.set_mass(self.server.acquire(), 3 * M, validate_only=True).accuracy
        self.assertEqual(granted, self.accuracy(3 * M))

    def test_frequency_response(self):
        m_width = self.server.stability.GetMWidth(stability.GetMWidthRequest()).m_width
        response = self.server.stability.GetFrequencyResponse(stability.GetFrequencyResponseRequest(
            mass=m_width.nominal.max, min_hz=m_width.max_critical_hz, max_hz=400, count=50))
        self.assertAlmostEqual(response.magnitude_db[0], 0, places=9)
        self.assertAlmostEqual(abs(response.phase_deg[0]), 180, places=9)
        self.assertEqual({50}, {len(response.frequency_hz), len(response.magnitude_db), len(response.phase_deg)})

    def test_figure_4_of_the_continuous_model(self):
        # w_n = 100 rad/s, zeta = 0.5, w0 = 30 rad/s, M = m: -34.7 dB at 180 degrees, 1199 rad/s.
        loop = stability.LoopParameters(device_damping=0, hand_damping=100 * M, hand_stiffness=100**2 * M,
                                        cutoff_hz=30 / (2 * math.pi))
        request = stability.GetFrequencyResponseRequest(
            loop=loop, mass=M, min_hz=1, max_hz=1199 / (2 * math.pi), model=stability.RESPONSE_MODEL_CONTINUOUS)
        response = self.server.stability.GetFrequencyResponse(request)
        self.assertAlmostEqual(response.magnitude_db[-1], -34.7, delta=0.05)
        self.assertAlmostEqual(response.phase_deg[-1], -180, delta=0.1)
        self.assertEqual(len(response.frequency_hz), 200)
        self.assertAlmostEqual(response.effective_mass_ratio[0], 2, delta=0.05)
        self.assertEqual(len(response.effective_damping_ratio), 200)

    def test_a_sweep_is_consecutive_and_equals_get_m_width(self):
        rows = list(self.server.stability.SweepMWidth(hands(9, 5)))
        self.assertEqual([row.row for row in rows], list(range(5)))
        for row in rows:
            self.assertEqual(row.row_count, 5)
            for x, low, high in zip(row.x, row.min, row.max, strict=True):
                loop = stability.LoopParameters(hand_damping=x, hand_stiffness=row.y)
                nominal = self.server.stability.GetMWidth(stability.GetMWidthRequest(loop=loop)).m_width.nominal
                self.assertEqual((low, high), (nominal.min, nominal.max))

    def test_a_cancelled_sweep_ends_and_the_server_goes_on(self):
        for _ in range(10):  # more than may run at once
            stream = self.server.stability.SweepMWidth(hands(10_000, 100))
            self.assertEqual(next(stream).row, 0)
            stream.cancel()
            with self.assertRaises(grpc.RpcError) as caught:
                list(stream)
            self.assertEqual(caught.exception.code(), grpc.StatusCode.CANCELLED)
            self.wait_for_a_free_place()
        self.assertEqual(len(list(self.server.stability.SweepMWidth(hands(3, 2)))), 2)

    def wait_for_a_free_place(self):
        for _ in range(1000):
            try:
                return list(self.server.stability.SweepMWidth(hands(2, 2)))
            except grpc.RpcError as error:
                self.assertEqual(error.code(), grpc.StatusCode.RESOURCE_EXHAUSTED)
                time.sleep(0.01)
        raise AssertionError("a cancelled sweep still runs")

    def test_a_sweep_without_an_m_width_has_no_edges(self):
        request = stability.SweepMWidthRequest(
            loop=stability.LoopParameters(device_damping=0),
            x=stability.SweepRange(parameter=stability.SWEEP_PARAMETER_HAND_DAMPING, min=0, max=5, count=2))
        row, = self.server.stability.SweepMWidth(request)
        self.assertTrue(math.isnan(row.min[0]) and math.isnan(row.max[0]))
        self.assertLess(row.min[1], 0)
        self.assertGreater(row.max[1], 0)

    def test_bad_input_is_named_with_its_range(self):
        service = self.server.stability
        for field, value in (("mass", math.nan), ("mass", 1e7), ("min_hz", -1), ("max_hz", 501), ("count", 1)):
            request = stability.GetFrequencyResponseRequest(**{field: value})
            self.assert_refused(field, lambda: service.GetFrequencyResponse(request))
        for field, value in (("min_hz", math.inf), ("max_hz", -1), ("duration_s", 1)):
            request = stability.GetAccuracyRequest(band=stability.MotionBand(**{field: value}))
            self.assert_refused("band." + field, lambda: service.GetAccuracy(request))
        for field, value in (("device_mass", 0), ("cutoff_hz", 501), ("delay_s", 0.0031), ("period_s", math.nan)):
            loop = stability.LoopParameters(**{field: value})
            self.assert_refused(field, lambda: service.GetAccuracy(stability.GetAccuracyRequest(loop=loop)))
            self.assert_refused(field, lambda: list(service.SweepMWidth(
                stability.SweepMWidthRequest(loop=loop, x=hands(2, 2).x))))
        self.assert_refused("x.parameter", lambda: list(service.SweepMWidth(stability.SweepMWidthRequest())))


def edited(folder, *edits):
    """A copy of the paper's configuration in folder, with each (old, new) text replaced."""
    text = (pathlib.Path(__file__).resolve().parents[2] / "deploy/config/paper.toml").read_text()
    for old, new in edits:
        if old not in text:
            raise AssertionError(f"{old} is not in the configuration")
        text = text.replace(old, new)
    config = pathlib.Path(folder) / "edited.toml"
    config.write_text(text)
    return config


class EnvelopeTest(unittest.TestCase):
    """An axis whose hand may tighten and let go."""

    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            cls.server = ServerProcess("--config", edited(
                folder, ("# [axis.envelope]", "[axis.envelope]"), ("# stiffness = [", "stiffness = ["),
                ("# damping = [2.0", "damping = [2.0"), ("# include_released_hand = t", "include_released_hand = t")))
        cls.addClassCleanup(cls.server.__exit__, None)

    def nominal(self, **loop):
        request = stability.GetMWidthRequest(loop=stability.LoopParameters(**loop))
        return self.server.stability.GetMWidth(request).m_width.nominal

    def test_the_admitted_interval_is_that_of_every_hand(self):
        m_width = self.server.stability.GetMWidth(stability.GetMWidthRequest()).m_width
        self.assertEqual(m_width, self.server.state().m_width)
        hands_to_hold = [(0, 0)] + [(k, b) for k in (100, 300, 900, 2000) for b in (2, 5, 20)]
        edges = [self.nominal(hand_stiffness=k, hand_damping=b) for k, b in hands_to_hold]
        lower, upper = max(edge.min for edge in edges), min(edge.max for edge in edges)
        self.assertGreaterEqual(m_width.robust.min, lower)
        self.assertLessEqual(m_width.robust.max, upper)
        self.assertAlmostEqual(m_width.robust.min / lower, 1, delta=0.01)
        self.assertAlmostEqual(m_width.robust.max / upper, 1, delta=0.01)
        self.assertEqual((m_width.min_binding.hand_stiffness, m_width.min_binding.hand_damping), (2000, 2))
        self.assertAlmostEqual(20 * math.log10(m_width.robust.min / m_width.admitted.min), 3, places=9)

    def test_a_mass_that_only_the_nominal_hand_holds_is_refused_with_the_hand_that_binds(self):
        lease = self.server.acquire()
        m_width = self.server.state().m_width
        mass = (m_width.robust.min + m_width.nominal.min) / 2
        with self.assertRaises(grpc.RpcError) as caught:
            self.server.set_mass(lease, mass)
        report = stability_report(caught.exception)
        self.assertGreater(report.gain_margin_db, 0)
        self.assertIn("hand_stiffness at its greatest (2000)", report.binding)
        self.assertEqual(self.server.set_mass(lease, report.nearest_admitted_mass).mass, report.nearest_admitted_mass)

    def test_an_override_leaves_exactly_that_loop_and_an_envelope_of_its_own_replaces_the_axis_s(self):
        request = stability.GetMWidthRequest(loop=stability.LoopParameters(cutoff_hz=10))
        alone = self.server.stability.GetMWidth(request).m_width
        self.assertEqual(alone.robust, alone.nominal)
        request.envelope.CopyFrom(self.server.state().info.envelope)
        self.assertEqual(self.server.stability.GetMWidth(request).m_width, self.server.state().m_width)


class NoisyMassTest(unittest.TestCase):
    """An axis whose force noise is limited."""

    def test_a_noisy_mass_is_refused_with_the_nearest_quiet_one(self):
        with tempfile.TemporaryDirectory() as folder, ServerProcess(
                "--config", edited(folder, ("# force_noise_limit = 0.05", "force_noise_limit = 0.01"))) as server:
            lease = server.acquire()
            with self.assertRaises(grpc.RpcError) as caught:
                server.set_mass(lease, 1.5)
            self.assertEqual(caught.exception.code(), grpc.StatusCode.FAILED_PRECONDITION)
            info = error_info(caught.exception)
            self.assertEqual(info.reason, "NOISY_MASS")
            self.assertGreater(float(info.metadata["force_noise"]), 0.01)
            self.assertEqual(float(info.metadata["force_noise_limit"]), 0.01)
            nearest = float(info.metadata["nearest_admitted_mass"])
            granted = server.set_mass(lease, nearest)
            self.assertAlmostEqual(granted.accuracy.force_noise, 0.01, delta=1e-6)
            self.assertLessEqual(granted.accuracy.force_noise, 0.01)
            self.assertEqual(server.state().info.force_noise_limit, 0.01)


if __name__ == "__main__":
    unittest.main()
