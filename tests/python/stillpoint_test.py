"""`import stillpoint` as a user meets it. The environment: STILLPOINT (the tool), SOURCE (the project)."""
import os
import pathlib
import subprocess
import tempfile
import time
import unittest

import numpy as np
import stillpoint as sp

SOURCE = pathlib.Path(os.environ["SOURCE"])
HAND = (SOURCE / "configs/sim_handheld.yaml").read_text()
STILL = {"rate_hz": 100, "accelerometer": {"bias": [0, 0, 0], "noise_mps2": 0.02},
         "gyroscope": {"bias": np.array([0.02, -0.01, 0.0]), "noise_radps": 0.001},
         "motion": {"kind": "hand", "duration_s": 60}}


def angle_deg(q, p):
    """Angle of the turn between each two quaternions."""
    return np.degrees(2 * np.arccos(np.clip(np.abs(np.sum(q * p, axis=1)), 0, 1)))


class TestRecording(unittest.TestCase):
    def arrays(self, n=50):
        return {"time_s": np.arange(n) / 100, "acc_mps2": np.tile([0, 0, 9.8], (n, 1)), "gyr_radps": np.zeros((n, 3))}

    def test_arrays_come_back_as_they_were(self):
        a = self.arrays()
        r = sp.Recording(**a, temp_degC=np.full(50, 21.5))
        np.testing.assert_array_equal(r.acc_mps2, a["acc_mps2"])
        np.testing.assert_array_equal(r.temp_degC, 21.5)
        self.assertIsNone(r.mag_uT)
        self.assertIn("50 rows", repr(r))

    def test_a_file_written_reads_back_to_its_nine_decimals(self):
        r = sp.simulate(STILL)
        with tempfile.TemporaryDirectory() as folder:
            r.write(folder + "/r.csv")
            back = sp.Recording.read(folder + "/r.csv")
        np.testing.assert_allclose(back.gyr_radps, r.gyr_radps, rtol=0, atol=5.1e-10)
        self.assertEqual(back.notices(), [])

    def test_columns_make_a_recording_and_the_other_way_round(self):
        r = sp.simulate(STILL)
        again = sp.Recording.from_dataframe(r.to_dict())
        np.testing.assert_array_equal(again.ref_q_wxyz, r.ref_q_wxyz)

    def test_wrong_shapes_say_what_is_wanted(self):
        a = self.arrays()
        for change, said in [({"acc_mps2": a["acc_mps2"].T}, "transpose"), ({"acc_mps2": np.zeros(50)}, r"\(50, 3\)"),
                             ({"time_s": a["time_s"][::-1]}, "row 1"), ({"time_s": a["time_s"] * 1e12}, "divide")]:
            with self.assertRaisesRegex(ValueError, said):
                sp.Recording(**{**a, **change})
        with self.assertRaisesRegex(ValueError, "acc_x_mps2 is there without acc_y_mps2"):
            sp.Recording.from_dataframe({"time_s": [0, 1], "acc_x_mps2": [0, 0]})
        with self.assertRaises(FileNotFoundError):
            sp.Recording.read("/nowhere.csv")
        with self.assertRaisesRegex(AttributeError, "no accel"):
            sp.Recording(**a).accel


class TestEstimate(unittest.TestCase):
    def test_is_the_tool_bit_for_bit_and_not_slower(self):
        recording = sp.simulate(HAND.replace("duration_s: 300", "duration_s: 120"), seed=3)
        with tempfile.TemporaryDirectory() as folder:
            path, out = folder + "/r.csv", folder + "/a.csv"
            recording.write(path)
            command = [os.environ["STILLPOINT"], "estimate", "--config", str(SOURCE / "configs/estimate.yaml"),
                       "--recording", path, "--output", out]
            tool_s, python_s = [], []
            for _ in range(5):
                start = time.process_time(), os.times()
                subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
                spent = os.times()
                tool_s.append(spent.children_user - start[1].children_user)
                start = time.process_time()
                attitude = sp.estimate(path)
                python_s.append(time.process_time() - start)
            table = np.loadtxt(out, delimiter=",", skiprows=1, usecols=range(1, 8))
        np.testing.assert_array_equal(attitude.q_wxyz, table[:, :4])
        np.testing.assert_array_equal(attitude.sigma_rpy_rad, table[:, 4:7])
        self.assertLess(min(python_s), 1.2 * min(tool_s))

    def test_follows_the_truth_inside_its_sigma(self):
        recording = sp.simulate(HAND, seed=4)
        a = sp.estimate(recording)
        late = a.time_s > 150
        error = angle_deg(a.q_wxyz, recording.ref_q_wxyz)[late]
        sigma = np.degrees(np.sqrt(np.trace(a.covariance_rad2, axis1=1, axis2=2)))[late]
        self.assertGreater(np.mean(error < 3 * sigma), 0.98)
        self.assertEqual(a.calibration.gyr.status, "ok")
        self.assertEqual(a.covariance_rad2.shape, (len(a), 3, 3))
        np.testing.assert_allclose(np.linalg.norm(a.q_wxyz, axis=1), 1, atol=1e-9)

    def test_smoothed_is_nearer_to_the_truth(self):
        recording = sp.simulate(HAND, seed=5)
        causal, smoothed = sp.estimate(recording), sp.estimate(recording, smooth=True)
        self.assertEqual(len(causal), len(smoothed))
        rms = [np.sqrt(np.mean(angle_deg(a.q_wxyz, recording.ref_q_wxyz) ** 2)) for a in (causal, smoothed)]
        self.assertLess(rms[1], 0.7 * rms[0])

    def test_settings_nested_or_dotted_do_the_same_and_wrong_ones_are_named(self):
        r = sp.simulate(HAND.replace("duration_s: 300", "duration_s: 20"))
        nested = sp.estimate(r, {"attitude": {"use_magnetometer": False}})
        dotted = sp.estimate(r, {"attitude.use_magnetometer": False})
        np.testing.assert_array_equal(nested.q_wxyz, dotted.q_wxyz)
        self.assertTrue((nested.heading == 0).all())
        with self.assertRaisesRegex(ValueError, "did you mean 'attitude.use_magnetometer'"):
            sp.estimate(r, {"attitude": {"use_magnetomter": False}})
        with self.assertRaisesRegex(TypeError, "must be a number"):
            sp.estimate(r, {"attitude": {"use_magnetometer": "no"}})
        with self.assertRaisesRegex(ValueError, "bias must hold 3"):
            sp.estimate(r, factory={"gyr": {"bias": [1, 2]}})

    def test_missing_readings_are_bridged(self):
        r = sp.simulate(STILL)
        acc = r.acc_mps2.copy()
        acc[1000:1100] = np.nan
        a = sp.estimate(sp.Recording(r.time_s, acc, r.gyr_radps))
        self.assertTrue(np.isfinite(a.q_wxyz).all())


