"""SIGKILL of a server that records, at 100 random moments: what its sessions keep."""

import pathlib
import random
import sqlite3
import tempfile
import threading
import time
import unittest

from server_process import ServerProcess

import mwidth
from mwidth.v1 import session_pb2 as v1

KILLS = 100
SEED = 20121
PERIOD_S = 0.001
# What SIGKILL may cost.
BOUND_S = 0.1
WITNESS_STEP_S = 0.005


class Witness:
    """How long this host held a thread up at worst, while a with block ran: what no process on it can be blamed for."""

    def __enter__(self):
        self.stall_s = 0.0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()
        return self

    def _run(self):
        before = time.monotonic()
        while not self._over.wait(WITNESS_STEP_S):
            now = time.monotonic()
            self.stall_s = max(self.stall_s, now - before - WITNESS_STEP_S)
            before = now

    def __exit__(self, *_):
        self._over.set()
        self._thread.join()


class Watcher:
    """The first and the newest tick that a server has streamed."""

    def __init__(self, client):
        self.first_tick = self.tick = 0
        self._stream = client.stream()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self):
        try:
            for batch in self._stream:
                self.first_tick = self.first_tick or int(batch.tick[0])
                self.tick = int(batch.tick[-1])
        except mwidth.Error:
            pass

    def join(self):
        self._thread.join()


def kill_one(folder, after_s):
    """Session id, what was streamed before the kill, and the host's worst stall meanwhile."""
    server = ServerProcess("--config", "paper", "--sessions", folder)
    try:
        with mwidth.Client(server.address) as client, Witness() as witness:
            session = client.session(subject="sub-01", task="kill")
            watcher = Watcher(client)
            session.mark("begun")
            time.sleep(after_s)
            server.process.kill()
            watcher.join()
        return session.session_id, watcher, witness.stall_s
    finally:
        server.kill()


class SessionKillTest(unittest.TestCase):
    def check_tables(self, file):
        """As somebody sees it who has nothing but SQLite."""
        with sqlite3.connect(f"file:{file}?mode=ro", uri=True) as database:
            self.assertEqual(database.execute("PRAGMA integrity_check").fetchall(), [("ok",)])
            numbers = [number for (number,) in database.execute("SELECT number FROM blocks ORDER BY number")]
        self.assertEqual(numbers, list(range(1, len(numbers) + 1)), "blocks are numbered one after the other")
        database.close()

    def test_costs_at_most_a_tenth_of_a_second_and_no_file(self):
        moments = random.Random(SEED)
        with tempfile.TemporaryDirectory() as folder:
            killed = [kill_one(folder, moments.uniform(0, 0.4)) for _ in range(KILLS)]
            with ServerProcess("--config", "paper", "--sessions", folder) as server, \
                    mwidth.Client(server.address) as client:
                listed = {each.session_id: each for each in client.sessions()}
                self.assertEqual(set(listed), {session_id for session_id, _, _ in killed})
                losses = []
                for session_id, streamed, stall_s in killed:
                    session = listed[session_id]
                    self.assertEqual(session.state, v1.SESSION_STATE_RECOVERED, session_id)
                    # Gaps may also stand before the first sample.
                    self.assertGreaterEqual(session.samples + session.missed_ticks + session.lost_ticks,
                                            session.last_tick - session.first_tick + 1 if session.samples else 0,
                                            "every tick is a sample or in a gap")
                    newest = session.last_tick if session.samples else streamed.first_tick - 1
                    losses.append(max(0, streamed.tick - newest) * PERIOD_S)
                    self.assertLessEqual(losses[-1], BOUND_S + stall_s, f"{session_id}, a stall of {stall_s} s")
                    if session.samples:
                        read = client.read_session(session_id).samples()
                        self.assertEqual(len(read), session.samples)
                        self.assertTrue((read.tick[1:] > read.tick[:-1]).all())
                    self.check_tables(pathlib.Path(folder, session_id + ".sqlite"))
                recorded = sum(session.samples for session in listed.values())
        self.assertGreater(recorded, KILLS * 50, "they did record")
        print(f"lost by SIGKILL, of {KILLS}: at most {1e3 * max(losses):.0f} ms, "
              f"{1e3 * sum(losses) / KILLS:.0f} ms on average")


if __name__ == "__main__":
    unittest.main()
