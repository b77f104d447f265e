"""Two pictures with matplotlib, which is only imported here."""
from __future__ import annotations

from typing import Any

import numpy as np

from .attitude import Attitude
from .diagnosis import Diagnosis


def plot_attitude(attitude: Attitude, axes: Any = None) -> Any:
    """Roll, pitch and yaw in degrees with their bands of three standard deviations, rest shaded. Returns the axes."""
    import matplotlib.pyplot as plt
    if axes is None:
        _, axes = plt.subplots(3, 1, sharex=True)
    rpy = np.degrees(np.unwrap(attitude.rpy_rad, axis=0))
    band = np.degrees(3 * attitude.sigma_rpy_rad)
    for i, name in enumerate(("roll", "pitch", "yaw")):
        axes[i].plot(attitude.time_s, rpy[:, i], lw=1)
        axes[i].fill_between(attitude.time_s, rpy[:, i] - band[:, i], rpy[:, i] + band[:, i], alpha=0.25)
        axes[i].fill_between(attitude.time_s, 0, 1, where=attitude.at_rest, transform=axes[i].get_xaxis_transform(),
                             color="0.9", zorder=-1)
        axes[i].set_ylabel(f"{name}, deg")
    axes[-1].set_xlabel("time, s")
    return axes


def plot_residual(diagnosis: Diagnosis, axes: Any = None) -> Any:
    """Residual of each channel before and after, as bars over the noise of the simulation. Returns the axes."""
    import matplotlib.pyplot as plt
    if axes is None:
        _, axes = plt.subplots()
    rows = [r for r in diagnosis.residual if r.get("rms_before") is not None]
    y = np.arange(len(rows))
    scale = np.array([r.get("rms_after") or 1.0 for r in rows])
    axes.barh(y - 0.2, np.array([r["rms_before"] for r in rows]) / scale, 0.4, label="before")
    axes.barh(y + 0.2, np.array([r["rms_after"] for r in rows]) / scale, 0.4, label="after")
    axes.set_yticks(y, [r["channel"] for r in rows])
    axes.set_xlabel("rms over rms after")
    axes.legend()
    return axes
