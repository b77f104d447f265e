#!/usr/bin/env python3
"""Runs the commands of a page as its reader would: page_test.py PROGRAMS SHARED PAGE [SETUP].

Every block ```sh of PAGE is run by bash, one after the other in one folder, with the programs in PATH and `../shared`
beside it. A block ```text after it is what it must print: each of its lines in this order, blanks counting once. A block
after the comment <!-- until stopped --> is stopped when it has printed that. SETUP is a script that makes the reader's own
files first. Exit code 77 where a page needs recordings that are not here."""
import os
import pathlib
import re
import select
import signal
import subprocess
import sys
import tempfile
import time

LONGEST_S = 300  # until a block that runs until it is stopped has printed what the page says
FENCE = re.compile(r"^( *)```(\w*)\n(.*?)^ *```", re.M | re.S)


def blocks(page):
    """Of each block ```sh its text without the indent, what it must print, and whether it runs until it is stopped."""
    fences = list(FENCE.finditer(page))
    for m, after in zip(fences, fences[1:] + [None]):
        if m[2] == "sh":
            expected = lines_of(after) if after and after[2] == "text" else ""
            yield lines_of(m), expected, page[:m.start()].rstrip().endswith("<!-- until stopped -->")


def lines_of(fence):
    return "\n".join(line[len(fence[1]):] for line in fence[3].splitlines())


def run(text, expected, folder, environment, until_stopped):
    process = subprocess.Popen(["bash", "-euo", "pipefail", "-c", text], cwd=folder, env=environment,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
    printed, stopped, end_s = b"", None, time.monotonic() + LONGEST_S
    while True:
        if until_stopped and stopped is None:
            failed = process.poll() not in (None, 0)  # what it left in the background would hold the pipe
            if failed or missing_line(expected, printed.decode(errors="replace")) is None or time.monotonic() > end_s:
                os.killpg(process.pid, signal.SIGTERM)
                stopped = process.returncode if failed else 0
        if select.select([process.stdout], [], [], 1.0)[0]:
            piece = os.read(process.stdout.fileno(), 65536)
            if not piece:
                break
            printed += piece
    code = process.wait()
    return code if stopped is None else stopped, printed.decode()


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
        ran = 0
        for block, expected, until_stopped in blocks(text):
            code, printed = run(block, expected, folder, environment, until_stopped)
            ran += 1
            if code != 0:
                print(f"{page}: this ended with {code}:\n{block}\n{printed}")
                return 1
            line = missing_line(expected, printed)
            if line is not None:
                print(f"{page}: not printed, or not in this order: {line}\nprinted was:\n{printed}")
                return 1
    print(f"{page}: {ran} blocks do what the page says")
    return 0 if ran else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
