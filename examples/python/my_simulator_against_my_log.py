"""My simulator against my log: what does the real sensor do that the simulated one does not?

    python3 my_simulator_against_my_log.py [REC.csv]

REC.csv is a recording with a reference attitude (docs/formats.md). Without it: a minute of BROAD, an IMU turned by hand beside
optical cameras. Run it whole, or cell by cell in an editor that knows `# %%`.
"""
# %% The log: a minute of accelerometer and gyroscope is enough
import pathlib
import sys

import numpy as np
import stillpoint as sp

BROAD = pathlib.Path(__file__).resolve().parents[3] / "shared/recordings/broad"
whole = sp.Recording.read(sys.argv[1] if len(sys.argv) > 1 else BROAD / "03_undisturbed_slow_rotation_C.csv")
minute = (whole.time_s >= 60) & (whole.time_s < 120)
log = sp.Recording(whole.time_s[minute], whole.acc_mps2[minute], whole.gyr_radps[minute],
                   ref_q_wxyz=whole.ref_q_wxyz[minute], ref_position_m=whole.ref_position_m[minute])
print(log)

# %% My simulator, as far as its data sheet goes
simulation = {"rate_hz": 285.7, "accelerometer": {"noise_mps2": 0.03}, "gyroscope": {"noise_radps": 0.003}}
ideal = sp.simulate(simulation, seed=1, motion=log)
n = min(len(ideal), len(log))
print("gyroscope, recording minus simulation, rad/s rms:",
      np.round(np.sqrt(np.nanmean((log.gyr_radps[:n] - ideal.gyr_radps[:n]) ** 2, axis=0)), 4))

# %% What is missing in it?
answer = sp.diagnose(log, simulation)
print(answer.summary)
for finding in answer.findings:
    print(f"{finding.effect}: {finding.equation}, in {', '.join(finding.channels)}")
    for p in finding.parameters:
        print(f"   {p.name} = {p.value:.4g}" + (f" ({p.ci95[0]:.4g} to {p.ci95[1]:.4g}) {p.unit}" if p.ci95 else f" {p.unit}"))

# %% How much goes with it, on seconds that were not used for the fit? And the simulation that has it, to go on with
for finding in answer.findings:
    if finding.held_out:
        print(f"{finding.effect}: {finding.held_out['removable_share_removed']:.2f} of the removable residual is gone")
answer.write_report("my_simulator.html")
pathlib.Path("my_simulator_improved.yaml").write_text(answer.improved)
print("my_simulator.html, my_simulator_improved.yaml")

# %% Pictures, where matplotlib is installed
try:
    import matplotlib.pyplot as plt
except ImportError:
    print("no matplotlib: no pictures")
else:
    from stillpoint import plots
    plots.plot_residual(answer)
    plt.savefig("my_simulator.png", dpi=150)
    print("my_simulator.png")
