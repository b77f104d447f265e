#!/usr/bin/env python3
"""The daemon on the kernel's own IIO drivers, in a virtual machine: `kernel_guest.py PROGRAMS... --folder FOLDER`.

PROGRAMS: stillpointd, stillpoint, virtual_hub. Debian's kernel is fetched into FOLDER and booted by QEMU with nothing but
these programs; init.sh plays the phases, this script judges what it brings back. Code 77: skipped, with the reason.
"""
import argparse
import collections
import csv
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tarfile
import tempfile
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
MODULES = ["virtio_pci", "virtio_blk", "uhid", "hid-sensor-hub", "hid-sensor-accel-3d", "hid-sensor-gyro-3d",
           "hid-sensor-magn-3d"]
CONFIG = """\
source: {kind: iio, devices: [accel_3d, gyro_3d, magn_3d], rate_hz: 200, reopen_at_most_s: 1}
threads: {rehearse_ahead_s: 0, calibration_poll_s: 0.02}
dds: {ros2: false}
"""  # the last two lines spare an emulated processor
DEGREE = 0.017453293  # the kernel's
# Sensor: columns of a recording, axis whose low bits count, unit of a count, value of the axes that stand (None: they turn).
SENSORS = {"accel_3d": ("acc_{}_mps2", "x", 9.80665e-4, {"y": 37, "z": 10000}),
           "gyro_3d": ("gyr_{}_radps", "y", 1e-2 * DEGREE, {"x": -25, "z": 1000}),
           "magn_3d": ("mag_{}_uT", "z", 0.01, {})}
MAGN_DOWN = -4300
KVM = ["-accel", "kvm", "-smp", "2"]
# The guest's clocks count the instructions that were run, 2 ns each: however slow this machine is, the guest is not late.
# Two processors that wait for one another would wait for ever.
EMULATED = ["-accel", "tcg", "-icount", "shift=1,sleep=off", "-smp", "1"]
TURN_RAD = math.radians(10) * 0.005


class Skipped(Exception):
    pass


def run(*command, **more):
    return subprocess.run([str(word) for word in command], check=True, capture_output=True, text=True, **more).stdout


def kernel(folder):
    """Folder of Debian's newest kernel and its modules."""
    if run("dpkg", "--print-architecture").strip() != "amd64":
        raise Skipped("only for amd64: the guest runs the programs of this machine")
    depends = [line.split()[1] for line in run("apt-cache", "depends", "linux-image-amd64").splitlines()
               if "Depends: linux-image-" in line] if known("linux-image-amd64") else []
    if not depends:
        raise Skipped("apt knows no linux-image-amd64 (apt-get update, Debian only)")
    out = folder / depends[0]
    if not list(out.glob("lib/modules/*")) or list(out.glob("*.deb")):  # nothing there, or half of it
        shutil.rmtree(out, ignore_errors=True)
        out.mkdir(parents=True)
        fetched = subprocess.run(["apt-get", "download", depends[0]], cwd=out, check=False, capture_output=True, text=True)
        if fetched.returncode != 0:
            raise Skipped(f"apt-get download {depends[0]}: {fetched.stderr.strip()}")
        extract(out)
    return out


def known(package):
    return subprocess.run(["apt-cache", "show", package], check=False, capture_output=True).returncode == 0


def extract(out):
    """What is not wanted of the package's 400 MB never comes to the disk."""
    package = next(out.glob("*.deb"))
    with subprocess.Popen(["dpkg-deb", "--fsys-tarfile", package], stdout=subprocess.PIPE) as archive:
        subprocess.run(["tar", "-x", "-C", out, "--wildcards", "./boot/vmlinuz-*", "*/kernel/drivers/hid/*.ko",
                        "*/kernel/drivers/iio/*.ko", "*/kernel/drivers/virtio/*.ko", "*/virtio_blk.ko"],
                       stdin=archive.stdout, check=True)
    package.unlink()


def load_order(out):
    """Paths of MODULES and of all that they need, those needed first."""
    found = {path.stem.replace("-", "_"): path for path in out.rglob("*.ko")}
    order = []

    def add(name):
        path = found.get(name.replace("-", "_"))
        if path is None or path in order:  # built in, or had
            return
        field = path.read_bytes().split(b"\0depends=", 1)[1].split(b"\0", 1)[0].decode()
        for needed in filter(None, field.split(",")):
            add(needed)
        order.append(path)

    for module in MODULES:
        add(module)
    return order


def libraries(program):
    """Shared libraries of a program, and what loads them, by their paths; of a static one none."""
    listed = subprocess.run(["ldd", program], check=False, capture_output=True, text=True)
    return {word for line in listed.stdout.splitlines() for word in line.split() if word[0] == "/"}


