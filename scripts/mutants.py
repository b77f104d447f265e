#!/usr/bin/env python3
"""Breaks one thing at a time in a copy of this tree and tells which breaks the unit tests notice.

  mutants.py --list --module fusion                 every mutant
  mutants.py --module fusion pipeline --count 40    forty of them, drawn by --seed: killed, survived, did not compile
  mutants.py --only 'fusion/hard_iron.cpp:104'      those whose name matches

A mutant is a changed sign, bound, connective, index or constant, or a dropped statement (mutation.py). Only the unit
tests of its module are built and run. Mutants that change nothing anyone could see stand in mutants_equivalent.txt and
do not count. The copy lies in a temporary folder; --folder keeps it, and what was built there, for the next time."""
import argparse
import collections
import math
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import mutation

ROOT = pathlib.Path(__file__).resolve().parent.parent
EQUIVALENT = pathlib.Path(__file__).with_name("mutants_equivalent.txt")
COMPENSATION = r"pipeline/(compensate|correct)_stage\.|core/calibration\."

# What is mutated (a pattern of paths), and the test programs that are to notice, or PROGRAM:FILTER of its tests. The
# daemon's configuration and DDS are tested through whole programs (test_apps, test_dds), which takes too long for each
# mutant.
MODULES = {
    "calib_online": (r"calib_online/", ["test_calib_online", "test_pipeline"]),
    "fusion": (r"fusion/", ["test_fusion"]),
    "compensation": (COMPENSATION, ["test_pipeline", "test_core"]),
    "pipeline": (rf"(?!{COMPENSATION})pipeline/", ["test_pipeline", "test_threads", "test_allocations"]),
    "io": (r"io/(?!dds_|config|source_config)", ["test_io", "test_simulation", "test_sources"]),
    "sources": (r"sources/|io/source_config", ["test_sources"]),
    "diagnosis": (r"diagnosis/", ["test_diagnosis:*GoldenAnswers*", "test_diagnosis"]),  # seconds, then minutes
}
LARGEST_MEMORY = 6 << 30  # of one test program: a mutant may ask for any amount
PATIENCE, LEAST_PATIENCE_S = 3.0, 30.0  # of the time that the tests take without a mutant


def sources():
    """The files of the tree, with what is not committed yet; outside of a checkout all but builds."""
    told = subprocess.run(["git", "-C", ROOT, "ls-files", "-co", "--exclude-standard", "-z"], capture_output=True)
    if told.returncode == 0:
        return [p for p in told.stdout.decode().split("\0") if p and (ROOT / p).is_file()]
    found = [str(p.relative_to(ROOT)) for p in ROOT.rglob("*") if p.is_file()]
    return sorted(p for p in found if not p.startswith("build"))


def mutants(modules):
    """{module: its mutants}, without those listed as equivalent."""
    paths = sorted(p for p in sources() if p.endswith((".cpp", ".h")))
    equivalent = {}
    for number, line in enumerate(EQUIVALENT.read_text().splitlines(), 1):
        if line and not line.startswith("#"):
            path, before, after, reason = (part.strip() for part in line.split(" | "))
            equivalent[path, before, after] = (number, reason)
    out, met = {}, set()
    for module in modules:
        found = [m for p in paths if re.match(MODULES[module][0], p) for m in mutation.mutants_of(p, (ROOT / p).read_text())]
        out[module] = [m for m in found if m.key not in equivalent]
        met |= {m.key for m in found} & equivalent.keys()
    for key, (number, _) in equivalent.items():
        if key not in met and any(re.match(MODULES[m][0], key[0]) for m in modules):
            print(f"{EQUIVALENT.name}:{number}: no such mutant (any more)", file=sys.stderr)
    return out


def draw(pool, count, seed):
    """So many of them, each as likely as any other, in their order; the same ones for the same seed."""
    if count is None or count >= len(pool):
        return pool
    return [pool[k] for k in sorted(random.Random(seed).sample(range(len(pool)), count))]


def wilson(part, whole, z=1.96):
    """95 % interval of a share."""
    if whole == 0:
        return 0.0, 1.0
    p = part / whole
    middle = (p + z * z / (2 * whole)) / (1 + z * z / whole)
    half = z / (1 + z * z / whole) * math.sqrt(p * (1 - p) / whole + z * z / (4 * whole * whole))
    return middle - half, middle + half


