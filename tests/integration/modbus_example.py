"""deploy/config/modbus.toml for a drive on this host."""

import pathlib

_EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "deploy" / "config" / "modbus.toml"
_HOST, _PORT, _TYPE = 'host = "192.168.0.10"', "port = 502", 'type = "modbus-tcp"'
# A loop slow enough for a drive that is a process among others, on a host that runs other tests.
_SLOW = [("period_s = 0.002", "period_s = 0.01"), ("cutoff_hz = 20.0", "cutoff_hz = 5.0"),
         ("delay_s = 0.001", "delay_s = 0.01"), ("reply_deadline_s = 0.0008", "reply_deadline_s = 0.0045"),
         ("max_missed_ticks = 5", "max_missed_ticks = 16")]
# One exchange a tick, with all of the tick's time: the kernel carries what is written to a pseudo-terminal over to its
# other end when it has nothing better to do.
_PATIENT = [('exchange = "two-requests"', 'exchange = "read-write"'),
            ("reply_deadline_s = 0.0045", "reply_deadline_s = 0.009")]


def _write(folder, name, replacements):
    text = _EXAMPLE.read_text()
    for old, new in replacements:
        if old not in text:
            raise AssertionError(f"{_EXAMPLE.name} has no '{old}'")
        text = text.replace(old, new, 1)
    path = pathlib.Path(folder) / f"modbus-{name}.toml"
    path.write_text(text)
    return path


def write_config(folder, port, *replacements):
    """Writes the example for the port, with (old, new) texts replaced, into the folder; returns its path."""
    return _write(folder, port, [(_HOST, 'host = "127.0.0.1"'), (_PORT, f"port = {port}"), *_SLOW, *replacements])


def write_rtu_config(folder, device, *replacements):
    """The same for a drive on a pseudo-terminal."""
    serial = [(_TYPE, 'type = "modbus-rtu"'), (_HOST, f'device = "{device}"'), (_PORT, "")]
    return _write(folder, pathlib.Path(device).name, [*serial, *_SLOW, *_PATIENT, *replacements])
