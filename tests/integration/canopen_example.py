"""deploy/config/canopen.toml for a drive behind a gateway on this host."""

import pathlib

_EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "deploy" / "config" / "canopen.toml"
_BUS = 'type = "socketcan"\ninterface = "can0"'
# A loop slow enough for a drive that is a process among others, on a host that runs other tests.
_SLOW = [("period_s = 0.001", "period_s = 0.01"), ("cutoff_hz = 20.0", "cutoff_hz = 5.0"),
         ("delay_s = 0.0005", "delay_s = 0.01"), ("reply_deadline_s = 0.0004", "reply_deadline_s = 0.0045"),
         ("watchdog_s = 0.05", "watchdog_s = 0.1"), ("max_missed_ticks = 5", "max_missed_ticks = 16")]


def write_config(folder, port, *replacements):
    """Writes the example for the gateway's port, with (old, new) texts replaced, into the folder; returns its path."""
    text = _EXAMPLE.read_text()
    bus = f'type = "socketcand"\nhost = "127.0.0.1"\nport = {port}\ninterface = "can0"'
    for old, new in [(_BUS, bus), *_SLOW, *replacements]:
        if old not in text:
            raise AssertionError(f"{_EXAMPLE.name} has no '{old}'")
        text = text.replace(old, new, 1)
    path = pathlib.Path(folder) / f"canopen-{port}.toml"
    path.write_text(text)
    return path
