#!/usr/bin/env python3
"""`stillpoint calibrate --points` beside two peers on the same points.

imu_tk: Tedaldi, Pretto, Menegatti, ICRA 2014, nonlinear least squares of the norm over nine parameters (offset, upper
triangle) from the factory values; for the accelerometer only, as it starts from an offset of zero. magneto: Li and
Griffiths, GMP 2004, the fit that only an ellipsoid can come out of, as the program magneto 1.2 uses it. Both written
anew here. Needs numpy (Debian: python3-numpy).
"""
import argparse
import json
import shutil
import subprocess
import sys
import tempfile

try:
    import numpy as np
except ModuleNotFoundError:
    np = None

SEEDS = 30
GRAVITY_MPS2, FIELD_UT = 9.80665, 50.0


def even_directions(n):
    z = 1.0 - (2.0 * np.arange(n) + 1.0) / n
    a = 2.399963229728653 * np.arange(n)
    return np.c_[np.sqrt(1 - z * z) * np.cos(a), np.sqrt(1 - z * z) * np.sin(a), z]


def ours(stillpoint, points, method):
    with tempfile.NamedTemporaryFile("w", suffix=".csv") as table:
        np.savetxt(table, points, "%.9g", ",", header="x,y,z", comments="")
        table.flush()
        run = subprocess.run([stillpoint, "calibrate", "--points", table.name, "--method", method, "--json", "-"],
                             capture_output=True, text=True, check=False)
    result = json.loads(run.stdout)
    return (np.array(result["matrix"]), np.array(result["offset"])) if result["status"] == "ok" else None


def upper(p, radius):
    return np.array([[p[3], p[4], p[5]], [0, p[6], p[7]], [0, 0, p[8]]]) / radius


def imu_tk(points, radius):
    p = np.array([0, 0, 0, 1, 0, 0, 1, 0, 1.0])  # offset over the radius, then the matrix
    damping = 1e-3

    def residuals(q):
        return np.linalg.norm((points / radius - q[:3]) @ upper(q, 1.0).T, axis=1) - 1

    for _ in range(400):  # Levenberg-Marquardt
        r = residuals(p)
        J = np.array([(residuals(p + 1e-6 * e) - r) / 1e-6 for e in np.eye(9)]).T
        N = J.T @ J
        step = np.linalg.solve(N + damping * np.eye(9) * np.trace(N) / 9, -J.T @ r)
        better = np.sum(residuals(p + step) ** 2) < np.sum(r**2)
        damping = max(1e-12, min(1e12, damping * (0.1 if better else 10)))
        if better:
            p = p + step
    return upper(p, radius), radius * p[:3]


def magneto(points, radius):
    x, y, z = (points / radius).T
    D = np.c_[x * x, y * y, z * z, 2 * y * z, 2 * x * z, 2 * x * y, 2 * x, 2 * y, 2 * z, np.ones(len(x))]
    S = D.T @ D
    C = np.diag([-1.0, -1, -1, -4, -4, -4])
    C[:3, :3] += np.ones((3, 3)) - np.eye(3)
    back = np.linalg.pinv(S[6:, 6:]) @ S[6:, :6]
    values, vectors = np.linalg.eig(np.linalg.solve(C, S[:6, :6] - S[:6, 6:] @ back))
    v = vectors[:, np.argmax(values.real)].real
    v = v if v[0] > 0 else -v
    w = -back @ v
    Q = np.array([[v[0], v[5], v[4]], [v[5], v[1], v[3]], [v[4], v[3], v[2]]])
    centre = -np.linalg.solve(Q, w[:3])
    try:
        K = np.linalg.cholesky(Q / (centre @ Q @ centre - w[3])).T
    except np.linalg.LinAlgError:
        return None
    return K / radius, radius * centre


def error(fit, H, offset, radius):
    """What the norm is off over even directions, 1e-3 of the radius (mg of an accelerometer)."""
    if fit is None:
        return np.nan
    readings = radius * even_directions(300) @ np.linalg.inv(H).T + offset
    return 1000 * np.sqrt(np.mean((np.linalg.norm((readings - fit[1]) @ fit[0].T, axis=1) - 1) ** 2))


def accelerometer(random, n, noise):
    H = np.eye(3) + np.diag(random.normal(0, 0.02, 3))
    H[np.triu_indices(3, 1)] = H[np.tril_indices(3, -1)] = random.normal(0, 0.005, 3)
    H = 0.5 * (H + H.T)
    u = np.vstack([np.eye(3), -np.eye(3)]) + random.normal(0, 0.1, (6, 3)) if n == 6 else random.normal(size=(n, 3))
    return u, H, random.normal(0, 0.3, 3), GRAVITY_MPS2, noise


def magnetometer(cover):
    def draw(random, n, noise):
        H, offset = np.eye(3) + random.normal(0, 0.06, (3, 3)), random.normal(0, 30, 3)
        u = random.normal(size=(n, 3))
        u /= np.linalg.norm(u, axis=1)[:, None]
        u[:, 2] = abs(u[:, 2]) if cover == "half" else 0.35 * u[:, 2] if cover == "band" else u[:, 2]
        return u, H, offset, FIELD_UT, noise

    return draw


def compare(stillpoint, name, draw, n, noise):
    errors = {"imu_tk": [], "magneto": [], "map": [], "adjusted": []}
    for seed in range(SEEDS):
        random = np.random.default_rng(seed)
        u, H, offset, radius, sd = draw(random, n, noise)
        u /= np.linalg.norm(u, axis=1)[:, None]
        points = radius * u @ np.linalg.inv(H).T + offset + random.normal(0, sd, (n, 3))
        for method in errors:
            if method == "imu_tk" and radius != GRAVITY_MPS2:
                continue
            fit = {"imu_tk": imu_tk, "magneto": magneto}.get(method)
            fit = fit(points, radius) if fit else ours(stillpoint, points, method)
            errors[method].append(error(fit, H, offset, radius))
    print(f"{name:28s}{n:6d}{noise:8.3f}" + "".join(cell(np.array(e)) for e in errors.values()))


def cell(errors):
    if not errors.size:
        return f"{'-':>9s}     "
    failed = np.isnan(errors).sum()
    value = f"{np.sqrt(np.nanmean(np.square(errors))):9.2f}" if failed < SEEDS else f"{'none':>9s}"
    return f"{value} ({failed:2d})"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("stillpoint", help="for example build/release/stillpoint")
    stillpoint = parser.parse_args().stillpoint
    if np is None:
        sys.exit(f"numpy is missing for {sys.executable}: apt-get install python3-numpy, and run with /usr/bin/python3")
    if shutil.which(stillpoint) is None:
        parser.error(f"{stillpoint}: no such program; build it first")
    print(f"rms over {SEEDS} seeds of what the norm is off over EVEN directions, 1e-3 of the radius (mg); (failed fits)")
    print(f"{'':28s}{'points':>6s}{'noise':>8s}{'imu_tk':>14s}{'magneto':>14s}{'map':>14s}{'adjusted':>14s}")
    for n in (6, 9, 12, 24):
        for noise in (0.002, 0.02):
            compare(stillpoint, "accelerometer, m/s^2", accelerometer, n, noise)
    for cover in ("full", "half", "band"):
        for n, noise in ((50, 0.3), (300, 0.3), (300, 1.5)):
            compare(stillpoint, f"magnetometer, {cover}, uT", magnetometer(cover), n, noise)


if __name__ == "__main__":
    main()
