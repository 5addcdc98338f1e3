"""deploy/config/modbus.toml for a drive on this host."""

import pathlib

_EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "deploy" / "config" / "modbus.toml"
# A loop slow enough for a drive that is a process among others, on a host that runs other tests.
_SLOW = [("period_s = 0.002", "period_s = 0.01"), ("cutoff_hz = 20.0", "cutoff_hz = 5.0"),
         ("delay_s = 0.001", "delay_s = 0.01"), ("reply_deadline_s = 0.0008", "reply_deadline_s = 0.0045"),
         ("max_missed_ticks = 5", "max_missed_ticks = 16")]


def write_config(folder, port, *replacements):
    """Writes the example for the port, with (old, new) texts replaced, into the folder; returns its path."""
    text = _EXAMPLE.read_text()
    here = [('host = "192.168.0.10"', 'host = "127.0.0.1"'), ("port = 502", f"port = {port}")]
    for old, new in [*here, *_SLOW, *replacements]:
        if old not in text:
            raise AssertionError(f"{_EXAMPLE.name} has no '{old}'")
        text = text.replace(old, new, 1)
    path = pathlib.Path(folder) / f"modbus-{port}.toml"
    path.write_text(text)
    return path
