#!/usr/bin/env python3
"""Scores `stillpoint estimate`, the daemon's stages with calibration learning, on recordings with a reference orientation.

Per recording and in the mean: RMSE of the whole rotation, of the heading and of the inclination in degrees, over the rows
with ref_moving = 1, by the definition of BROAD (Laidig et al. 2021): q_e = q_est q_ref^-1 in the world.
"""
import argparse
import csv
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile


def rows(path):
    with open(path, newline="") as file:
        yield from csv.DictReader(line for line in file if not line.startswith("#"))


def errors(estimate, reference):
    """Total, heading and inclination error of one row, rad."""
    w, x, y, z = (float(estimate[k]) for k in ("qw", "qx", "qy", "qz"))
    rw, rx, ry, rz = (float(reference[k]) for k in ("ref_qw", "ref_qx", "ref_qy", "ref_qz"))
    ew = w * rw + x * rx + y * ry + z * rz
    ex = -w * rx + x * rw - y * rz + z * ry
    ey = -w * ry + x * rz + y * rw - z * rx
    ez = -w * rz - x * ry + y * rx + z * rw
    norm = math.sqrt(ew * ew + ex * ex + ey * ey + ez * ez)
    tilt = min(1.0, math.hypot(ew, ez) / norm)
    return 2 * math.acos(min(1.0, abs(ew) / norm)), 2 * math.atan2(abs(ez), abs(ew)), 2 * math.acos(tilt)


def score(tool, config, recording, folder):
    output = str(pathlib.Path(folder) / "attitude.csv")
    run = subprocess.run([tool, "estimate", "--config", config, "--recording", recording, "--output", output],
                         check=False, stdout=subprocess.DEVNULL)
    if run.returncode != 0:  # it has said why
        sys.exit(run.returncode)
    sums, count = [0.0, 0.0, 0.0], 0
    for estimate, reference in zip(rows(output), rows(recording), strict=True):
        if reference.get("ref_qw", "") == "" or reference.get("ref_moving", "1") != "1":
            continue
        count += 1
        for k, e in enumerate(errors(estimate, reference)):
            sums[k] += e * e
    if count == 0:
        sys.exit(f"{recording}: no row has a reference orientation (ref_qw, ...)")
    return [math.degrees(math.sqrt(s / count)) for s in sums]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("stillpoint", help="for example build/release/stillpoint")
    parser.add_argument("config", help="of the daemon (.yaml)")
    parser.add_argument("recordings", nargs="+", help="with reference columns (.csv)")
    given = parser.parse_args()
    if shutil.which(given.stillpoint) is None:
        parser.error(f"{given.stillpoint}: no such program; build it first")
    print(f"{'recording':<48} {'total':>7} {'heading':>8} {'inclination':>12}")
    results = []
    with tempfile.TemporaryDirectory() as folder:
        for recording in given.recordings:
            results.append(score(given.stillpoint, given.config, recording, folder))
            print(f"{pathlib.Path(recording).stem:<48} {results[-1][0]:7.3f} {results[-1][1]:8.3f} {results[-1][2]:12.3f}")
    mean = [sum(r[k] for r in results) / len(results) for k in range(3)]
    print(f"{'mean of ' + str(len(results)):<48} {mean[0]:7.3f} {mean[1]:8.3f} {mean[2]:12.3f}")


if __name__ == "__main__":
    main()
