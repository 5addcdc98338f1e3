"""A CiA 402 torque drive on a joint held by a hand, in the manner of deploy/config/canopen.toml, written with python-can.

python_can_node.py PORT NODE [INDEX=VALUE ...]: joins the bus behind the socketcand gateway at PORT of this host, prints
"serving", and prints what it comes to. INDEX=VALUE, in hexadecimal, changes an object; an empty VALUE removes it. A line
on standard input is an emergency with this code, in hexadecimal.
"""

import contextlib
import math
import os
import select
import struct
import sys
import time

import can

POSITION_QUANTUM = 7.1585e-5
# N m at the joint of a thousandth of the rated torque: the motor's 0.25 N m and a gear of 50.
TORQUE_QUANTUM = 0.25 * 50 / 1000
# Device and hand of the configuration: inertia, damping, stiffness.
INERTIA, DAMPING, STIFFNESS = 0.2084 + 0.0685, 0.1215 + 1.0, 25.0
STEP_S = 5e-4
STATUSWORDS = {"fault": 0x0218, "disabled": 0x0250, "ready": 0x0231, "switched on": 0x0233, "enabled": 0x0237}


class Joint:
    """Under the motor's torque, and a hand that reaches to and fro."""

    def __init__(self):
        self.position = self.velocity = 0.0
        self.start = self.done = time.monotonic()

    def turn(self, torque):
        now = time.monotonic()
        while self.done < now:
            self.done += STEP_S
            hand = 0.25 * (1 - math.cos(2 * math.pi * 0.7 * (self.done - self.start)))
            acceleration = (torque - DAMPING * self.velocity + STIFFNESS * (hand - self.position)) / INERTIA
            self.velocity += STEP_S * acceleration
            self.position += STEP_S * self.velocity