def limited():
    resource.setrlimit(resource.RLIMIT_AS, (LARGEST_MEMORY, LARGEST_MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def failure(target, shard, told):
    told.seek(0)
    failed = re.search(r"\[  FAILED  \] (\w+\.[\w/]+)", told.read())
    return failed[1] if failed else f"{target} ends with {shard.returncode}"


class Copy:
    """The tree, its build and what a build without any mutant does."""

    def __init__(self, folder, jobs):
        self.tree, self.jobs = folder / "stillpoint", jobs
        self.build = self.tree / "build/mutants"
        self.usual_s = {}
        self.copy()
        shared = folder / "shared"  # recordings lie beside a checkout
        if (ROOT.parent / "shared").is_dir() and not shared.exists():
            shared.symlink_to((ROOT.parent / "shared").resolve())
        if not (self.build / "build.ninja").exists():
            # A dropped statement leaves names unused, which is no reason to refuse it; a mutant that the start of its
            # program shows is to be seen by the tests and not by their discovery.
            failed, told = self.run(["cmake", "-S", self.tree, "-B", self.build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                                     "-DCMAKE_CXX_FLAGS=-w", "-DSTILLPOINT_PYTHON=OFF",
                                     "-DCMAKE_GTEST_DISCOVER_TESTS_DISCOVERY_MODE=PRE_TEST"])
            if failed:
                sys.exit(told)

    def copy(self):
        """Only what differs is written, so that an earlier build serves again."""
        wanted = set(sources())
        for path in wanted:
            to = self.tree / path
            if not to.exists() or to.read_bytes() != (ROOT / path).read_bytes():
                to.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(ROOT / path, to)
        for to in self.tree.rglob("*"):
            inside = str(to.relative_to(self.tree))
            if to.is_file() and not inside.startswith("build/") and inside not in wanted:
                to.unlink()

    def run(self, command):
        done = subprocess.run(command, capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr

    def compile(self, targets):
        return self.run(["ninja", "-C", self.build, f"-j{self.jobs}", *{target.partition(":")[0] for target in targets}])

    def test(self, target, patience_s):
        """None when every test passes; otherwise which did not. The tests are dealt out to as many processes as jobs."""
        program, _, chosen = target.partition(":")
        shards = []
        for k in range(self.jobs):
            told = tempfile.TemporaryFile("w+")
            dealt = {**os.environ, "GTEST_TOTAL_SHARDS": str(self.jobs), "GTEST_SHARD_INDEX": str(k)}
            command = [self.build / "tests" / program, "--gtest_fail_fast", "--gtest_brief=1", f"--gtest_filter={chosen or '*'}"]
            shards.append((subprocess.Popen(command, env=dealt, cwd=self.build / "tests", stdout=told, stderr=told,
                                            start_new_session=True, preexec_fn=limited), told))
        end = time.monotonic() + patience_s
        by = None
        while not by and any(shard.poll() is None for shard, _ in shards) and time.monotonic() < end:
            time.sleep(0.05)
            by = next((failure(target, *s) for s in shards if s[0].poll()), None)
        by = by or next((failure(target, *s) for s in shards if s[0].poll()), None)
        if not by and any(shard.poll() is None for shard, _ in shards):
            by = f"{target} takes too long"
        for shard, _ in shards:
            try:
                os.killpg(shard.pid, signal.SIGKILL)  # and what the tests have started
            except ProcessLookupError:
                pass
            shard.wait()
        return by

    def prepare(self, targets):
        """Without a mutant everything must pass; how long that takes bounds the patience with mutants."""
        failed, told = self.compile(targets)
        if failed:
            sys.exit(f"{told[-3000:]}\nthe tree does not build without a mutant")
        for target in targets:
            start = time.monotonic()
            by = self.test(target, 3600.0)
            self.usual_s[target] = time.monotonic() - start
            if by:
                sys.exit(f"without a mutant already: {by}")

    def judge(self, mutant, targets):
        path = self.tree / mutant.path
        text = path.read_text()
        path.write_text(mutation.applied(text, mutant))
        try:
            if self.compile(targets)[0]:
                return "did not compile", ""
            for target in targets:
                by = self.test(target, max(LEAST_PATIENCE_S, PATIENCE * self.usual_s[target]))
                if by:
                    return "killed", by
            return "survived", ""
        finally:
            path.write_text(text)


def report(results):
    print(f"\n{'module':14}{'drawn':>6}{'no build':>9}{'killed':>7}{'survived':>9}  share killed, 95 % (Wilson)")
    total = collections.Counter()
    for module, counts in [*results.items(), ("all", total)]:
        if module != "all":
            total += counts
        killed, survived = counts["killed"], counts["survived"]
        if killed + survived == 0:
            continue
        low, high = wilson(killed, killed + survived)
        share = 100 * killed / (killed + survived)
        print(f"{module:14}{sum(counts.values()):6}{counts['did not compile']:9}{killed:7}{survived:9}  "
              f"{share:.0f} % [{100 * low:.0f}, {100 * high:.0f}]")


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--module", nargs="+", choices=MODULES, default=list(MODULES), metavar="MODULE", help=", ".join(MODULES))
    parser.add_argument("--count", type=int, help="so many, drawn evenly from all (default: every one)")
    parser.add_argument("--seed", type=int, default=1, help="of the draw (default: 1)")
    parser.add_argument("--only", help="regular expression of the names PATH:LINE:COLUMN OPERATOR to draw from")
    parser.add_argument("--list", action="store_true", help="name the mutants and stop")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="compilers, and test processes, at once")
    parser.add_argument("--folder", type=pathlib.Path, help="keep the copy and its build here")
    return parser.parse_args()


def show(mutant, verdict="", by=""):
    print(f"{verdict:16}{mutant.id}" + (f"  by {by}" if by else "") + f"\n    - {mutant.before.strip()}\n    + {mutant.after.strip()}",
          flush=True)


def main():
    given = arguments()
    pool = [(module, m) for module, found in mutants(given.module).items() for m in found
            if not given.only or re.search(given.only, m.id)]
    drawn = draw(pool, given.count, given.seed)
    if given.list:
        for _, m in drawn:
            show(m)
        return 0
    print(f"{len(drawn)} of {len(pool)} mutants, seed {given.seed}", flush=True)
    folder = (given.folder or pathlib.Path(tempfile.mkdtemp(prefix="stillpoint-mutants-"))).resolve()
    results = collections.defaultdict(collections.Counter)
    try:
        copy = Copy(folder, given.jobs)
        copy.prepare(list(dict.fromkeys(t for module, _ in drawn for t in MODULES[module][1])))
        for module, m in drawn:
            verdict, by = copy.judge(m, MODULES[module][1])
            results[module][verdict] += 1
            show(m, verdict, by)
    except KeyboardInterrupt:
        print("\nstopped", file=sys.stderr)
    finally:
        if not given.folder:
            shutil.rmtree(folder, ignore_errors=True)
    report(results)
    return 0


if __name__ == "__main__":
    sys.exit(main())
