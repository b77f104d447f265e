"""The simulated sensor."""
from __future__ import annotations

import json
import os
from typing import Any, Mapping, Optional, Tuple, Union

import numpy as np

from . import _native
from .recording import Recording, as_recording

Simulation = Union[Mapping[str, Any], str, os.PathLike]


def _plain(value: Any) -> Any:
    if isinstance(value, (np.ndarray, np.number, np.bool_)):
        return value.tolist()
    raise TypeError(f"{value!r} has no place in a simulation")


def simulation_text(simulation: Simulation) -> Tuple[str, str]:
    """YAML and its name in messages, of a dict, of a YAML text (more than one line) or of a file."""
    if isinstance(simulation, Mapping):
        return json.dumps(simulation, default=_plain, allow_nan=False), "simulation"
    text = os.fspath(simulation)
    if "\n" in text:
        return text, "simulation"
    with open(text, encoding="utf-8") as file:
        return file.read(), text


def simulate(simulation: Simulation, seed: int = 1, motion: Optional[Any] = None) -> Recording:
    """The recording that a simulated sensor gives, with the true orientation and position as its reference columns.

    Args:
        simulation: docs/simulation.md as a dict, as YAML text or as the path of a file.
        seed: of all random streams; the same seed gives the same bits.
        motion: a recording with a reference, whose motion is taken instead of the simulation's own.
    """
    if not 0 <= seed < 2**53:
        raise ValueError(f"seed must be a whole number from 0 to 2^53, not {seed}")
    text, name = simulation_text(simulation)
    native = None if motion is None else as_recording(motion)._native
    return Recording._wrap(_native.simulate(text, name, int(seed), native))
