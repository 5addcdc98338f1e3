"""mwidth session list, show, recover and verify: what a person and a program see of recorded sessions, without a server."""

import contextlib
import fcntl
import json
import os
import pathlib
import shutil
import tempfile
import unittest

from session_exports_test import flip_a_bit, mwidth, write_session


class SessionCommandTest(unittest.TestCase):
    def setUp(self):
        stack = contextlib.ExitStack()
        self.addCleanup(stack.close)
        self.folder = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory()))

    def session(self, *arguments, code=0, **more):
        result = mwidth("session", *arguments, **more)
        self.assertEqual(result.returncode, code, result.stderr + result.stdout)
        return result

    def test_list_has_every_session_of_the_folder(self):
        write_session(self.folder / "one.sqlite")
        write_session(self.folder / "two.sqlite", "--task", "hold", "--linear")
        (self.folder / "broken.sqlite").write_text("no session")
        (self.folder / "notes.txt").write_text("not looked at")
        listed = self.session("list", "--folder", self.folder)
        lines = listed.stdout.splitlines()
        self.assertEqual(lines[0].split()[:5], ["session", "state", "subject", "task", "run"])
        self.assertEqual(sorted(line.split()[0] for line in lines[1:]), ["broken", "one", "two"])
        # What cannot be read comes last, and says why.
        self.assertTrue(lines[3].startswith("broken"), lines)
        self.assertIn("unreadable", lines[3])
        self.assertIn("broken.sqlite", listed.stderr)
        self.assertRegex(lines[1], r"ended +01/1 .* 2025-11-22 06:30:00 UTC +12\.2\d* s +12000 +\d+ missed, \d+ lost")
        answer = json.loads(self.session("list", "--json", "--folder", self.folder).stdout)
        by_id = {session["session"]: session for session in answer}
        self.assertEqual(by_id["two"]["labels"]["task"], "hold")
        self.assertEqual(by_id["one"]["samples"], 12000)
        ticks = by_id["one"]["last_tick"] - by_id["one"]["first_tick"] + 1
        self.assertEqual(ticks, 12000 + by_id["one"]["missed_ticks"] + by_id["one"]["lost_ticks"])
        self.assertEqual(by_id["broken"]["state"], "unreadable")

    def test_the_folder_may_be_told_by_the_environment_or_be_the_usual_one(self):
        (self.folder / "mwidth-sessions").mkdir()
        write_session(self.folder / "mwidth-sessions" / "one.sqlite")
        environment = {key: value for key, value in os.environ.items() if key != "MWIDTH_SESSIONS"}
        self.assertIn("one ", self.session("list", cwd=self.folder, env=environment).stdout)
        environment["MWIDTH_SESSIONS"] = str(self.folder / "mwidth-sessions")
        self.assertIn("one ", self.session("list", env=environment).stdout)

    def test_show_has_all_that_a_session_says_of_itself(self):
        write_session(self.folder / "one.sqlite")
        text = self.session("show", "one", "--folder", self.folder).stdout
        for part in ("01, visit 1", "reach, run 2", 'Zoë, "the" operator', "elbow, rotary, 1000 Hz", "12000, ticks 1000 to",
                     "trial_start", "strap moved", "energy excess", "the disk was slow", "arm   left",
                     "The wall clock was set", "größer"):
            self.assertIn(part, text)
        # Nothing in it commands the terminal.
        self.assertFalse([c for c in text if ord(c) < 32 and c != "\n"])
        answer = json.loads(self.session("show", "one", "--json", "--folder", self.folder).stdout)
        self.assertEqual(len(answer["markers"]), 7)
        self.assertEqual(len(answer["events"]), 3)
        self.assertEqual(answer["markers"][2]["label"], 'reach, "2"\n')
        self.assertEqual(answer["axis"]["period_s"], 0.001)
        self.assertEqual(answer["file_bytes"], (self.folder / "one.sqlite").stat().st_size)

    def test_a_session_is_named_by_its_file_as_well(self):
        write_session(self.folder / "one.sqlite")
        by_name = self.session("show", "one", "--folder", self.folder).stdout
        self.assertEqual(self.session("show", self.folder / "one.sqlite").stdout, by_name)
        shutil.copy(self.folder / "one.sqlite", self.folder / "copy of one")
        self.assertIn("reach, run 2", self.session("show", self.folder / "copy of one").stdout)

    def test_a_session_that_is_not_there_is_told(self):
        missing = self.session("show", "none", "--folder", self.folder, code=3)
        self.assertIn("there is no session none", missing.stderr)
        self.assertIn("--folder", missing.stderr)
        self.assertIn("there is no folder", self.session("list", "--folder", self.folder / "none", code=3).stderr)

    def test_wrong_command_lines_are_told_as_such(self):
        for arguments in ([], ["export", "one"], ["export", "one", "--to", "x", "--format", "xls"], ["show"], ["verify"],
                          ["shuffle"]):
            self.session(*arguments, code=2)

    def test_verify_names_the_damaged_block_and_the_file_that_is_no_session(self):
        write_session(self.folder / "one.sqlite")
        write_session(self.folder / "two.sqlite")
        self.assertEqual(self.session("verify", "one", "two", "--folder", self.folder).stdout, "one: sound\ntwo: sound\n")
        first, last = flip_a_bit(self.folder / "one.sqlite", 2)
        damaged = self.session("verify", "one", "two", "--folder", self.folder, code=1)
        self.assertIn(f"one: block 2, ticks {first} to {last}: ", damaged.stdout)
        self.assertIn("two: sound\n", damaged.stdout)
        answer = json.loads(self.session("verify", "one", "two", "--json", "--folder", self.folder, code=1).stdout)
        self.assertEqual([session["sound"] for session in answer], [False, True])
        self.assertEqual([block["block"] for block in answer[0]["damaged_blocks"]], [2])
        (self.folder / "broken.sqlite").write_text("no session")
        self.assertIn("broken.sqlite", self.session("verify", self.folder / "broken.sqlite", code=1).stdout)

    def test_recover_closes_what_a_killed_server_left_and_nothing_else(self):
        write_session(self.folder / "ended.sqlite")
        for name in ("killed", "recording"):
            write_session(self.folder / f"{name}.sqlite", "--killed")
        ended = (self.folder / "ended.sqlite").read_bytes()
        # As the server that lives holds it.
        lock = self.folder / "recording.sqlite.lock"
        with open(lock, "w", encoding="ascii") as held:
            fcntl.flock(held, fcntl.LOCK_EX)
            states = self.states()
            self.assertEqual(states, {"ended": "ended", "killed": "open", "recording": "recording"})
            done = self.session("recover", "--folder", self.folder)
            self.assertEqual(done.stdout, "killed: recovered, 12000 samples\n")
            self.assertEqual(self.states(), {"ended": "ended", "killed": "recovered", "recording": "recording"})
            refused = self.session("recover", "recording", "--folder", self.folder, code=1)
            self.assertIn("is being recorded", refused.stderr)
            # It can be read all the same.
            self.session("verify", "recording", "killed", "--folder", self.folder)
        self.assertEqual((self.folder / "ended.sqlite").read_bytes(), ended)
        self.assertEqual(self.session("recover", "ended", "--folder", self.folder).stdout, "ended: is closed already\n")
        answer = json.loads(self.session("recover", "--json", "--folder", self.folder).stdout)
        self.assertEqual(answer, [{"session": "recording", "recovered": True, "message": "recovered, 12000 samples"}])
        self.assertEqual(self.session("recover", "--folder", self.folder).stdout, "No session needs it.\n")
        gaps = json.loads(self.session("show", "killed", "--json", "--folder", self.folder).stdout)["gaps"]
        self.assertIn("the server died", gaps[-1]["reason"])

    def test_recover_tells_what_cannot_be_recovered_and_goes_on(self):
        write_session(self.folder / "killed.sqlite", "--killed")
        (self.folder / "broken.sqlite").write_text("no session")
        failed = self.session("recover", "broken", "killed", "--folder", self.folder, code=3)
        self.assertIn("broken.sqlite", failed.stderr)
        self.assertEqual(failed.stdout, "killed: recovered, 12000 samples\n")

    def states(self):
        listed = json.loads(self.session("list", "--json", "--folder", self.folder).stdout)
        return {session["session"]: session["state"] for session in listed}


if __name__ == "__main__":
    unittest.main()
