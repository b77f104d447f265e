"""My phone log: which way did it point, how well is that known, and what is wrong with its sensors?

    python3 my_phone_log.py [REC.csv]

REC.csv is what `stillpoint import` makes of a phone's log (docs/import.md). Without it: two minutes of an iPhone 5 that a
walking person looks through. Run it whole, or cell by cell in an editor that knows `# %%`.
"""
# %% The log
import pathlib
import sys

import numpy as np
import stillpoint as sp

PHONES = pathlib.Path(__file__).resolve().parents[3] / "shared/recordings/phones/streams"
log = sp.Recording.read(sys.argv[1] if len(sys.argv) > 1 else PHONES / "Guillaume_iPhone5_NoDist_AR.csv")
print(log)
for notice in log.notices():
    print("  ", notice)

# %% Rates: each sensor speaks at its own, a row without a reading holds NaN
for name in ("acc_mps2", "gyr_radps", "mag_uT"):
    values = getattr(log, name)
    if values is None:
        print(f"{name}: not in the log")
        continue
    t = log.time_s[np.isfinite(values).all(axis=1)]
    print(f"{name}: {1 / np.median(np.diff(t)):.0f} Hz")

# %% The attitude as the daemon would have published it, and as the whole log tells it
causal = sp.estimate(log)
smoothed = sp.estimate(log, smooth=True)
for name, attitude in (("causal", causal), ("smoothed", smoothed)):
    roll, pitch, yaw = np.degrees(attitude.rpy_rad[-1])
    sigma = np.degrees(attitude.sigma_rpy_rad[-1])
    print(f"{name}: roll {roll:.1f} +- {sigma[0]:.1f}, pitch {pitch:.1f} +- {sigma[1]:.1f}, yaw {yaw:.1f} +- {sigma[2]:.1f} deg")

# %% What the log says of its sensors
for name in ("acc", "gyr", "mag"):
    triad = getattr(causal.calibration, name)
    print(f"{name}: {triad.status}, bias {np.round(triad.bias, 4)}, from {triad.windows} windows of rest")
print("gyroscope offset that the filter takes off, deg/s:", np.round(np.degrees(causal.gyro_bias_radps[-1]), 2))

# %% Against a reference, if there is one
if log.ref_q_wxyz is not None:
    known = np.isfinite(log.ref_q_wxyz).all(axis=1)
    for name, attitude in (("causal", causal), ("smoothed", smoothed)):
        # The reference has rows of its own: the attitude nearest in time stands for each.
        at = np.clip(np.searchsorted(attitude.time_s, log.time_s[known]), 0, len(attitude) - 1)
        cosine = np.abs(np.sum(attitude.q_wxyz[at] * log.ref_q_wxyz[known], axis=1))
        error_deg = np.degrees(2 * np.arccos(np.clip(cosine, 0, 1)))[attitude.time_s[at] > 60]
        print(f"{name}: off by {np.sqrt(np.mean(error_deg ** 2)):.1f} deg rms after the first minute")

# %% Pictures, where matplotlib is installed
try:
    import matplotlib.pyplot as plt
except ImportError:
    print("no matplotlib: no pictures")
else:
    from stillpoint import plots
    plots.plot_attitude(causal)
    plt.savefig("my_phone_log.png", dpi=150)
    print("my_phone_log.png")
