"""Runs mwidth-drive as a user would."""

import subprocess

from server_process import BUILD


class Emulator:
    """A running mwidth-drive, on any free port."""

    def __init__(self, *arguments):
        self.process = subprocess.Popen([BUILD / "bin" / "mwidth-drive", *map(str, arguments)], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        # Where it listens: HOST:PORT, the name of a device or of an interface.
        self.place = self.line().rsplit(" ", 1)[1]

    @property
    def port(self):
        return int(self.place.rsplit(":", 1)[1])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        self.process.stdin.close()
        self.process.stdout.close()

    def line(self):
        """The next line that it says."""
        line = self.process.stdout.readline()
        if not line:
            raise AssertionError(f"mwidth-drive ended with exit code {self.process.wait()}")
        return line.strip()

    def say(self, command):
        """Gives a command; returns the answer."""
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()
        return self.line()