class Node:
    def __init__(self, bus, number, objects):
        self.bus, self.number, self.joint = bus, number, Joint()
        self.device = {(0x6007, 0): (1, "<h"), (0x6040, 0): (0, "<H"), (0x605A, 0): (2, "<h"), (0x6060, 0): (0, "<b"),
                       (0x6061, 0): (0, "<b"), (0x6072, 0): (1000, "<H"), (0x6076, 0): (250, "<I"),
                       (0x60C2, 1): (1, "<B"), (0x60C2, 2): (-3, "<b"), (0x1000, 0): (0x00020192, "<I")}
        for index, value in objects:
            if value is None:
                del self.device[index, 0]
            else:
                self.device[index, 0] = (value, self.device[index, 0][1])
        self.state, self.torque, self.controlword, self.waiting = "disabled", 0, 0, None
        self.reset()

    def reset(self):
        """Communication as after switching on."""
        self.communication = {(0x1016, 1): (0, "<I"), (0x1017, 0): (0, "<H")}
        for base, count in ((0x1400, 0x1600), (0x1800, 0x1A00)):
            self.communication |= {(base, 1): (0x80000000, "<I"), (base, 2): (255, "<B"), (count, 0): (0, "<B")}
            self.communication |= {(count, entry): (0, "<I") for entry in (1, 2, 3)}
        self.nmt, self.heard, self.beat = 0x7F, None, 0.0
        self.send(0x700, bytes([0]))

    def send(self, base, data):
        self.bus.send(can.Message(arbitration_id=base + self.number, data=data, is_extended_id=False))

    def value(self, *key):
        return self.communication[key][0]

    def go(self, state):
        if state != self.state:
            self.state = state
            print(state, flush=True)

    def emergency(self, code):
        self.go("fault")
        self.send(0x080, struct.pack("<HB5x", code, 1))

    def sdo(self, data):
        command, index, subindex = data[0], *struct.unpack_from("<HB", data, 1)
        key = (index, subindex)
        table = self.communication if key in self.communication else self.device
        if key not in table:
            self.send(0x580, struct.pack("<BHBI", 0x80, index, subindex, 0x06020000))
            return
        value, form = table[key]
        size = struct.calcsize(form)
        if command == 0x40:
            self.send(0x580, struct.pack("<BHB", 0x43 | 4 - size << 2, index, subindex)
                      + struct.pack(form, value).ljust(4, b"\0"))
            return
        table[key] = (struct.unpack_from(form, data, 4)[0], form)
        if key == (0x6060, 0):
            self.device[0x6061, 0] = (table[key][0], "<b")
        if key == (0x6040, 0):
            self.command(struct.pack("<Hh", table[key][0], 0))
        self.send(0x580, struct.pack("<BHB4x", 0x60, index, subindex))

    def command(self, data):
        before, (self.controlword, self.torque) = self.controlword, struct.unpack("<Hh", data[:4])
        word = self.controlword & 0x0F
        if self.state == "fault":
            if self.controlword & ~before & 0x80:
                self.go("disabled")
        elif not word & 0x02:
            self.go("disabled")
        elif word == 0x06:
            self.go("ready")
        elif word == 0x07 and self.state == "ready":
            self.go("switched on")
        elif word == 0x0F and self.state == "switched on":
            self.go("enabled")

    def sync(self):
        if self.waiting is not None:
            self.command(self.waiting)
            self.waiting = None
        self.turn()
        mapped = [self.value(0x1A00, entry) for entry in range(1, self.value(0x1A00, 0) + 1)]
        if mapped == [0x60410010, 0x60640020, 0x60770010] and self.value(0x1800, 2) == 1:
            counts = round(self.joint.position / POSITION_QUANTUM)
            self.send(0x180, struct.pack("<Hih", STATUSWORDS[self.state], counts, self.acting()))

    def acting(self):
        return self.torque if self.state == "enabled" and self.device[0x6061, 0][0] == 10 else 0

    def turn(self):
        """What happens as time passes: the joint, our heartbeat, and whether the master's came."""
        self.joint.turn(TORQUE_QUANTUM * self.acting())
        now = time.monotonic()
        period_ms = self.value(0x1017, 0)
        if period_ms and now - self.beat >= 1e-3 * period_ms:
            self.beat = now
            self.send(0x700, bytes([self.nmt]))
        timeout_ms = self.value(0x1016, 1) & 0xFFFF
        if self.heard and timeout_ms and now - self.heard > 1e-3 * timeout_ms:
            self.heard = None
            self.emergency(0x8130)

    def hear(self, message):
        identifier, data = message.arbitration_id, bytes(message.data)
        if identifier == 0x000 and data[1] in (0, self.number):
            if data[0] in (0x81, 0x82):
                self.reset()
            else:
                self.nmt = {0x01: 0x05, 0x02: 0x04, 0x80: 0x7F}[data[0]]
        elif identifier == 0x080 and self.nmt == 0x05:
            self.sync()
        elif identifier == 0x200 + self.number and self.nmt == 0x05:
            if self.value(0x1400, 2) == 255:
                self.command(data)
            else:
                self.waiting = data
        elif identifier == 0x600 + self.number:
            self.sdo(data)
        elif identifier == 0x700 + (self.value(0x1016, 1) >> 16 & 0x7F):
            self.heard = time.monotonic()


def main(port, number, *objects):
    # A drive has a processor of its own, which this one can only ask for.
    with contextlib.suppress(PermissionError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(40))
    changes = [(int(index, 16), int(value, 16) if value else None)
               for index, _, value in (argument.partition("=") for argument in objects)]
    with can.Bus(interface="socketcand", channel="can0", host="127.0.0.1", port=int(port)) as bus:
        node = Node(bus, int(number), changes)
        print("serving", flush=True)
        while True:
            message = bus.recv(0.001)
            if message is not None:
                node.hear(message)
            node.turn()
            if select.select([sys.stdin], [], [], 0)[0] and (line := sys.stdin.readline()):
                node.emergency(int(line, 16))


if __name__ == "__main__":
    main(*sys.argv[1:])
