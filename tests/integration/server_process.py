"""Runs mwidthd as a user would, and talks to it with Python's grpcio."""

import os
import pathlib
import subprocess
import sys

BUILD = pathlib.Path(os.environ["MWIDTH_BUILD"])
sys.path.insert(0, str(BUILD / "python"))

import grpc  # noqa: E402
from google.protobuf import duration_pb2  # noqa: E402

from mwidth.v1 import rendering_pb2 as rendering  # noqa: E402
from mwidth.v1 import rendering_pb2_grpc, stability_pb2_grpc, telemetry_pb2_grpc  # noqa: E402

START_TIMEOUT_S = 30


def seconds(value):
    """A protobuf Duration."""
    duration = duration_pb2.Duration()
    duration.FromNanoseconds(int(value * 1e9))
    return duration


class ServerProcess:
    """A running mwidthd on a free port. As a context manager it ends with SIGTERM and exit code 0."""

    def __init__(self, *arguments, environment=None):
        self.process = subprocess.Popen(
            [BUILD / "bin" / "mwidthd", "--listen", "127.0.0.1:0", *map(str, arguments)],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
            env=os.environ | (environment or {}))
        self.address = self._address()
        self.channel = grpc.insecure_channel(self.address)
        self.rendering = rendering_pb2_grpc.RenderingServiceStub(self.channel)
        self.stability = stability_pb2_grpc.StabilityServiceStub(self.channel)
        self.telemetry = telemetry_pb2_grpc.TelemetryServiceStub(self.channel)

    def _address(self):
        for line in self.process.stdout:
            if line.startswith("listening on "):
                return line.split()[-1]
        raise RuntimeError(f"mwidthd ended with exit code {self.process.wait()} before it listened")

    def __enter__(self):
        return self

    def __exit__(self, exception, *_):
        self.channel.close()
        self.process.terminate()
        code = self.process.wait(timeout=START_TIMEOUT_S)
        self.process.stdout.close()
        if exception is None and code != 0:
            raise AssertionError(f"mwidthd ended with exit code {code}")

    def kill(self):
        """Ends it with SIGKILL, in place of the context manager's end."""
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()
        self.channel.close()

    def state(self):
        """AxisState of the only axis."""
        return self.rendering.GetState(rendering.GetStateRequest()).axes[0]

    def acquire(self, ttl_s=10, name="test"):
        """Lease id of the only axis."""
        request = rendering.AcquireControlRequest(client_name=name, ttl=seconds(ttl_s))
        return self.rendering.AcquireControl(request).lease.lease_id

    def start(self, lease_id):
        return self.rendering.StartRendering(rendering.StartRenderingRequest(lease_id=lease_id))

    def set_filter(self, lease_id, cutoff_hz, **more):
        return self.rendering.SetFilter(rendering.SetFilterRequest(lease_id=lease_id, cutoff_hz=cutoff_hz, **more))

    def set_mass(self, lease_id, mass, **more):
        return self.rendering.SetMass(rendering.SetMassRequest(lease_id=lease_id, mass=mass, **more))
