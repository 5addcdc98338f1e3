"""A torque drive on a joint held by a hand, in the manner of deploy/config/modbus.toml, written with pymodbus.

pymodbus_drive.py PORT [WATCHDOG_MS [REACTION]]: prints "serving", then serves Modbus TCP on the loopback interface.
"""

import asyncio
import math
import os
import sys
import time

from pymodbus.datastore import ModbusSequentialDataBlock, ModbusServerContext, ModbusSlaveContext
from pymodbus.server.async_io import StartAsyncTcpServer

POSITION, FORCE, ENABLE, WATCHDOG, REACTION = 100, 200, 300, 400, 401
POSITION_QUANTUM, FORCE_QUANTUM = 7.1585e-5, 0.001
# Device and hand of the configuration: inertia, damping, stiffness.
INERTIA, DAMPING, STIFFNESS = 0.2084 + 0.0685, 0.1215 + 1.0, 25.0
STEP_S = 5e-4


class Registers(ModbusSequentialDataBlock):
    """Holding registers that know when they were last asked for."""

    def __init__(self):
        super().__init__(0, [0] * 500)
        self.asked = time.monotonic()

    def getValues(self, address, count=1):  # noqa: N802: pymodbus's name
        self.asked = time.monotonic()
        return super().getValues(address, count)

    def setValues(self, address, values):  # noqa: N802
        self.asked = time.monotonic()
        super().setValues(address, values)

    def word(self, address):
        return super().getValues(address, 1)[0]

    def put(self, address, *words):
        super().setValues(address, list(words))


def signed16(word):
    return word - 0x10000 if word >= 0x8000 else word


async def turn(registers):
    """The joint, under the motor's torque and a hand that reaches to and fro."""
    position = velocity = 0.0
    start = done = time.monotonic()
    while True:
        await asyncio.sleep(0.001)
        now = time.monotonic()
        if now - registers.asked > 1e-3 * registers.word(WATCHDOG) and registers.word(ENABLE):
            registers.put(ENABLE, 0)
            registers.put(FORCE, 0)
            print("watchdog", flush=True)
        torque = FORCE_QUANTUM * signed16(registers.word(FORCE)) if registers.word(ENABLE) else 0.0
        while done < now:
            done += STEP_S
            hand = 0.25 * (1 - math.cos(2 * math.pi * 0.7 * (done - start)))
            velocity += STEP_S * (torque - DAMPING * velocity + STIFFNESS * (hand - position)) / INERTIA
            position += STEP_S * velocity
        counts = round(position / POSITION_QUANTUM) & 0xFFFFFFFF
        registers.put(POSITION, counts >> 16, counts & 0xFFFF)


async def serve(port, watchdog_ms, reaction):
    registers = Registers()
    registers.put(WATCHDOG, watchdog_ms, reaction)
    context = ModbusServerContext(ModbusSlaveContext(hr=registers, zero_mode=True), single=True)
    task = asyncio.create_task(turn(registers))
    server = await StartAsyncTcpServer(context=context, address=("127.0.0.1", port), defer_start=True)
    serving = asyncio.create_task(server.serve_forever())
    await server.serving
    print("serving", flush=True)
    await asyncio.gather(task, serving)


if __name__ == "__main__":
    try:
        # A drive has a processor of its own.
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(40))
    except PermissionError:
        pass
    asyncio.run(serve(int(sys.argv[1]), *(int(word) for word in (sys.argv[2:] + ["50", "1"][len(sys.argv) - 2:]))))
