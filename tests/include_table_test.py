#!/usr/bin/env python3
"""Holds every #include to the layer table of docs/decisions/001-layers.md: `include_table_test.py ROOT`."""
import pathlib
import re
import sys

MAY_INCLUDE = {
    "core": set(),
    "idl": set(),
    "calib_online": {"core"},
    "fusion": {"core"},
    "laws": {"core"},
    "simulation": {"core", "laws"},
    "io": {"core", "idl", "simulation", "calib_online", "fusion", "pipeline"},
    "report": set(),
    "exchange": {"core", "io", "simulation"},
    "pipeline": {"core", "calib_online", "fusion"},
    "c_api": {"core", "calib_online", "pipeline"},
    "diagnosis": {"core", "laws", "simulation", "calib_online", "io", "report"},
    "sources": {"core", "idl", "pipeline", "io"},
    "python": {"core", "c_api", "io", "pipeline", "diagnosis"},
    "apps": {"core", "laws", "calib_online", "fusion", "simulation", "io", "pipeline", "sources", "diagnosis", "report", "exchange"},
}
INCLUDE = re.compile(r'\s*#\s*include\s+(?:"|<stillpoint_)([a-z_]+)/')  # <stillpoint_idl/...> is generated from idl/


def main(root):
    faults = []
    for folder, allowed in MAY_INCLUDE.items():
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in (".h", ".cpp"):
                continue
            for number, line in enumerate(path.read_text().splitlines(), 1):
                match = INCLUDE.match(line)
                if match and match[1] != folder and match[1] in MAY_INCLUDE and match[1] not in allowed:
                    faults.append(f"{path.relative_to(root)}:{number}: {folder} may not include {match[1]}")
    print("\n".join(faults) or f"every include keeps to the table ({len(MAY_INCLUDE)} folders)")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
