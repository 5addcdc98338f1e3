"""A client that renders a mass and renews its lease until it is killed. Argument: the server's address."""

import sys
import time

from server_process import grpc, rendering, rendering_pb2_grpc, seconds

MASS = 0.05

stub = rendering_pb2_grpc.RenderingServiceStub(grpc.insecure_channel(sys.argv[1]))
lease_id = stub.AcquireControl(
    rendering.AcquireControlRequest(client_name="to be killed", ttl=seconds(1))).lease.lease_id
stub.StartRendering(rendering.StartRenderingRequest(lease_id=lease_id))
stub.SetMass(rendering.SetMassRequest(lease_id=lease_id, mass=MASS, ramp=seconds(0)))
while True:
    time.sleep(0.2)
    stub.RenewControl(rendering.RenewControlRequest(lease_id=lease_id))
