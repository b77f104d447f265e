#!/usr/bin/env python3
"""Packs the built package folder as a wheel: make_wheel.py PACKAGE_FOLDER VERSION OUTPUT_FOLDER. Needs no network."""
import base64
import hashlib
import pathlib
import sys
import sysconfig
import zipfile

package, version, out = pathlib.Path(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
python = f"cp{sys.version_info.major}{sys.version_info.minor}"
tag = f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
info = f"stillpoint-{version}.dist-info"
members = {f"stillpoint/{p.name}": p.read_bytes() for p in sorted(package.iterdir()) if p.is_file()}
members[f"{info}/METADATA"] = (
    f"Metadata-Version: 2.1\nName: stillpoint\nVersion: {version}\nRequires-Python: >=3.9\nRequires-Dist: numpy\n"
    "Summary: Self-calibrating attitude, and the physics a simulation left out\nLicense: MIT\n").encode()
members[f"{info}/WHEEL"] = (
    f"Wheel-Version: 1.0\nGenerator: stillpoint\nRoot-Is-Purelib: false\nTag: {tag}\n").encode()
record = "".join(
    f"{name},sha256={base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()},{len(data)}\n"
    for name, data in members.items())
members[f"{info}/RECORD"] = (record + f"{info}/RECORD,,\n").encode()
out.mkdir(parents=True, exist_ok=True)
path = out / f"stillpoint-{version}-{tag}.whl"
with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as wheel:
    for name, data in members.items():
        wheel.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), data, zipfile.ZIP_DEFLATED)
print(path)
