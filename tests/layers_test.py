"""The layer table is a law: each folder includes only what stands beneath it."""

import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent

PROTO = ("mwidth/v1/", "google/rpc/", "google/protobuf/", "grpcpp/", "grpc/")
# Folder: prefixes that it may include, besides itself and the standard library.
LAYERS = {
    "server/model": ("Eigen/", "unsupported/Eigen/", "boost/math/", "boost/numeric/interval"),
    "device": ("server/model/", "boost/asio/", "boost/math/", "csv.h", "modbus/modbus.h"),
    # The emulated drive reads the server's own configuration, so that both speak of the same registers.
    "device/emulator": ("device/", "server/model/", "server/config.h", "boost/asio/", "CLI/"),
    "server/exchange": (),
    "server/render": ("server/exchange/", "device/drive.h", "server/model/"),
    "server/gate": ("server/exchange/", "server/model/"),
    # Derived columns are computed again by what computed them first: the estimators and the force law.
    "server/record": ("server/exchange/", "server/model/estimator", "server/render/force_law.h", "server/render/limits.h",
                      "SQLiteCpp/", "sqlite3.h", "zstd.h", "xxhash.h", "hdf5.h", "nlohmann/"),
    # abseil is what gRPC locks with: how is set where gRPC is used.
    "server/rpc": ("server/gate/", "server/record/", "server/model/", "server/exchange/", "absl/synchronization/mutex.h")
    + PROTO,
    # Reads the host's own files and nothing of the server's, so that it can judge a host before anything runs.
    "server/doctor": ("nlohmann/",),
    "client": ("server/model/", "CLI/", "nlohmann/") + PROTO,
    # Files of sessions, read without a server.
    "client/cli/session": ("client/cli/", "server/model/", "server/record/", "server/exchange/crossing.h", "CLI/",
                           "nlohmann/"),
    # The server's services without a server, for the command line: the same code is the only way to the same numbers.
    "client/cli/offline": ("client/", "server/") + PROTO,
    # The server's links without a server, for `mwidth drive probe`.
    "client/cli/drive": ("device/", "server/config.h", "server/drive_address.h"),
    "server": ("server/", "device/", "toml++/", "CLI/"),
}
# The loop's folder: nothing that locks, and no streams.
FORBIDDEN = {"server/render": {"mutex", "shared_mutex", "condition_variable", "iostream", "sstream", "fstream"}}
# POSIX and Linux headers belong to the platform as the standard library does.
SYSTEM = re.compile(r"(sys/|linux/(can/)?|netinet/|net/)?[a-z0-9_]+(\.h)?$")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def layer_of(path):
    folder = path.parent
    while folder.as_posix() not in LAYERS:
        folder = folder.parent
    return folder.as_posix()


def stray_includes(relative, text):
    """Includes of one file that its layer may not have, as (line, header)."""
    layer = layer_of(pathlib.PurePosixPath(relative))
    allowed = LAYERS[layer] + (layer + "/",)
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        quoted, header = match.group(1) == '"', match.group(2)
        standard = not quoted and SYSTEM.match(header) and header != "csv.h"
        if header in FORBIDDEN.get(layer, ()) or not (standard or header.startswith(allowed)):
            found.append((number, header))
    return found


class LayersTest(unittest.TestCase):
    def test_no_file_includes_what_its_layer_may_not(self):
        stray = []
        count = 0
        for top in ("server", "device", "client"):
            for path in sorted((ROOT / top).rglob("*")):
                if path.suffix in (".h", ".cc"):
                    count += 1
                    relative = path.relative_to(ROOT).as_posix()
                    stray += [f"{relative}:{n}: {h}" for n, h in stray_includes(relative, path.read_text())]
        self.assertGreater(count, 20, "the sources were found")
        self.assertEqual(stray, [])

    def test_a_stray_include_is_found(self):
        for relative, header in [
            ("server/model/plant.h", '"server/gate/control_lease.h"'),
            ("server/exchange/ring.h", '"server/model/plant.h"'),
            ("server/render/tick.cc", "<mutex>"),
            ("server/render/tick.cc", "<grpcpp/grpcpp.h>"),
            ("server/gate/axis_gate.cc", '"device/drive.h"'),
            ("device/drive.h", '"server/render/loop.h"'),
            ("client/cli/report.cc", '"server/rpc/convert.h"'),
        ]:
            self.assertEqual(len(stray_includes(relative, f"#include {header}\n")), 1, f"{relative}: {header}")


if __name__ == "__main__":
    sys.exit(unittest.main())
