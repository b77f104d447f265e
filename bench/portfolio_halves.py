#!/usr/bin/env python3
"""portfolio_halves.py [PORTFOLIO]: are the filter's free parameters told by one half of the sets for the other?

The few parameters that no data sheet states (a person's speed and distance, the deviation of a magnetic heading) are
chosen on half of the recorded sets, by the mean of each set's error over that of the defaults, and judged on the
other half; then the halves change places. What is printed was chosen without the set it stands beside.
"""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

SETS = ["broad", "phones", "phones magnets", "phones running", "phones streams"]
HALVES = [("phone sets without BROAD", SETS[1:], SETS[:1]), ("BROAD and running", [SETS[0], SETS[3]], [SETS[1], SETS[2], SETS[4]]),
          ("phones, magnets, streams", [SETS[1], SETS[2], SETS[4]], [SETS[0], SETS[3]])]
GRID = [{}] + [{key: value} for key, values in {
    "motion_speed_mps": (0.5, 2.0), "motion_radius_m": (1.0, 30.0), "heading_noise_rad": (0.035, 0.14),
}.items() for value in values]


def errors(portfolio, parameters):
    """Total error in degrees by set."""
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as config:
        config.write("sensor: {id: portfolio}\nattitude: {%s}\n" % ", ".join(f"{k}: {v}" for k, v in parameters.items()))
        config.flush()
        out = subprocess.run([portfolio, "--json", "--config", config.name, "--sets", *SETS],
                             check=True, capture_output=True, text=True).stdout
    return {s["set"]: s["total_deg"] for s in json.loads(out)["sets"]}


def main():
    default_path = Path(__file__).resolve().parent.parent / "build/release/bench/portfolio"
    portfolio = sys.argv[1] if len(sys.argv) > 1 else str(default_path)
    table = [(parameters, errors(portfolio, parameters)) for parameters in GRID]
    defaults = table[0][1]
    for name, chosen_on, judged_on in HALVES:
        parameters, found = min(table, key=lambda row: sum(row[1][s] / defaults[s] for s in chosen_on))
        print(f"chosen on {name}: {parameters or 'the defaults'}")
        for s in judged_on:
            best = min(row[1][s] for row in table)
            print(f"  {s:16} {found[s]:6.2f}   defaults {defaults[s]:6.2f}   best of the grid, in sample {best:6.2f}")


if __name__ == "__main__":
    main()
