"""One server with two axes: what each has to itself, and what they share."""

import pathlib
import tempfile
import threading
import unittest

from server_process import ServerProcess, grpc, rendering, seconds

from mwidth.v1 import stability_pb2 as stability
from mwidth.v1 import telemetry_pb2 as telemetry

CONFIG = pathlib.Path(__file__).parents[2] / "deploy/config"
AXES = ["elbow", "paper"]
MASS = {"elbow": 0.05, "paper": 0.1}


def of_both():
    """The shipped axes in one configuration."""
    elbow, paper = ((CONFIG / f"{name}.toml").read_text() for name in AXES)
    return elbow + paper[paper.index("\n[[axis]]"):]


class SeveralAxesTest(unittest.TestCase):
    def setUp(self):
        file = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory())) / "both.toml"
        file.write_text(of_both())
        self.server = self.enterContext(ServerProcess("--config", file, "--simulation-speed", 1))
        self.leases = {}

    def states(self):
        answer = self.server.rendering.GetState(rendering.GetStateRequest())
        return {axis.info.name: axis for axis in answer.axes}

    def render(self, axis):
        service = self.server.rendering
        if axis not in self.leases:
            request = rendering.AcquireControlRequest(axis=axis, client_name="test", ttl=seconds(20))
            self.leases[axis] = service.AcquireControl(request).lease.lease_id
        request = {"axis": axis, "lease_id": self.leases[axis]}
        if self.states()[axis].state == rendering.STATE_FAULT:
            service.ClearFault(rendering.ClearFaultRequest(**request))
        service.StartRendering(rendering.StartRenderingRequest(**request))
        service.SetMass(rendering.SetMassRequest(**request, mass=MASS[axis], ramp=seconds(0)))

    def test_each_axis_has_its_own_lease_mass_limits_and_loop(self):
        self.render("elbow")
        states = self.states()
        self.assertEqual(list(states), AXES, "in the order of the configuration")
        self.assertEqual(states["elbow"].state, rendering.STATE_RENDERING)
        self.assertEqual(states["elbow"].controller, "test")
        self.assertEqual(states["paper"].state, rendering.STATE_IDLE)
        self.assertEqual(states["paper"].controller, "")
        self.assertEqual(states["elbow"].info.kind, rendering.AXIS_KIND_ROTARY)
        self.assertEqual(states["paper"].info.kind, rendering.AXIS_KIND_LINEAR)
        self.assertNotEqual(states["elbow"].m_width, states["paper"].m_width)
        self.render("paper")
        with self.assertRaises(grpc.RpcError) as caught:  # A lease is of one axis.
            self.server.rendering.SetMass(
                rendering.SetMassRequest(axis="paper", lease_id=self.leases["elbow"], mass=0.1))
        self.assertEqual(caught.exception.code(), grpc.StatusCode.FAILED_PRECONDITION)
        for axis, state in self.states().items():
            self.assertEqual((state.state, state.target_mass), (rendering.STATE_RENDERING, MASS[axis]))

    def test_each_axis_has_its_own_stream(self):
        for axis in AXES:
            self.render(axis)
        for axis in AXES:
            stream = self.server.telemetry.StreamSamples(telemetry.StreamSamplesRequest(axis=axis, max_batch=20))
            ticks = []
            for _ in range(10):
                batch = next(stream).batch
                ticks += range(batch.first_tick, batch.first_tick + len(batch.mass))
                self.assertLessEqual(set(batch.mass), {0, MASS[axis]})
            stream.cancel()
            self.assertEqual(ticks, list(range(ticks[0], ticks[0] + len(ticks))))

    def test_a_fault_or_an_end_of_one_axis_is_not_the_others(self):
        for axis in AXES:
            self.render(axis)
        self.server.rendering.ReleaseControl(
            rendering.ReleaseControlRequest(axis="paper", lease_id=self.leases["paper"]))
        states = self.states()
        self.assertEqual(states["paper"].state, rendering.STATE_READY)
        self.assertEqual((states["elbow"].state, states["elbow"].mass), (rendering.STATE_RENDERING, MASS["elbow"]))

    def test_an_emergency_stop_stops_every_axis_whichever_it_names(self):
        for name in ("", "elbow", "paper", "misspelt"):
            with self.subTest(name=name):
                for axis in AXES:
                    self.render(axis)
                answer = self.server.rendering.EmergencyStop(rendering.EmergencyStopRequest(axis=name, reason="test"))
                self.assertEqual(list(answer.axes), AXES)
                self.assertEqual(list(answer.states), [rendering.STATE_FAULT] * 2)
                for state in self.states().values():
                    self.assertEqual(state.fault.kind, rendering.FAULT_KIND_EMERGENCY_STOP)
                    self.assertEqual((state.mass, state.force), (0, 0))

    def test_an_emergency_stop_waits_for_no_other_call(self):
        self.render("paper")
        over = threading.Event()

        def storm():
            while not over.is_set():
                request = rendering.SetMassRequest(axis="paper", lease_id=self.leases["paper"], mass=MASS["paper"])
                try:
                    self.server.rendering.SetMass(request)
                except grpc.RpcError:
                    return  # Stopped.

        callers = [threading.Thread(target=storm) for _ in range(8)]
        for caller in callers:
            caller.start()
        before = self.states()["paper"].tick
        self.server.rendering.EmergencyStop(rendering.EmergencyStopRequest(reason="storm"))
        fault = self.states()["paper"].fault
        over.set()
        for caller in callers:
            caller.join()
        self.assertEqual(fault.kind, rendering.FAULT_KIND_EMERGENCY_STOP)
        self.assertLess(fault.tick - before, 1000)

    def test_everything_else_asks_which_axis_and_names_them(self):
        service = self.server.rendering
        for call in (lambda: service.AcquireControl(rendering.AcquireControlRequest(client_name="test")),
                     lambda: service.SetMass(rendering.SetMassRequest(lease_id="x", mass=0)),
                     lambda: service.StartRendering(rendering.StartRenderingRequest(lease_id="x")),
                     lambda: service.ClearFault(rendering.ClearFaultRequest(lease_id="x")),
                     lambda: self.server.stability.GetMWidth(stability.GetMWidthRequest()),
                     lambda: next(self.server.telemetry.StreamSamples(telemetry.StreamSamplesRequest()))):
            with self.assertRaises(grpc.RpcError) as caught:
                call()
            self.assertEqual(caught.exception.code(), grpc.StatusCode.INVALID_ARGUMENT)
            for axis in AXES:
                self.assertIn(axis, caught.exception.details())


if __name__ == "__main__":
    unittest.main()
