"""A thousand connections that all want a stream: what mwidthd gives, refuses, and needs for it."""

import pathlib
import re
import resource
import socket
import tempfile
import unittest

from server_process import ServerProcess

import grpc.experimental  # noqa: E402
from google.rpc import error_details_pb2, status_pb2
from mwidth.v1 import telemetry_pb2 as telemetry
from mwidth.v1 import telemetry_pb2_grpc

from control_test import wait_for

CONFIG = pathlib.Path(__file__).parents[2] / "deploy/config/paper.toml"
CONNECTIONS = 1000
MAX_STREAMS = 300
# Ten times as fast as life: what a stuck reader can pile up comes soon.
SPEED = 10
# A sample on the wire, twice: about 60 bytes, were no batch shared.
SAMPLE_BYTES = 125
# A connection of gRPC with one call, twice: 64 KB may be on their way.
CONNECTION_BYTES = 128 * 1024
CHANNEL_OPTIONS = [
    # A connection of its own.
    ("grpc.use_local_subchannel_pool", 1),
    # No thread that reads ahead, and no window that grows: who does not read takes 64 KB and no more.
    (grpc.experimental.ChannelOptions.SingleThreadedUnaryStream, 1),
    ("grpc.http2.bdp_probe", 0),
]
HTTP2_PREFACE_AND_SETTINGS = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + b"\0\0\0\x04\0\0\0\0\0"


def most_resident_bytes(process):
    """The most memory that the process has had so far."""
    status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
    return 1024 * int(re.search(r"VmHWM:\s+(\d+)", status).group(1))


def begun(call):
    """True where a sample came, False where there were too many streams already."""
    try:
        next(call)
        return True
    except grpc.RpcError as error:
        if error.code() != grpc.StatusCode.RESOURCE_EXHAUSTED:
            raise
        details = dict(error.trailing_metadata())["grpc-status-details-bin"]
        info = error_details_pb2.ErrorInfo()
        if not status_pb2.Status.FromString(details).details[0].Unpack(info) or info.reason != "TOO_MANY_STREAMS":
            raise
        return False


class ManyStreamsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        # Both ends of every connection: this process has one each, as has the server, which inherits the limit.
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        files = 4 * CONNECTIONS
        if hard < files:
            raise unittest.SkipTest(f"only {hard} files may be open")
        resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, files), hard))

    def serve(self, queue_samples):
        text = CONFIG.read_text()
        for key, value in (("max_streams", MAX_STREAMS), ("stream_queue_samples", queue_samples)):
            text, count = re.subn(rf"^{key} = .*$", f"{key} = {value}", text, flags=re.MULTILINE)
            self.assertEqual(count, 1)
        file = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory())) / "many.toml"
        file.write_text(text)
        return self.enterContext(ServerProcess("--config", file, "--simulation-speed", SPEED))

    def stream(self, server, **request):
        channel = grpc.insecure_channel(server.address, options=CHANNEL_OPTIONS)
        self.enterContext(channel)
        return telemetry_pb2_grpc.TelemetryServiceStub(channel).StreamSamples(
            telemetry.StreamSamplesRequest(**request))

    def test_the_cap_holds_among_a_thousand_connections_and_memory_is_bounded(self):
        queue_samples = 2000
        server = self.serve(queue_samples)
        before = most_resident_bytes(server.process)
        calls = [self.stream(server, min_batch=100) for _ in range(CONNECTIONS)]
        streaming = [call for call in calls if begun(call)]
        self.assertEqual(len(streaming), MAX_STREAMS)
        # One reads on, so long that the windows and queues of all others, who do not, are full.
        reader = streaming[0]
        end = next(reader).batch.first_tick + 10 * queue_samples
        while next(reader).batch.first_tick < end:
            pass
        bound = CONNECTIONS * CONNECTION_BYTES + MAX_STREAMS * queue_samples * SAMPLE_BYTES
        grown = most_resident_bytes(server.process) - before
        print(f"{CONNECTIONS} connections, {MAX_STREAMS} streams: from {before / 1e6:.0f} MB by {grown / 1e6:.0f} MB, "
              f"at most {bound / 1e6:.0f} MB allowed")
        self.assertLess(grown, bound)
        # Whoever leaves makes room.
        streaming[1].cancel()
        wait_for(lambda: begun(self.stream(server)))

    def test_a_reader_that_stops_loses_samples_alone_and_is_told_how_many(self):
        queue_samples = 30_000
        server = self.serve(queue_samples)
        stuck, live = self.stream(server), self.stream(server)
        stuck_batch, live_batch = next(stuck).batch, next(live).batch
        # More than the window, the transport's buffers and the queue together hold.
        samples = 0
        while samples < 2 * queue_samples:
            following = live_batch.first_tick + len(live_batch.position)
            live_batch = next(live).batch
            self.assertEqual(live_batch.dropped_ticks_before, 0)
            self.assertEqual(live_batch.first_tick, following + live_batch.missed_ticks_before)
            samples += len(live_batch.position)
        lost = 0
        while stuck_batch.first_tick <= live_batch.first_tick:
            following = stuck_batch.first_tick + len(stuck_batch.position)
            stuck_batch = next(stuck).batch
            absent = stuck_batch.missed_ticks_before + stuck_batch.dropped_ticks_before
            self.assertEqual(stuck_batch.first_tick, following + absent)
            lost += stuck_batch.dropped_ticks_before
        print(f"of {samples} samples the stuck reader lost {lost}")
        self.assertGreater(lost, queue_samples / 2)

    def test_connections_that_never_call_nor_read_harm_nobody(self):
        server = self.serve(2000)
        address = server.address.rsplit(":", 1)
        for _ in range(100):
            silent = self.enterContext(socket.create_connection(address))
            silent.sendall(HTTP2_PREFACE_AND_SETTINGS)
        self.assertGreater(len(next(self.stream(server)).batch.position), 0)


if __name__ == "__main__":
    unittest.main()
