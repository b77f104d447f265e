#!/usr/bin/env python3
"""The scripts of examples/python on real recordings, as a reader runs them: run_examples.py EXAMPLES RECORDINGS

matplotlib is hidden from them, so that they say the same everywhere. Where it is installed, the two plots are drawn too."""
import importlib.util
import os
import pathlib
import re
import subprocess
import sys
import tempfile

EXAMPLES, RECORDINGS = (pathlib.Path(p).resolve() for p in sys.argv[1:3])
WITHOUT_PICTURES = ("import runpy, sys; sys.modules['matplotlib'] = None; sys.argv = sys.argv[1:]; "
                    "runpy.run_path(sys.argv[0], run_name='__main__')")
PICTURES = """
import matplotlib
matplotlib.use('Agg')
import stillpoint as sp
from stillpoint import plots
simulation = {'rate_hz': 100, 'accelerometer': {'noise_mps2': 0.02}, 'gyroscope': {'noise_radps': 0.001},
              'motion': {'kind': 'hand', 'duration_s': 20}}
recording = sp.simulate(simulation)
labels = [a.get_ylabel() for a in plots.plot_attitude(sp.estimate(recording))]
assert labels == ['roll, deg', 'pitch, deg', 'yaw, deg'], labels
axes = plots.plot_residual(sp.diagnose(recording, simulation))
assert {t.get_text() for t in axes.get_yticklabels()} >= {'gyr_x', 'acc_z'}, 'channels'
"""


def ran(folder, script, recording):
    done = subprocess.run([sys.executable, "-B", "-c", WITHOUT_PICTURES, EXAMPLES / script, recording], cwd=folder,
                          capture_output=True, text=True)
    print(done.stdout, done.stderr, sep="")
    assert done.returncode == 0, script
    assert "no matplotlib: no pictures" in done.stdout, script
    return done.stdout


def phone(folder):
    said = ran(folder, "my_phone_log.py", RECORDINGS / "phones/streams/Guillaume_iPhone5_NoDist_AR.csv")
    causal, smoothed = (float(re.search(name + r": off by ([\d.]+) deg", said)[1]) for name in ("causal", "smoothed"))
    assert smoothed < causal < 8, (causal, smoothed)
    offset = float(re.search(r"takes off, deg/s: \[ *([-\d.]+)", said)[1])
    assert abs(offset - 5.5) < 0.5, f"the offset of this iPhone 5 is 5.5 deg/s, not {offset}"


def simulator(folder):
    said = ran(folder, "my_simulator_against_my_log.py", RECORDINGS / "broad/03_undisturbed_slow_rotation_C.csv")
    tau = float(re.search(r"gyr_delay:.*\n +tau = ([\d.]+)", said)[1])
    assert abs(tau - 0.0041) < 0.0003, f"the gyroscope of this device is 4.1 ms late, not {tau}"
    gone = float(re.search(r"gyr_delay: ([\d.]+) of the removable residual is gone", said)[1])
    assert gone > 0.7, gone
    assert "effect: gyr_delay" in (folder / "my_simulator_improved.yaml").read_text()
    assert "<html" in (folder / "my_simulator.html").read_text()


with tempfile.TemporaryDirectory() as name:
    if importlib.util.find_spec("matplotlib"):
        subprocess.run([sys.executable, "-B", "-c", PICTURES], cwd=name, check=True, env={**os.environ, "MPLCONFIGDIR": name})
    else:
        print("LOUD: matplotlib is not installed: the two plots are SKIPPED")
    if not RECORDINGS.is_dir():
        print(f"LOUD: {RECORDINGS} is absent: the examples in Python are SKIPPED")
        sys.exit(77)
    phone(pathlib.Path(name))
    simulator(pathlib.Path(name))
