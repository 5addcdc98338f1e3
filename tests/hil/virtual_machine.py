"""A virtual machine that boots Debian's real-time kernel with a few programs of this build, and nothing else.

Its time is that of its instructions, not of this host (qemu's -icount): however busy the host is, no tick in the machine
comes late. What a test sees there is the programs' own doing.
"""

import os
import pathlib
import shutil
import subprocess
import tempfile

FOLDER = pathlib.Path(__file__).resolve().parent
BUILD = pathlib.Path(os.environ["MWIDTH_BUILD"])
KERNEL = FOLDER.parents[1] / "build" / "kernel"

# CAN: raw sockets, the virtual bus, and the driver of the emulated cards. 9p: the folder shared with the host.
MODULES = ("can-raw", "vcan", "kvaser_pci", "virtio_pci", "9pnet_virtio", "9p")

# Two CAN controllers, each a PCI card with a Linux driver of its own, wired to one bus.
CAN_CARDS = ("-object", "can-bus,id=bus", "-device", "kvaser_pci,canbus=bus", "-device", "kvaser_pci,canbus=bus")

# In a script: brings up vcan0, a bus of the kernel's own, and the two controllers, can0 and can1.
CAN_INTERFACES = """
/programs/ip link add dev vcan0 type vcan && /programs/ip link set vcan0 up || exit 1
for card in can0 can1; do
  /programs/ip link set $card type can bitrate 1000000 && /programs/ip link set $card up || exit 1
done
"""

# A nanosecond an instruction; while the machine has nothing to do, its time runs on at once.
TIME = ("-icount", "shift=0,sleep=off")

INIT = """#!/bin/busybox sh
/bin/busybox --install -s /bin
export PATH=/programs:/bin HOME=/
mount -t proc proc /proc; mount -t sysfs sysfs /sys; mount -t devtmpfs devtmpfs /dev
mkdir -p /dev/pts /dev/shm; mount -t devpts devpts /dev/pts; mount -t tmpfs tmpfs /dev/shm
for module in $(cat /modules/order); do insmod /modules/$module; done
/programs/ip link set lo up
mount -t 9p -o trans=virtio,msize=262144 shared /shared
# In memory: the host's disk takes time of the host's, which is not the machine's.
cp -r /shared/. /session; cd /session
sh guest.sh </dev/null >output 2>&1
echo $? >code
cp -r . /shared; sync; poweroff -f
"""


def loading_order(modules):
    """Paths of the modules and of all that they need, each after what it needs."""
    paths = {path.stem.replace("-", "_"): path for path in KERNEL.glob("lib/modules/*/kernel/**/*.ko")}
    order = []

    def add(name):
        path = paths[name.replace("-", "_")]
        if path not in order:
            needed = subprocess.run(["/sbin/modinfo", "-F", "depends", path], capture_output=True, text=True, check=True)
            for other in filter(None, needed.stdout.strip().split(",")):
                add(other)
            order.append(path)

    for module in modules:
        add(module)
    return order


def libraries_of(program):
    """The shared libraries that a program is linked with, its loader among them."""
    listed = subprocess.run(["ldd", program], capture_output=True, text=True, check=True).stdout
    return {word for line in listed.splitlines() for word in line.split() if word.startswith("/")}


def make_root(root, programs):
    """The first file system of the machine: modules in /modules, programs in /programs."""
    for folder in ("bin", "dev", "modules", "proc", "programs", "session", "shared", "sys", "tmp"):
        (root / folder).mkdir()
    shutil.copy("/bin/busybox", root / "bin/busybox")
    modules = loading_order(MODULES)
    for module in modules:
        shutil.copy(module, root / "modules")
    (root / "modules/order").write_text("\n".join(module.name for module in modules))
    for program in (*programs, "/sbin/ip"):
        shutil.copy(program, root / "programs")
    for library in set().union(*map(libraries_of, (*programs, "/sbin/ip"))):
        target = root / library.lstrip("/")
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(library, target)
    (root / "init").write_text(INIT)
    (root / "init").chmod(0o755)


def pack(root, image):
    names = "\n".join(str(path.relative_to(root)) for path in sorted(root.rglob("*")))
    with image.open("wb") as file:
        subprocess.run(["cpio", "--quiet", "-o", "-H", "newc"], cwd=root, input=names.encode(), stdout=file, check=True)


def run(programs, script, shared, timeout_s):
    """Runs a shell script as root in a machine that has `programs` in its path.

    The script works in a copy of the folder `shared`, which comes back with what it wrote. Returns what it
    printed; raises AssertionError where it failed.
    """
    subprocess.run([FOLDER / "kernel", KERNEL], check=True, stdout=subprocess.DEVNULL)
    (shared / "guest.sh").write_text(script)
    with tempfile.TemporaryDirectory() as folder:
        root, image = pathlib.Path(folder, "root"), pathlib.Path(folder, "image")
        root.mkdir()
        make_root(root, programs)
        pack(root, image)
        console = subprocess.run(
            ["qemu-system-x86_64", "-machine", "q35", "-cpu", "max", "-m", "1024", *TIME, "-nodefaults", "-no-reboot",
             "-display", "none", "-serial", "stdio", *CAN_CARDS,
             "-virtfs", f"local,path={shared},mount_tag=shared,security_model=none",
             "-kernel", next(KERNEL.glob("boot/vmlinuz-*")), "-initrd", image,
             "-append", "console=ttyS0 quiet panic=-1"],
            capture_output=True, text=True, errors="replace", timeout=timeout_s, stdin=subprocess.DEVNULL)
    output, code = shared / "output", shared / "code"
    printed = output.read_text() if output.exists() else ""
    ended = code.read_text().strip() if code.exists() else "none"
    if ended != "0":
        raise AssertionError(f"the machine failed, exit code {ended}:\n{printed}\nconsole:\n{console.stdout}{console.stderr}")
    return printed
