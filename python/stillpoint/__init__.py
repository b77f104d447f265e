"""Self-calibrating attitude, and the physics a simulation left out.

    import stillpoint as sp
    recording = sp.Recording.read("drive.csv")            # or sp.Recording(time_s=..., acc_mps2=..., gyr_radps=...)
    attitude = sp.estimate(recording)                     # arrays: q_wxyz, sigma_rpy_rad, covariance_rad2, ...
    answer = sp.diagnose(recording, "simulation.yaml")    # answer.verdict, answer.findings, answer.improved

SI units and radians; temperature in degC, magnetic field in uT. World: east, north, up. Body: x forward, y left, z up;
at rest with z up an accelerometer reads +g. Quaternions are w, x, y, z and turn body vectors into the world.
"""
from ._native import __version__
from .attitude import Attitude, Calibration, Calibrator, TriadCalibration, estimate, setting_names
from .diagnosis import Diagnosis, Finding, Parameter, diagnose
from .recording import Recording
from .simulation import simulate

__all__ = ["Attitude", "Calibration", "Calibrator", "Diagnosis", "Finding", "Parameter", "Recording",
           "TriadCalibration", "__version__", "diagnose", "estimate", "setting_names", "simulate"]
