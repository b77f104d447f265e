#!/usr/bin/env python3
"""Diagnoses the 16 trials of BROAD against their optical reference and prints what a calibration engineer asks for.

Nothing that is known of the recordings is given to the tool: unit matrices, no offsets, the field of the place, noise of a
consumer sensor. Devices are told apart by the lattice of the magnetometer's values (the export applied one calibration a
device); whether trials of one device agree is printed under the table.
"""
import argparse
import glob
import json
import os
import re
import shutil
import subprocess
import tempfile

SIMULATION = """rate_hz: 285.714
gravity_mps2: 9.81
field_world_uT: [0.0, 18.0, -45.0]
accelerometer: {noise_mps2: 0.03}
gyroscope: {noise_radps: 0.003}
magnetometer: {noise_uT: 0.5}
effects: []
"""


def diagnose(program, recording):
    with tempfile.TemporaryDirectory() as room:
        simulation = os.path.join(room, "sim.yaml")
        with open(simulation, "w", encoding="ascii") as file:
            file.write(SIMULATION)
        done = subprocess.run([program, "diagnose", "--simulation", simulation, "--recording", recording, "--json", "-"],
                              capture_output=True, text=True, check=True)
        return json.loads(done.stdout)


def number(finding, name, scale=1.0):
    for p in finding["parameters"]:
        if p["name"] == name:
            return "%.2f+-%.2f" % (scale * p["value"], scale * 0.5 * (p["ci95"][1] - p["ci95"][0]))
    return "-"


def arm(finding):
    r = {p["name"]: p["value"] for p in finding["parameters"]}
    if finding["effect"] == "acc_size":
        return [1e3 * sum(r["r_%s%s" % (i, j)] for i in "xyz") / 3 for j in "xyz"]
    return [1e3 * r["r_%s" % j] for j in "xyz"]


def summary(answer):
    line = {"hold": "-", "lag_gyr_ms": "-", "lag_acc_ms": "-", "arm_mm": None, "matrix": None, "device": "-", "other": []}
    for f in answer["findings"]:
        effect, gain = f["effect"], f["held_out"]["gain_nats"] or 0.0
        if effect == "mag_hold":
            line["hold"] = number(f, "n")
        elif effect == "mag_quant":
            line["device"] = " ".join("%.5f" % p["value"] for p in f["parameters"])
        elif effect in ("gyr_delay", "gyr_lpf", "sys_offset") and f["channels"][0].startswith("gyr"):
            line["lag_gyr_ms"] = number(f, "tau", 1e3) + " (%.0f nats)" % gain
        elif effect in ("acc_delay", "acc_lpf"):
            line["lag_acc_ms"] = number(f, "tau", 1e3) + " (%.0f nats)" % gain
        elif effect == "acc_resonance":
            p = {q["name"]: q["value"] for q in f["parameters"]}
            line["lag_acc_ms"] = "%.2f as resonance (%.0f nats)" % (1e3 * p["zeta"] / (3.14159 * p["f_n"]), gain)
        elif effect in ("acc_lever", "acc_size"):
            line["arm_mm"] = arm(f)
        elif not effect.endswith("_quant"):
            where = "" if f["interval_s"][0] < 1 else " %.1f-%.1f s" % tuple(f["interval_s"])
            size = " ".join("%.3g" % p["value"] for p in f["parameters"]) if effect.startswith("mag_") else ""
            line["other"].append("%s%s %s(%.0f nats)" % (effect, where, size + " " if size else "", gain))
    for c in answer["configuration"]:
        found = re.search(r"\[\[(.*)\]\]", c["what"])
        if c["sensor"] == "gyr" and found:
            line["matrix"] = [float(x) for x in re.findall(r"-?\d+\.\d+", found.group(1))]
    return line


def spread(rows):
    return ["%.2f to %.2f" % (min(column), max(column)) for column in zip(*rows)]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("stillpoint", help="for example build/release/stillpoint")
    parser.add_argument("folder", help="the recordings of BROAD (.csv)")
    parser.add_argument("trials", nargs="*", help="their numbers, such as 01; all unless given")
    given = parser.parse_args()
    if shutil.which(given.stillpoint) is None:
        parser.error(f"{given.stillpoint}: no such program; build it first")
    paths = sorted(glob.glob(os.path.join(given.folder, "*.csv")))
    if not paths:
        parser.error(f"{given.folder}: no recording (.csv) in it")
    devices = {}
    for path in paths:
        trial = os.path.basename(path)[:2]
        if given.trials and trial not in given.trials:
            continue
        line = summary(diagnose(given.stillpoint, path))
        devices.setdefault(line["device"], []).append((trial, line))
        print("%s  mag steps %s  hold %s  gyr lag ms %s  acc lag ms %s  arm mm %s  gyr D %% %s  %s" % (
            trial, line["device"], line["hold"], line["lag_gyr_ms"], line["lag_acc_ms"],
            "-" if line["arm_mm"] is None else " ".join("%.1f" % x for x in line["arm_mm"]),
            "-" if line["matrix"] is None else " ".join("%.2f" % x for x in line["matrix"]), "; ".join(line["other"])),
              flush=True)
    for device, trials in devices.items():
        arms = [line["arm_mm"] for _, line in trials if line["arm_mm"]]
        matrices = [line["matrix"] for _, line in trials if line["matrix"]]
        print("device %s: trials %s; arm mm x, y, z: %s; gyr D %%: %s" % (
            device, " ".join(trial for trial, _ in trials), "; ".join(spread(arms)), "; ".join(spread(matrices))))


if __name__ == "__main__":
    main()
