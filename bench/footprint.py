#!/usr/bin/env python3
"""What the daemon needs: time to the first attitude, memory and its growth, processor share, sizes of the programs;
and what a subscriber that listens all the while lost.

`bench/footprint.py BUILD_FOLDER [--rate 1000] [--seconds 10] [--threads 'cpu_latency_us: 0'] [--json]`. The sensor is the simulated one of
configs/sim_handheld.yaml at this rate; the figures include the simulator, which runs in the sensor thread.
Without --threads the stages are timed a second time, for at most 10 s, with no processor asleep (`cpu_latency_us: 0`).
A soak is the same command with more seconds: `--rate 4000 --seconds 1800`.
"""
import argparse
import json
import os
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import time

CONFIGS = pathlib.Path(__file__).resolve().parent.parent / "configs"


def write_sensor(path, rate_hz, seconds):
    text = (CONFIGS / "sim_handheld.yaml").read_text()
    text = re.sub(r"rate_hz: \d+", f"rate_hz: {rate_hz:g}", text, count=1)
    path.write_text(re.sub(r"duration_s: \d+", f"duration_s: {seconds:g}", text, count=1))


def memory_kB(pid):
    fields = dict(line.split(":", 1) for line in open(f"/proc/{pid}/status") if ":" in line)
    return int(fields["VmRSS"].split()[0]), int(fields["VmHWM"].split()[0])


def processor_s(pid):
    """Seconds of processor time of each thread so far, by name."""
    used = {}
    for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
        name, fields = (task / "stat").read_text().split("(", 1)[1].rsplit(")", 1)
        ticks = int(fields.split()[11]) + int(fields.split()[12])
        used[name] = used.get(name, 0.0) + ticks / os.sysconf("SC_CLK_TCK")
    return used


def unused_domain():
    """A DDS domain in which nobody of this machine listens on the discovery port."""
    for domain in range(1, 101):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("", 7400 + 250 * domain))
                return str(domain)
            except OSError:
                continue
    sys.exit("footprint: the DDS domains 1 to 100 are all in use on this machine")


class Listener:
    """`stillpoint watch` on the daemon, from the first attitude to the end."""

    def __init__(self, build, domain, folder):
        self.path = folder / "heard.jsonl"
        self.process = subprocess.Popen([build / "stillpoint", "watch", "--domain", domain, "--json", "-"],
                                        stdout=self.path.open("w"), stderr=subprocess.DEVNULL)

    def end(self):
        """received, lost (published, not arrived) and dropped (inside the daemon) attitudes."""
        time.sleep(1.2)  # it prints once a second
        self.process.terminate()
        self.process.wait()
        lines = self.path.read_text().splitlines()
        last = json.loads(lines[-1]) if lines else {}
        return {key: last.get(key, 0) for key in ("received", "lost", "dropped")}


def stripped_size(program):
    with tempfile.NamedTemporaryFile() as copy:
        subprocess.run(["strip", "-o", copy.name, program], check=True)
        return os.path.getsize(copy.name)


