"""Attitude and calibration over arrays: the stages of the daemon, bit for bit."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping, Optional

import numpy as np

from . import _native
from .recording import as_recording

STATUS = ("initializing", "ok", "degraded", "stale")
HEADING = ("relative", "magnetic", "true", "disturbed")


@dataclass(frozen=True)
class TriadCalibration:
    """Calibration of one sensor in its own unit: u = matrix @ (reading - bias - bias_per_K tau - bias_per_K2 tau^2),
    tau = T - temp_ref_degC with T held inside temp_min_degC ... temp_max_degC.

    bias, bias_per_K, bias_per_K2: (3,); matrix, bias_covariance: (3, 3), the latter zeros where not known.
    norm_sd: standard deviation of the calibrated norm over the sphere, 0 where not known.
    windows: rest windows behind it. status: "factory" until something was learnt, then "ok" or why not.
    """
    bias: np.ndarray
    matrix: np.ndarray
    bias_per_K: np.ndarray
    bias_per_K2: np.ndarray
    temp_ref_degC: float
    temp_min_degC: float
    temp_max_degC: float
    bias_covariance: np.ndarray
    norm_sd: float
    windows: int
    status: str

    def apply(self, reading: Any, temp_degC: Any = None) -> np.ndarray:
        """Calibrated readings, (N, 3) or (3,); temp_degC: (N,) or a number, the reference temperature unless given."""
        t = self.temp_ref_degC if temp_degC is None else temp_degC
        tau = np.clip(t, self.temp_min_degC, self.temp_max_degC) - self.temp_ref_degC
        tau = np.asarray(tau)[..., np.newaxis]
        return (np.asarray(reading) - self.bias - tau * (self.bias_per_K + tau * self.bias_per_K2)) @ self.matrix.T


@dataclass(frozen=True)
class Calibration:
    """Calibration of one unit: acc in m/s^2, gyr in rad/s, mag in uT. version counts the changes; 0: the factory's."""
    version: int
    acc: TriadCalibration
    gyr: TriadCalibration
    mag: TriadCalibration

    def as_factory(self) -> dict:
        """What `factory=` of estimate() and Calibrator takes."""
        return {name: dict(vars(getattr(self, name))) for name in ("acc", "gyr", "mag")}


def _calibration(d: Mapping) -> Calibration:
    return Calibration(d["version"], *(TriadCalibration(**d[name]) for name in ("acc", "gyr", "mag")))


@dataclass(frozen=True)
class Attitude:
    """Attitude at each sample that was used.

    time_s: (N,) s. q_wxyz: (N, 4) body to world, unit norm. covariance_rad2: (N, 3, 3) of the rotation error about the
    fixed world axes. sigma_rpy_rad: (N, 3) standard deviations of roll, pitch, yaw. rate_radps: (N, 3) body, calibrated.
    gyro_bias_radps: (N, 3) what the filter takes off beyond the calibration. at_rest: (N,) bool.
    status, heading: (N,) numbers; STATUS and HEADING have their names. calibration: that of the end.
    """
    time_s: np.ndarray
    q_wxyz: np.ndarray
    covariance_rad2: np.ndarray
    sigma_rpy_rad: np.ndarray
    rate_radps: np.ndarray
    gyro_bias_radps: np.ndarray
    at_rest: np.ndarray
    status: np.ndarray
    heading: np.ndarray
    calibration: Calibration

    @property
    def rpy_rad(self) -> np.ndarray:
        """(N, 3) roll, pitch and yaw; yaw counter-clockwise from east."""
        w, x, y, z = self.q_wxyz.T
        return np.column_stack([np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
                                np.arcsin(np.clip(2 * (w * y - z * x), -1, 1)),
                                np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))])

    def __len__(self) -> int:
        return len(self.time_s)


def _settings(settings: Optional[Mapping[str, Any]], prefix: str = "") -> list:
    out = []
    for name, value in (settings or {}).items():
        if isinstance(value, Mapping):
            out += _settings(value, f"{prefix}{name}.")
        elif isinstance(value, (bool, int, float, np.number, np.bool_)):
            out.append((prefix + name, float(value)))
        else:
            raise TypeError(f"setting {prefix}{name} must be a number or a flag, not {value!r}")
    return out


def setting_names() -> list:
    """All names that `settings=` takes; docs/configuration.md says what they mean."""
    return _native.setting_names()


def estimate(recording: Any, settings: Optional[Mapping[str, Any]] = None,
             factory: Optional[Mapping[str, Mapping[str, Any]]] = None, smooth: bool = False) -> Attitude:
    """Attitude over a recording, calibrating on the way: what the daemon would have published.

    Args:
        recording: a Recording, a path, a DataFrame or a dict of arrays.
        settings: by the names of the daemon's configuration, nested or with dots:
            {"attitude": {"use_magnetometer": False}} or {"attitude.use_magnetometer": False}.
        factory: the calibration to start from, {"gyr": {"bias": [..3], "matrix": [[..3], ..]}, ...}.
        smooth: forward and backward, with the calibration of the end: the best attitude of a whole recording.
    """
    d = _native.estimate(as_recording(recording)._native, _settings(settings), dict(factory or {}), smooth)
    d["at_rest"] = d["at_rest"].astype(bool)
    d["calibration"] = _calibration(d["calibration"])
    return Attitude(**d)


class Calibrator:
    """Rest detection and online calibration without the attitude filter. Push recordings piece by piece, in time order.

    >>> calibrator = Calibrator()
    >>> windows = calibrator.push(recording)
    >>> calibrator.calibration.gyr.bias          # rad/s
    """

    def __init__(self, settings: Optional[Mapping[str, Any]] = None,
                 factory: Optional[Mapping[str, Mapping[str, Any]]] = None) -> None:
        self._native = _native.Calibrator(_settings(settings), dict(factory or {}))

    def push(self, recording: Any) -> int:
        """Learns from the next piece; gives the number of rest windows in it."""
        return self._native.push(as_recording(recording)._native)

    @property
    def calibration(self) -> Calibration:
        """What is known now."""
        return _calibration(self._native.calibration())
