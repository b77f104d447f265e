"""Readings of one sensor as arrays."""
from __future__ import annotations

import os
from typing import Any, Mapping, Optional, Union

import numpy as np

from . import _native

# Column and its numbers a row; 1: a plain array of shape (N,).
_WIDTH = {"acc_mps2": 3, "gyr_radps": 3, "mag_uT": 3, "temp_degC": 1, "current_A": 1, "supply_V": 1,
          "ref_q_wxyz": 4, "ref_position_m": 3, "ref_moving": 1}
# The columns of the CSV and of a DataFrame that make one array.
_PARTS = {"acc_mps2": [f"acc_{a}_mps2" for a in "xyz"], "gyr_radps": [f"gyr_{a}_radps" for a in "xyz"],
          "mag_uT": [f"mag_{a}_uT" for a in "xyz"], "ref_q_wxyz": ["ref_qw", "ref_qx", "ref_qy", "ref_qz"],
          "ref_position_m": ["ref_px_m", "ref_py_m", "ref_pz_m"]}


def _checked(name: str, values: Any, rows: int) -> np.ndarray:
    array = np.ascontiguousarray(values, dtype=np.float64)
    wanted = (rows,) if _WIDTH[name] == 1 else (rows, _WIDTH[name])
    if array.shape != wanted:
        hint = "; transpose it" if array.T.shape == wanted else ""
        raise ValueError(f"{name} has the shape {array.shape}; {wanted} is wanted, one row for each time{hint}")
    return array


class Recording:
    """Readings of one sensor, as it gave them (bias and matrix not applied). All arrays have one row for each time;
    NaN means: not measured at this time. What was not given is None.

    Args:
        time_s: (N,) seconds, increasing.
        acc_mps2: (N, 3) specific force, m/s^2.
        gyr_radps: (N, 3) angular rate, rad/s.
        mag_uT: (N, 3) magnetic field, uT.
        temp_degC, current_A, supply_V: (N,) temperature of the sensor, current of a conductor nearby, supply voltage.
        ref_q_wxyz: (N, 4) reference orientation, body to world.
        ref_position_m: (N, 3) reference position in the world, m.
        ref_moving: (N,) 1 where the reference says that the body moves.
    """

    def __init__(self, time_s: Any, acc_mps2: Any = None, gyr_radps: Any = None, mag_uT: Any = None,
                 temp_degC: Any = None, current_A: Any = None, supply_V: Any = None, ref_q_wxyz: Any = None,
                 ref_position_m: Any = None, ref_moving: Any = None) -> None:
        given = {k: v for k, v in locals().items() if k in _WIDTH and v is not None}
        if not given:
            raise ValueError("a recording needs at least one sensor: acc_mps2, gyr_radps or mag_uT")
        time = np.ascontiguousarray(time_s, dtype=np.float64)
        if time.ndim != 1 or len(time) == 0:
            raise ValueError(f"time_s has the shape {time.shape}; (N,) is wanted")
        bad = np.flatnonzero(~(np.diff(time) > 0))
        if not np.isfinite(time).all() or len(bad):
            where = int(bad[0]) + 1 if len(bad) else int(np.flatnonzero(~np.isfinite(time))[0])
            raise ValueError(f"time_s must increase: row {where} has {time[where]}; sort the rows and drop repeated ones")
        if np.abs(time[[0, -1]]).max() > 4.6e9:
            raise ValueError(f"time_s ends at {time[-1]:g}: these are no seconds; divide ms by 1e3, us by 1e6, ns by 1e9")
        columns = {name: _checked(name, values, len(time)) for name, values in given.items()}
        self._native = _native.Recording.from_columns({"time_s": time, **columns})
        self._columns: Optional[dict] = None

    @classmethod
    def _wrap(cls, native: Any) -> "Recording":
        self = cls.__new__(cls)
        self._native = native
        self._columns = None
        return self

    @classmethod
    def read(cls, path: Union[str, os.PathLike], skip_malformed: bool = False) -> "Recording":
        """A recording CSV (docs/formats.md). `notices()` tells what was odd in it."""
        return cls._wrap(_native.Recording.read(os.fspath(path), skip_malformed))

    @classmethod
    def from_dataframe(cls, frame: Any) -> "Recording":
        """From a DataFrame (or any mapping of columns) with the column names of the recording CSV: time_s,
        acc_x_mps2, ..., gyr_x_radps, ..., mag_x_uT, ..., temp_degC, ref_qw, ...; others are left out."""
        names = list(frame.keys())
        if "time_s" not in names:
            raise ValueError(f"no column time_s; these are there: {', '.join(map(str, names))}")
        given = {}
        for name in _WIDTH:
            parts = _PARTS.get(name, [name])
            present = [p for p in parts if p in names]
            if present and len(present) < len(parts):
                raise ValueError(f"{present[0]} is there without {', '.join(p for p in parts if p not in names)}")
            if present:
                columns = [np.asarray(frame[p], dtype=np.float64) for p in parts]
                given[name] = columns[0] if len(parts) == 1 else np.column_stack(columns)
        return cls(np.asarray(frame["time_s"], dtype=np.float64), **given)

    def to_dict(self) -> dict:
        """Columns by the names of the recording CSV, each (N,): what pandas.DataFrame() takes."""
        out = {"time_s": self.time_s}
        for name in _WIDTH:
            values = getattr(self, name)
            if values is None:
                continue
            for i, part in enumerate(_PARTS.get(name, [name])):
                out[part] = values if values.ndim == 1 else values[:, i]
        return out

    def to_dataframe(self) -> Any:
        """The same as a pandas DataFrame."""
        import pandas
        return pandas.DataFrame(self.to_dict())

    def write(self, path: Union[str, os.PathLike]) -> None:
        """As a recording CSV, with nine decimals."""
        self._native.write(os.fspath(path))

    def notices(self) -> list:
        """What was odd in the file, in words; empty when nothing was."""
        return self._native.notices()

    def __len__(self) -> int:
        return len(self._native)

    def __getattr__(self, name: str) -> Optional[np.ndarray]:
        if name.startswith("_") or (name != "time_s" and name not in _WIDTH):
            raise AttributeError(f"a Recording has no {name}")
        if self._columns is None:
            self._columns = self._native.columns()
        return self._columns[name]

    def __repr__(self) -> str:
        has = ", ".join(name for name in _WIDTH if getattr(self, name) is not None)
        return f"<Recording of {len(self)} rows, {self.time_s[-1] - self.time_s[0]:.1f} s: {has}>"


def as_recording(source: Union[Recording, Mapping, str, os.PathLike, Any]) -> Recording:
    """A Recording, a path, a DataFrame or a mapping (of arrays or of CSV columns) as a Recording."""
    if isinstance(source, Recording):
        return source
    if isinstance(source, (str, os.PathLike)):
        return Recording.read(source)
    if hasattr(source, "keys"):
        keys = set(source.keys())
        if keys & set(_WIDTH) - set(_PARTS) or keys & set(_PARTS):
            if not any(part in keys for parts in _PARTS.values() for part in parts):
                return Recording(**{k: source[k] for k in keys if k == "time_s" or k in _WIDTH})
        return Recording.from_dataframe(source)
    raise TypeError(f"a Recording, a path, a DataFrame or a dict of arrays is wanted, not {type(source).__name__}")
