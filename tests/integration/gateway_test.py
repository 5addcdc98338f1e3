"""mwidth-drive as a socketcand gateway, with python-can as its clients."""

import contextlib
import tempfile
import time
import unittest
import warnings

import can
from canopen_example import write_config
from emulator_process import Emulator


class GatewayTest(unittest.TestCase):
    def setUp(self):
        self.stack = contextlib.ExitStack()
        self.addCleanup(self.stack.close)
        self.folder = self.stack.enter_context(tempfile.TemporaryDirectory())
        self.gateway = self.stack.enter_context(Emulator("--config", write_config(self.folder, 1)))

    def join(self):
        bus = can.Bus(interface="socketcand", host="127.0.0.1", port=self.gateway.port, channel="can0")
        self.stack.callback(bus.shutdown)
        return bus

    @staticmethod
    def send(bus, identifier, *data):
        bus.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))

    @staticmethod
    def hear(bus):
        """The next frame, but for the message that the emulated node, 1, starts with."""
        frame = bus.recv(10)
        return bus.recv(10) if frame.arbitration_id == 0x701 else frame

    def test_frames_go_to_all_others(self):
        one, two, three = self.join(), self.join(), self.join()
        for sender, others, identifier, data in [(one, [two, three], 0x123, b"\x01\xff"), (two, [one, three], 0x7FF, b"")]:
            self.send(sender, identifier, *data)
            for bus in others:
                frame = self.hear(bus)
                self.assertEqual((frame.arbitration_id, bytes(frame.data)), (identifier, data))
                self.assertAlmostEqual(frame.timestamp, time.time(), delta=60)

    def test_the_emulated_node_is_on_the_bus(self):
        bus, answer, deadline = self.join(), None, time.monotonic() + 30
        # It may still be starting.
        while answer is None or answer.arbitration_id != 0x581:
            self.assertLess(time.monotonic(), deadline)
            self.send(bus, 0x601, 0x40, 0x00, 0x10, 0, 0, 0, 0, 0)
            answer = bus.recv(1)
        self.assertEqual(bytes(answer.data), bytes([0x43, 0, 0x10, 0, 0x92, 1, 2, 0]))

    def test_another_bus_is_not_to_be_had(self):
        # The client forgets to close its socket.
        with warnings.catch_warnings(), self.assertRaises(can.CanError):
            warnings.simplefilter("ignore", ResourceWarning)
            can.Bus(interface="socketcand", host="127.0.0.1", port=self.gateway.port, channel="can1")


if __name__ == "__main__":
    unittest.main()