def cpio(target, files):
    """An archive of the kernel's "newc" form: {path: (mode, bytes)}."""
    with open(target, "wb") as out:
        def entry(name, mode, data):
            head = "070701" + "".join(f"{n:08X}" for n in (entry.count, mode, 0, 0, 1, 0, len(data), 0, 0, 0, 0,
                                                            len(name) + 1, 0))
            entry.count += 1
            for piece in (head.encode() + name.encode() + b"\0", data):
                out.write(piece + b"\0" * (-len(piece) % 4))
        entry.count = 1
        folders = sorted({str(parent) for name in files for parent in pathlib.Path(name).parents} - {"."},
                         key=lambda name: name.count("/"))
        for name in folders:
            entry(name, 0o40755, b"")
        for name, (mode, data) in files.items():
            entry(name, 0o100000 | mode, data)
        entry("TRAILER!!!", 0, b"")


def initramfs(target, kernel_folder, programs):
    files = {"init": (0o755, (HERE / "init.sh").read_bytes()), "config.yaml": (0o644, CONFIG.encode())}
    modules = load_order(kernel_folder)
    files["modules/order"] = (0o644, "\n".join(path.name for path in modules).encode())
    for path in modules:
        files[f"modules/{path.name}"] = (0o644, path.read_bytes())
    for program in programs:
        files[f"bin/{program.name}"] = (0o755, program.read_bytes())
        for library in libraries(program):
            files[library[1:]] = (0o755, pathlib.Path(library).read_bytes())
    cpio(target, files)


def boot(accelerator, kernel_folder, initrd, disk, words, sign_s, limit_s):
    """Runs the guest to its end; its console goes on to ours. False: no sign of life within `sign_s`."""
    command = ["qemu-system-x86_64", "-machine", "q35", *accelerator, "-cpu", "max,arch-capabilities=off",
               "-m", "768", "-nographic", "-no-reboot", "-nic", "none",
               "-kernel", next(kernel_folder.glob("boot/vmlinuz-*")), "-initrd", initrd,
               "-append", f"console=ttyS0 quiet panic=-1 {words}", "-drive", f"file={disk},format=raw,if=virtio"]
    start = time.monotonic()
    # A session of its own: the scheduler shares the processors among sessions, and the guest is as much as all the rest.
    with subprocess.Popen([str(word) for word in command], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, errors="replace", start_new_session=True) as guest:
        timers = [threading.Timer(seconds, guest.kill) for seconds in (sign_s, limit_s)]
        for timer in timers:
            timer.start()
        alive = False
        for line in guest.stdout:
            if "guest: " in line:
                alive = True
                timers[0].cancel()
            print(line.rstrip("\n"), flush=True)
        for timer in timers:
            timer.cancel()
    print(f"the guest ran for {time.monotonic() - start:.0f} s ({' '.join(accelerator)})", flush=True)
    return alive


def run_guest(kernel_folder, programs, words, limit_s, out):
    """What the guest brings back lies in `out`."""
    with tempfile.TemporaryDirectory() as folder:
        initrd, disk = pathlib.Path(folder, "initrd"), pathlib.Path(folder, "disk")
        initramfs(initrd, kernel_folder, programs)
        with open(disk, "wb") as file:
            file.truncate(64 << 20)
        alive = os.access("/dev/kvm", os.R_OK | os.W_OK) and boot(KVM, kernel_folder, initrd, disk, words, 30, limit_s)
        if not alive:
            print("LOUD: without KVM: the guest's processor is emulated", flush=True)
            boot(EMULATED, kernel_folder, initrd, disk, words, limit_s, limit_s)
        try:
            with tarfile.open(disk) as archive:
                archive.extractall(out)
        except tarfile.ReadError:
            sys.exit(f"FAILED: the guest did not come to its end (limit {limit_s} s); the lines above say how far it came")


class Judge:
    """Prints what was looked at, and keeps what does not hold."""

    def __init__(self):
        self.wrong = 0

    def expect(self, holds, what):
        print(f"{'ok    ' if holds else 'WRONG '} {what}")
        self.wrong += not holds


def readings_of(rows, sensor):
    """(time in ns, counts by axis) of a sensor's rows."""
    column, _, unit, _ = SENSORS[sensor]
    names = {axis: column.format(axis) for axis in "xyz"}
    for row in rows:
        if row[names["x"]]:
            yield int(row["time_ns"]), {axis: float(row[name]) / unit for axis, name in names.items()}


