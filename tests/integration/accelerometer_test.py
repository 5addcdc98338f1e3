"""A simulated drive with an accelerometer, whole: configured, certified, rendered, recorded and refused."""

import pathlib
import tempfile
import unittest

from server_process import BUILD, ServerProcess, grpc, rendering, seconds

from mwidth.v1 import stability_pb2 as stability
from mwidth.v1 import telemetry_pb2 as telemetry

from control_test import refused, wait_for

BANDWIDTH_HZ = 100.0
QUANTUM = 0.001


def configuration(folder, estimator):
    """The paper's loop with an accelerometer and this estimator at its start."""
    text = (BUILD / "share/mwidth/config/paper.toml").read_text()
    text = text.replace('estimator = "filtered-difference"', f'estimator = "{estimator}"')
    text = text.replace("[axis.drive.hand_motion]", f"""[axis.drive.accelerometer]
bandwidth_hz = {BANDWIDTH_HZ}
quantum = {QUANTUM}

[axis.drive.hand_motion]""")
    file = pathlib.Path(folder) / "accelerometer.toml"
    file.write_text(text)
    return file


class AccelerometerTest(unittest.TestCase):
    def serve(self, estimator):
        folder = self.enterContext(tempfile.TemporaryDirectory())
        return self.enterContext(
            ServerProcess("--config", configuration(folder, estimator), "--simulation-speed", 20))

    def columns(self, server, count):
        """The first `count` samples from now on, by column."""
        stream = server.telemetry.StreamSamples(telemetry.StreamSamplesRequest(max_batch=1000))
        names = ("acceleration", "acceleration_counts", "force", "mass", "state")
        columns = {name: [] for name in names}
        for response in stream:
            for name in names:
                columns[name].extend(getattr(response.batch, name))
            if len(columns["mass"]) >= count:
                stream.cancel()
                return columns

    def test_a_mass_beyond_what_the_filtered_difference_admits_is_rendered_and_one_beyond_its_own_refused(self):
        server = self.serve("filtered-accelerometer")
        own = server.state().m_width.admitted
        loop = stability.LoopParameters(estimator=stability.ESTIMATOR_KIND_FILTERED_DIFFERENCE)
        difference = server.stability.GetMWidth(stability.GetMWidthRequest(loop=loop)).m_width.admitted
        self.assertGreater(own.max, 1.3 * difference.max)
        # Also with the delay that the watch lets pass, a quarter of a period: a punctual loop holds more.
        late = server.stability.GetMWidth(stability.GetMWidthRequest(loop=stability.LoopParameters(delay_s=0.00025)))
        self.assertLess(server.state().m_width.robust.max, late.m_width.nominal.max)
        self.assertGreater(server.state().m_width.nominal.max, late.m_width.nominal.max)
        mass = 1.2 * difference.max
        lease = server.acquire(10)
        server.start(lease)
        answer = server.set_mass(lease, mass, ramp=seconds(0))
        self.assertGreater(answer.stability.margins.gain_db, 3)
        wait_for(lambda: server.state().mass == mass)
        columns = self.columns(server, 4000)
        self.assertEqual(set(columns["state"]), {rendering.STATE_RENDERING})
        self.assertEqual(set(columns["mass"]), {mass})
        # Felt as predicted: the force is the mass times the estimate, and the hand's own motion moves it.
        for acceleration, force in zip(columns["acceleration"], columns["force"]):
            self.assertAlmostEqual(force, mass * acceleration, delta=0.00051)
        self.assertGreater(max(abs(counts) for counts in columns["acceleration_counts"]), 100)
        error, details = refused(lambda: server.set_mass(lease, 1.001 * own.max))
        self.assertEqual(error.code(), grpc.StatusCode.FAILED_PRECONDITION)
        self.assertEqual(details["ErrorInfo"].reason, "UNSTABLE_MASS")
        self.assertEqual(server.state().mass, mass)

    def test_the_perceived_mass_is_predicted_and_simulated_alike(self):
        server = self.serve("filtered-accelerometer")
        for share in (0.3, -0.5):
            mass = share * server.state().m_width.admitted.max if share > 0 else \
                -share * server.state().m_width.admitted.min
            answer = server.stability.GetAccuracy(stability.GetAccuracyRequest(mass=mass, simulate=True)).accuracy
            self.assertAlmostEqual(answer.simulated_perceived_mass / answer.perceived_mass, 1, delta=0.02)
            self.assertGreater(answer.force_noise, 0)

    def test_the_filter_changes_to_the_accelerometer_and_back_while_a_mass_is_rendered(self):
        server = self.serve("filtered-difference")
        self.assertEqual(server.rendering.GetState(rendering.GetStateRequest()).axes[0].info.acceleration_quantum,
                         QUANTUM)
        lease = server.acquire(10)
        server.start(lease)
        server.set_mass(lease, 0.02, ramp=seconds(0))
        for estimator in (stability.ESTIMATOR_KIND_ACCELEROMETER, stability.ESTIMATOR_KIND_FILTERED_DIFFERENCE):
            answer = server.set_filter(lease, 10, estimator=estimator)
            self.assertEqual(answer.loop.estimator, estimator)
            self.assertEqual(answer.loop.accelerometer_bandwidth_hz, BANDWIDTH_HZ)
            wait_for(lambda: server.state().mass == 0.02)
        self.assertEqual(server.state().state, rendering.STATE_RENDERING)


class NoAccelerometerTest(unittest.TestCase):
    def test_an_axis_without_one_refuses_the_filter_with_the_reason(self):
        server = self.enterContext(ServerProcess("--config", "paper", "--simulation-speed", 1))
        lease = server.acquire(10)
        error, details = refused(
            lambda: server.set_filter(lease, 10, estimator=stability.ESTIMATOR_KIND_ACCELEROMETER))
        self.assertEqual(error.code(), grpc.StatusCode.INVALID_ARGUMENT)
        self.assertIn("no accelerometer", error.details())


if __name__ == "__main__":
    unittest.main()
