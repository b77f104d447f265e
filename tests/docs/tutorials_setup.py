#!/usr/bin/env python3
"""The files that a reader of docs/tutorials.md has: a phone logger's zip and the YAML of a simulator of one's own."""
import csv
import pathlib
import subprocess
import zipfile

SENSORS = """rate_hz: 100
accelerometer: {noise_mps2: 0.02, bias: [0.05, -0.04, 0.03]}
gyroscope: {noise_radps: 0.001, bias: [0.004, -0.006, 0.005]}
magnetometer: {noise_uT: 0.4}
"""
PHONE = SENSORS + """effects:
  - {effect: gyr_gsens, G_radps_per_mps2: [[0, 1e-3, 0], [0, 0, 1e-3], [1e-3, 0, 0]]}
motion: {kind: hand, duration_s: 60}
"""
TABLES = {"TotalAcceleration.csv": "acc_{}_mps2", "Gyroscope.csv": "gyr_{}_radps", "MagnetometerUncalibrated.csv": "mag_{}_uT"}

pathlib.Path("mine.yaml").write_text(SENSORS, encoding="ascii")
pathlib.Path("phone.yaml").write_text(PHONE, encoding="ascii")
subprocess.run(["stillpoint", "simulate", "--simulation", "phone.yaml", "--output", "phone.csv"], check=True)
with open("phone.csv", encoding="ascii") as file:
    rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
with zipfile.ZipFile("my-walk.zip", "w") as log:
    for table, column in TABLES.items():
        lines = [",".join([r["time_ns"]] + [r[column.format(axis)] for axis in "xyz"]) for r in rows]
        log.writestr(table, "time,x,y,z\n" + "\n".join(lines) + "\n")
for made in ("phone.yaml", "phone.csv"):
    pathlib.Path(made).unlink()