def judge_readings(judge, sensor, rows, sent):
    """Each reading says which it is: how many the daemon took, and how many of those sent are missing among them."""
    _, tagged, _, standing = SENSORS[sensor]
    number, missing, taken, apart, last_ns, forward = -1, 0, 0, 0.0, None, True
    for t_ns, counts in readings_of(rows, sensor):
        tag = round(counts[tagged] - (MAGN_DOWN if sensor == "magn_3d" else 0)) + 128
        steps = (tag - number) % 256 or 256
        number += steps
        missing += steps - 1
        taken += 1
        expected = standing or {"x": round(2000 * math.sin(TURN_RAD * number)), "y": round(2000 * math.cos(TURN_RAD * number))}
        apart = max(apart, *(abs(counts[axis] - value) for axis, value in expected.items()))
        forward = forward and (last_ns is None or t_ns > last_ns)
        first_ns = t_ns if last_ns is None else first_ns
        last_ns = t_ns
    missing += sent - 1 - number
    judge.expect(taken + missing == sent and number < sent, f"{sensor}: sent {sent}, taken {taken}, missing {missing}")
    judge.expect(taken > 0 and apart < 0.05, f"{sensor}: axes, scale and unit; at most {apart:.3f} counts apart")
    judge.expect(taken > 0 and forward and last_ns - first_ns >= 0.99 * 5e6 * (sent - 1),
                 f"{sensor}: times go on, {1e-9 * (last_ns - first_ns):.2f} s in all" if taken else f"{sensor}: times")
    return taken, missing


def judge(out, first, again):
    verdict = Judge()
    text = {path.name: path.read_text() for path in out.iterdir() if path.suffix in (".log", ".txt")}
    daemon, hub = text["daemon.log"], text["hub.log"]
    print(hub + daemon + text["record.log"])
    if text["end.txt"].strip() != "DONE":
        sys.exit(f"FAILED: {text['end.txt'].strip()}")
    late_s = max((float(line.split()[1]) for line in hub.splitlines() if line.startswith("late ")), default=math.inf)
    if late_s > 1.0 and math.isfinite(late_s):
        raise Skipped(f"this machine kept the hub from running for {late_s} s at a stretch, as long as a device that is lost")
    found = {d["name"]: d for d in json.loads((out / "devices.json").read_text())["devices"] if d["kind"] == "iio"}
    verdict.expect(sorted(found) == sorted(SENSORS), f"stillpoint devices: {', '.join(found)}")
    for device in found.values():
        verdict.expect(device["rate_hz"] == 100 and device["detail"].startswith("buffer, ") and "problem" not in device,
                       f"{device['name']}: {device['rate_hz']} Hz, {device['detail']}")
    verdict.expect(all(f"on {name} at 5 ms" in hub for name in SENSORS), "200 Hz were set where 100 Hz had been")

    lines = [line for line in (out / "raw.csv").read_text().splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    totals = [judge_readings(verdict, name, rows, first + again) for name in SENSORS]
    taken, missing = (sum(column) for column in zip(*totals))
    stated = int(text["record.log"].split(" lost on the way")[0].split()[-1])
    sent = 3 * (first + again)
    verdict.expect(taken + stated == sent, f"in all: sent {sent}, taken {taken}, stated as lost {stated}")
    verdict.expect(missing == stated, f"missing by the readings' own numbers: {missing}")

    status = {name: json.loads((out / f"{name}.json").read_text()) for name in ("running", "quiet")}
    tilt = [abs(math.degrees(a)) for a in status["running"]["attitude"]["roll_pitch_yaw_rad"][:2]]
    verdict.expect(status["running"]["status"] != "stale" and max(tilt) < 3,
                   f"with readings: {status['running']['status']}, {status['running']['rate_hz']:.0f} readings/s, "
                   f"tilt {max(tilt):.2f} deg")
    verdict.expect(status["quiet"]["status"] == "stale", f"the hub is quiet: {status['quiet']['status']}")
    events = [line for line in daemon.splitlines() if "source: there" in line or "source: gone" in line]
    told = collections.Counter(line.split("source: ")[1] for line in events)
    verdict.expect(told["there"] == 1 and told["there again"] >= 1 and "polled" not in daemon,
                   f"the daemon told of: {dict(told)}")
    verdict.expect("exit 0" in daemon, "the daemon ended as asked")
    return verdict.wrong


def try_out(options):
    kernel_folder = kernel(options.folder)
    first, again = 200 * options.seconds, 2000
    out = options.folder / "out"
    shutil.rmtree(out, ignore_errors=True)
    run_guest(kernel_folder, [*options.programs, pathlib.Path(shutil.which("busybox"))], f"first={first} again={again}",
              12 * options.seconds + 1400, out)
    wrong = judge(out, first, again)
    print(f"{'FAILED: ' + str(wrong) + ' do not hold' if wrong else 'all of it holds'}; {kernel_folder.name}, {out}")
    return 1 if wrong else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("programs", nargs=3, type=pathlib.Path, metavar="PROGRAM")
    parser.add_argument("--folder", type=pathlib.Path, required=True, help="keeps the kernel, and what came back")
    parser.add_argument("--seconds", type=int, default=60, help="of readings before the hub is quiet")
    options = parser.parse_args()
    try:
        if shutil.which("qemu-system-x86_64") is None or shutil.which("busybox") is None:
            raise Skipped("no QEMU or no busybox here (Debian packages qemu-system-x86, busybox-static)")
        return try_out(options)
    except Skipped as reason:
        print(f"LOUD: the kernel's own IIO drivers: SKIPPED: {reason}")
        return 77


if __name__ == "__main__":
    sys.exit(main())
