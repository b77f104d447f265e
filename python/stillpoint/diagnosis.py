"""What a simulation left out of a recording."""
from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple, Union

from . import _native
from .recording import as_recording
from .simulation import Simulation, simulation_text


@dataclass(frozen=True)
class Parameter:
    """One number of a law, with its 95 % interval."""
    name: str
    value: float
    ci95: Optional[Tuple[float, float]]
    unit: str


@dataclass(frozen=True)
class Finding:
    """One piece of physics that is missing. effect: its ID (docs/effects.md) or "unknown:" and the law's text.
    equivalent: IDs that this recording cannot tell from it. interval_s: when it acts. held_out: rms before and after,
    noise floor and gain on data that were not used for the fit. raw: all of it, as in docs/diagnosis.md."""
    effect: str
    channels: List[str]
    equation: str
    driver: str
    regime: str
    interval_s: Optional[Tuple[float, float]]
    parameters: List[Parameter]
    equivalent: List[str]
    held_out: Dict[str, Any]
    raw: Dict[str, Any] = field(repr=False)


@dataclass(frozen=True)
class Diagnosis:
    """The answer. verdict: "no_mismatch", "explained", "partly_explained", "unexplained", "insufficient_data", ...;
    improved: the simulation with what was found in it, as YAML; raw: everything, as in docs/diagnosis.md."""
    verdict: str
    summary: str
    findings: List[Finding]
    configuration: List[Dict[str, Any]]
    noise: List[Dict[str, Any]]
    residual: List[Dict[str, Any]]
    notices: List[str]
    improved: str = field(repr=False)
    raw: Dict[str, Any] = field(repr=False)
    report: str = field(repr=False)

    def write_report(self, path: Union[str, os.PathLike]) -> None:
        """The report as one HTML file that needs no network."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.report)


def _interval(raw: Any) -> Optional[Tuple[float, float]]:
    return None if raw is None else (raw[0], raw[1])


def _finding(raw: Dict[str, Any]) -> Finding:
    parameters = [Parameter(p["name"], p["value"], _interval(p.get("ci95")), p.get("unit", ""))
                  for p in raw.get("parameters", [])]
    return Finding(raw["effect"], raw.get("channels", []), raw.get("equation", ""), raw.get("driver", ""),
                   raw.get("regime", ""), _interval(raw.get("interval_s")), parameters, raw.get("equivalent", []),
                   raw.get("held_out") or {}, raw)


def diagnose(recording: Any, simulation: Simulation, without: Sequence[str] = (), twins: int = 0,
             progress: Optional[Callable[[float], None]] = None) -> Diagnosis:
    """Names the physics that a simulation left out of a recording.

    Args:
        recording: a Recording, a path, a DataFrame or a dict of arrays; with a reference it can find more.
        simulation: docs/simulation.md as a dict, as YAML text or as the path of a file.
        without: IDs of laws that are taken out of the library.
        twins: so many parametric bootstrap replicates gate what is found.
        progress: is told the share of the work that is done, 0 to 1.
    """
    text, name = simulation_text(simulation)
    answer, improved, report = _native.diagnose(as_recording(recording)._native, text, name, list(without), twins,
                                                progress)
    raw = json.loads(answer)
    return Diagnosis(raw["verdict"], raw["summary"], [_finding(f) for f in raw.get("findings", [])],
                     raw.get("configuration", []), raw.get("noise", []), raw.get("residual", []),
                     raw.get("notices", []), improved, raw, report)
