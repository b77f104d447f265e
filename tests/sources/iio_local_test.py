#!/usr/bin/env python3
"""The kernel's files of IIO, made up by umockdev: `iio_local_test.py STILLPOINTD STILLPOINT`.

One device streams through a FIFO in place of its character device, one has no buffer and is polled.
"""
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import threading
import time

AXES = "xyz"


def device(number, name, kind, scale, raw, buffered):
    lines = [f"P: /devices/platform/{name}/iio:device{number}", f"N: iio:device{number}",
             f"E: DEVNAME=/dev/iio:device{number}", "E: SUBSYSTEM=iio", f"A: name={name}\\n",
             f"A: in_{kind}_scale={scale}\\n"]
    lines += [f"A: in_{kind}_{axis}_raw={value}\\n" for axis, value in zip(AXES, raw)]
    if buffered:
        lines += ["A: sampling_frequency=200\\n", "A: current_timestamp_clock=realtime\\n", "A: buffer/enable=0\\n",
                  "A: buffer/length=2\\n", "A: buffer/watermark=1\\n"]
        for index, channel in enumerate([f"{kind}_{axis}" for axis in AXES] + ["timestamp"]):
            layout = "le:s64/64>>0" if channel == "timestamp" else "le:s16/32>>0"
            lines += [f"A: scan_elements/in_{channel}_en=0\\n", f"A: scan_elements/in_{channel}_index={index}\\n",
                      f"A: scan_elements/in_{channel}_type={layout}\\n"]
    return "\n".join(lines) + "\n\n"


def feed(fifo, stop):
    out = os.open(fifo, os.O_RDWR)
    due = time.monotonic()
    while not stop.is_set():
        due += 0.005
        time.sleep(max(0.0, due - time.monotonic()))
        scan = b"".join(struct.pack("<hH", raw, 0x7A5A) for raw in (-100, 200, 1000))
        os.write(out, scan + bytes(4) + struct.pack("<q", time.monotonic_ns()))
    os.close(out)


def inside(stillpointd, stillpoint, folder):
    """Runs in umockdev's world."""
    fifo = pathlib.Path(os.environ["UMOCKDEV_DIR"]) / "dev/iio:device0"
    fifo.unlink()
    os.mkfifo(fifo)
    found = json.loads(subprocess.run([stillpoint, "devices", "--json", "--listen", "0"], check=True,
                                      capture_output=True, text=True).stdout)["devices"]
    names = {d["name"]: d for d in found if d["kind"] == "iio"}
    assert names["mock_accel"]["rate_hz"] == 200, names
    assert "polled" in names["mock_gyro"]["detail"] and "problem" in names["mock_gyro"], names
    stop = threading.Event()
    feeder = threading.Thread(target=feed, args=(fifo, stop))
    feeder.start()
    try:
        daemon = subprocess.Popen([stillpointd, "--config", f"{folder}/config.yaml"], stderr=subprocess.PIPE, text=True)
        time.sleep(4)
        daemon.terminate()
        said = daemon.communicate(timeout=30)[1]
    finally:
        stop.set()
        feeder.join()
    print(said)
    assert "mock_gyro has no buffer" in said or "source: there" in said, said
    ended = dict(word.split("=", 1) for word in said.split("ended: ")[1].split() if "=" in word)
    assert int(ended["samples"]) > 200, ended  # the gyroscope leads: polled at 100 Hz for about 4 s
    assert int(ended["refused"]) == 0, ended
    clock = pathlib.Path("/sys/bus/iio/devices/iio:device0/current_timestamp_clock").read_text().strip("\0\n")
    assert clock == "monotonic", clock


def main():
    if sys.argv[1] == "--inside":
        return inside(*sys.argv[2:])
    if shutil.which("umockdev-run") is None:
        print("LOUD: SKIPPED: umockdev-run is not installed (Debian package umockdev)")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        devices = device(0, "mock_accel", "accel", "0.0098", (-100, 200, 1000), True)
        devices += device(1, "mock_gyro", "anglvel", "0.001", (1, 2, 3), False)
        pathlib.Path(folder, "imu.umockdev").write_text(devices)
        # A machine that is busy with other tests polls late.
        pathlib.Path(folder, "config.yaml").write_text("source: {kind: iio}\nsensor: {limits: {late_s: 0.4}}\ndds: {domain: 91}\n")
        return subprocess.run(["umockdev-run", "-d", f"{folder}/imu.umockdev", "--", sys.executable, __file__,
                               "--inside", sys.argv[1], sys.argv[2], folder], check=False, timeout=120).returncode


if __name__ == "__main__":
    sys.exit(main())