class TestCalibrator(unittest.TestCase):
    def test_learns_the_bias_from_pieces(self):
        r = sp.simulate(STILL)
        c = sp.Calibrator()
        windows = 0
        for part in np.array_split(np.arange(len(r)), 5):
            windows += c.push({"time_s": r.time_s[part], "acc_mps2": r.acc_mps2[part], "gyr_radps": r.gyr_radps[part]})
        gyr = c.calibration.gyr
        self.assertGreater(windows, 3)
        np.testing.assert_allclose(gyr.bias, [0.02, -0.01, 0], atol=5e-4)
        np.testing.assert_allclose(gyr.apply([0.02, -0.01, 0]), 0, atol=5e-4)
        self.assertEqual(gyr.apply(r.gyr_radps, np.full(len(r), 25.0)).shape, (len(r), 3))
        warm = sp.Calibrator(factory=c.calibration.as_factory())
        np.testing.assert_array_equal(warm.calibration.gyr.bias, gyr.bias)


class TestSimulate(unittest.TestCase):
    def test_a_dict_a_text_and_a_file_give_the_same_bits(self):
        with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
            file.write(HAND)
            file.flush()
            from_file = sp.simulate(file.name, seed=7)
        np.testing.assert_array_equal(sp.simulate(HAND, seed=7).acc_mps2, from_file.acc_mps2)
        self.assertFalse(np.array_equal(sp.simulate(HAND, seed=8).acc_mps2, from_file.acc_mps2))

    def test_takes_the_motion_of_a_recording(self):
        first = sp.simulate(STILL)
        again = sp.simulate({**STILL, "gyroscope": {"bias": [0, 0, 0], "noise_radps": 0}}, motion=first)
        self.assertLess(abs(len(again) - len(first)), 10)
        self.assertGreater(np.corrcoef(again.gyr_radps[100:5000, 0], first.gyr_radps[100:5000, 0])[0, 1], 0.99)

    def test_faults_are_named(self):
        with self.assertRaisesRegex(ValueError, "did you mean 'gyroscope'"):
            sp.simulate({**STILL, "gyroscop": {}})
        with self.assertRaisesRegex(ValueError, "no 'motion:'"):
            sp.simulate({"rate_hz": 100, "gyroscope": {"noise_radps": 0.001}})
        with self.assertRaises(FileNotFoundError):
            sp.simulate("/nowhere.yaml")


class TestDiagnose(unittest.TestCase):
    def test_names_what_the_simulation_left_out(self):
        simulation = {"rate_hz": 100, "accelerometer": {"noise_mps2": 0.02}, "gyroscope": {"noise_radps": 0.001},
                      "motion": {"kind": "hand", "duration_s": 60}}
        truth = {**simulation, "effects": [{"effect": "gyr_gsens", "G_radps_per_mps2":
                                            [[2e-4, 0, 1e-4], [0, -2e-4, 0], [1e-4, 0, 2e-4]]}]}
        recording = sp.simulate(truth)
        told = []
        answer = sp.diagnose(recording.to_dict(), simulation, progress=told.append)
        self.assertEqual(answer.verdict, "explained", answer.summary)
        self.assertEqual(answer.findings[0].effect, "gyr_gsens")
        self.assertTrue(all(p.ci95[0] <= p.value <= p.ci95[1] for p in answer.findings[0].parameters if p.ci95))
        self.assertIn("gyr_gsens", answer.improved)
        self.assertIn("<html", answer.report)
        self.assertTrue(told and told == sorted(told) and told[-1] <= 1.0)


if __name__ == "__main__":
    unittest.main()
