"""A mass rendered on a drive that is a process of its own, on a host that may be busy with other tests."""

import contextlib
import time

from server_process import grpc, rendering, seconds

from mwidth.v1 import telemetry_pb2 as telemetry


def _give_up_after(timeout_s, server):
    deadline = time.monotonic() + timeout_s
    while time.monotonic() < deadline:
        yield
    raise AssertionError(f"it did not come: {server.state()}")


def render(server, lease=None):
    """Renders 0.05; tries again where the host was so busy that the drive seemed silent. Returns the lease."""
    lease = lease or server.acquire(ttl_s=60)
    for _ in _give_up_after(30, server):
        try:
            server.start(lease)
            server.set_mass(lease, 0.05, ramp=seconds(0))
            return lease
        except grpc.RpcError:
            time.sleep(0.05)
        with contextlib.suppress(grpc.RpcError):
            server.rendering.ClearFault(rendering.ClearFaultRequest(lease_id=lease))


def samples_until(server, enough):
    """All samples from now until `enough` says so of those that came."""
    joined = telemetry.SampleBatch()
    stream = server.telemetry.StreamSamples(telemetry.StreamSamplesRequest(max_batch=1))
    for response, _ in zip(stream, _give_up_after(60, server)):
        joined.MergeFrom(response.batch)
        if enough(joined):
            stream.cancel()
            return joined
    raise AssertionError("the stream ended")


def undisturbed_samples(server, count):
    """So many samples in a row while a mass is rendered; from the start again where a busy host made a fault."""
    lease, faults = server.acquire(ttl_s=60), []
    for _ in range(10):
        render(server, lease)
        samples = samples_until(server, lambda joined: len(joined.force) >= count or
                                joined.state[-1] == rendering.STATE_FAULT)
        if samples.state[-1] == rendering.STATE_RENDERING:
            return samples
        faults.append(server.state().fault.message)
    raise AssertionError(f"it always ends: {faults}")


def fault_of(server):
    """The fault, once there is one."""
    for _ in _give_up_after(30, server):
        state = server.state()
        if state.state == rendering.STATE_FAULT:
            return state.fault
        time.sleep(0.01)
