#!/usr/bin/env python3
"""Runs the commands of a page as its reader would: page_test.py PROGRAMS SHARED PAGE [SETUP].

Every block ```sh of PAGE is run by bash, one after the other in one folder, with the programs in PATH and `../shared`
beside it. A block ```text after it is what it must print: each of its lines in this order, blanks counting once. A block
after the comment <!-- until stopped --> is stopped after some seconds. SETUP is a script that makes the reader's own
files first. Exit code 77 where a page needs recordings that are not here."""
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile

STOPPED_AFTER_S = 20
FENCE = re.compile(r"^( *)```(\w*)\n(.*?)^ *```", re.M | re.S)


def blocks(page):
    """Of each fenced block its language, its text without the indent, and whether it runs until it is stopped."""
    for m in FENCE.finditer(page):
        text = "\n".join(line[len(m[1]):] for line in m[3].splitlines())
        yield m[2], text, page[:m.start()].rstrip().endswith("<!-- until stopped -->")


def run(text, folder, environment, until_stopped):
    process = subprocess.Popen(["bash", "-euo", "pipefail", "-c", text], cwd=folder, env=environment, text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
    try:
        printed, _ = process.communicate(timeout=STOPPED_AFTER_S if until_stopped else None)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGTERM)
        printed, _ = process.communicate()
        return 0, printed
    return process.returncode, printed


def missing_line(expected, printed):
    """The first line of what is expected that does not come, in order, in what was printed; None: all do."""
    rest = " ".join(printed.split())
    for line in expected.splitlines():
        wanted = " ".join(line.split())
        at = rest.find(wanted)
        if at < 0:
            return line
        rest = rest[at + len(wanted):]
    return None


def main(programs, shared, page, setup=None):
    text = pathlib.Path(page).read_text(encoding="utf-8")
    shared = pathlib.Path(shared).resolve()
    if "../shared/" in text and not shared.is_dir():
        print(f"LOUD: SKIPPED, {page} needs {shared}, which is absent")
        return 77
    root = pathlib.Path(page).resolve().parent.parent
    with tempfile.TemporaryDirectory() as room:
        folder = pathlib.Path(room, "work")
        folder.mkdir()
        os.symlink(shared, pathlib.Path(room, "shared"))
        os.symlink(root / "configs", folder / "configs")
        environment = dict(os.environ, PATH=f"{pathlib.Path(programs).resolve()}:{os.environ['PATH']}")
        if setup:
            subprocess.run([pathlib.Path(setup).resolve()], cwd=folder, env=environment, check=True)
        printed, ran = "", 0
        for language, block, until_stopped in blocks(text):
            if language == "sh":
                code, printed = run(block, folder, environment, until_stopped)
                ran += 1
                if code != 0:
                    print(f"{page}: this ended with {code}:\n{block}\n{printed}")
                    return 1
            elif language == "text":
                line = missing_line(block, printed)
                if line is not None:
                    print(f"{page}: not printed, or not in this order: {line}\nprinted was:\n{printed}")
                    return 1
    print(f"{page}: {ran} blocks do what the page says")
    return 0 if ran else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