def measure(build, rate_hz, seconds, threads):
    domain = unused_domain()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        write_sensor(folder / "sensor.yaml", rate_hz, seconds + 10)
        (folder / "daemon.yaml").write_text(
            "source: {kind: simulation, file: sensor.yaml, speed: 1, at_end: stop}\n"
            f"sensor: {{id: footprint}}\ndds: {{domain: {domain}}}\nthreads: {{{threads}}}\n")
        watch = subprocess.Popen([build / "stillpoint", "watch", "--domain", domain, "--once", "--seconds", "0.01",
                                  "--json", "-"], stdout=subprocess.DEVNULL)
        time.sleep(0.5)
        start = time.monotonic()
        log = folder / "daemon.log"
        daemon = subprocess.Popen([build / "stillpointd", "--config", folder / "daemon.yaml"], stderr=log.open("w"))
        try:
            if watch.wait(timeout=15) != 0:
                sys.exit("footprint: no attitude arrived; does the daemon start?")
            first_s = time.monotonic() - start
            listener = Listener(build, domain, folder)
            time.sleep(1.0)
            course_kB = [memory_kB(daemon.pid)[0]]
            used_before, t_before = processor_s(daemon.pid), time.monotonic()
            for _ in range(10):
                time.sleep(seconds / 10)
                course_kB.append(memory_kB(daemon.pid)[0])
            used, t_after = processor_s(daemon.pid), time.monotonic()
            _, rss_peak = memory_kB(daemon.pid)
            heard = listener.end()
        finally:
            daemon.terminate()
            daemon.wait()
        said = log.read_text()
        sys.stderr.writelines(line for line in said.splitlines(True) if "threads." in line)  # what was refused
        processing = re.search(r"processing_us p50=([\d.]+) p99=([\d.]+)", said)
    share = {name: (s - used_before.get(name, 0.0)) / (t_after - t_before) for name, s in used.items()}
    return {
        "schema": "stillpoint.footprint/1",
        "rate_hz": rate_hz,
        "seconds": seconds,
        "threads": threads,
        "start_to_first_attitude_s": round(first_s, 3),
        "rss_MB": course_kB[-1] / 1024,
        "rss_peak_MB": rss_peak / 1024,
        "rss_growth_MB": (course_kB[-1] - course_kB[0]) / 1024,
        "rss_course_MB": [round(kB / 1024, 2) for kB in course_kB],
        "attitudes": heard,
        "processing_us": {"p50": float(processing[1]), "p99": float(processing[2])},
        "processor_share_of_one_core": sum(share.values()),
        "processor_share_by_thread": {name: round(s, 4) for name, s in sorted(share.items(), key=lambda e: -e[1]) if s > 0},
        "stripped_MB": {name: stripped_size(build / name) / 2**20 for name in ("stillpointd", "stillpoint")
                        if (build / name).exists()},
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=pathlib.Path, help="for example build/release")
    parser.add_argument("--rate", type=float, default=1000.0, help="Hz")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--threads", default="", help="of the daemon's configuration, for example 'cpu_latency_us: 0'")
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    for name in ("stillpointd", "stillpoint"):
        if not (args.build / name).exists():
            sys.exit(f"footprint: {args.build / name}: no such program; build it first")
    found = measure(args.build.resolve(), args.rate, args.seconds, args.threads)
    if not args.threads and os.access("/dev/cpu_dma_latency", os.W_OK):
        awake = measure(args.build.resolve(), args.rate, min(10.0, args.seconds), "cpu_latency_us: 0")
        found["awake"] = {key: awake[key] for key in ("processing_us", "processor_share_of_one_core", "processor_share_by_thread")}
    if args.json:
        print(json.dumps(found, indent=2))
        return
    print(f"start to the first attitude in a waiting subscriber  {found['start_to_first_attitude_s']:.2f} s (to 0.04 s)")
    print(f"resident memory  {found['rss_MB']:.1f} MB, at most {found['rss_peak_MB']:.1f} MB; "
          f"growth in {args.seconds:.0f} s {found['rss_growth_MB']:.2f} MB")
    print(f"    after each tenth  {' '.join(str(mb) for mb in found['rss_course_MB'])}")
    heard = found["attitudes"]
    print(f"attitudes heard  {heard['received']}, lost {heard['lost']}, dropped in the daemon {heard['dropped']}")
    for run, when in ((found, ""), (found.get("awake"), ", no processor asleep")):
        if run:
            print(f"stages, per sample{when}  p50 {run['processing_us']['p50']:.2f} us, p99 {run['processing_us']['p99']:.2f} us")
            print(f"processor at {args.rate:.0f} Hz{when}  {100 * run['processor_share_of_one_core']:.1f} % of one core")
            for name, share in run["processor_share_by_thread"].items():
                print(f"    {name:<18}{100 * share:5.1f} %")
    for name, size in found["stripped_MB"].items():
        print(f"{name}  {size:.2f} MB stripped")


if __name__ == "__main__":
    main()
