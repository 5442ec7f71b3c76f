"""Does the server keep its rates as well as this machine lets anyone? At each rate haptic_server, on a scene with its
simulated device, and cyclictest (rt-tests), with the same period and priority, run in the same instant, each on a
processor of its own; from round to round they change places. So whatever holds up the whole machine holds up both:
the server's missed ticks beside the periods that cyclictest slept through. Most are missed in a few stalls, which meet one
processor or the other by chance: server_misses_more_p tells how likely a sum of differences as large as this one is where
chance decides in each round which of the two is which. Prints JSON.

usage: servo_rates.py HAPTIC_SERVER SCENE [--seconds N] [--rounds N] [--rates HZ,...] [--assets FOLDER]
"""

import argparse
import json
import os
import random
import subprocess
import sys
import tempfile
from pathlib import Path

PRIORITY = 80  # the servo thread's
LONGEST_US = 100_000  # wake-ups later than this count as this late
NEEDS_TWO = 2  # exit code


def start_server(options, rate_hz, cpu, summary, more=()):
    """Returns once its servo runs. `more`: options for it."""
    process = subprocess.Popen(
        [options.server, "--scene", options.scene, "--assets", options.assets, "--listen", "127.0.0.1:0", "--rate",
         str(rate_hz), "--seconds", str(options.seconds), "--pin", str(cpu), "--summary", summary,
         "--recordings", summary.parent, *more],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    process.stdout.readline()
    return process


def server_figures(summary):
    run = json.loads(summary.read_text())
    return {"ticks": run["ticks"], "missed": run["missed_ticks"], "allocations": run["allocations_in_servo"],
            "p50_us": run["wake_latency_ns"]["p50"] / 1e3, "p99_us": run["wake_latency_ns"]["p99"] / 1e3,
            "tick_p50_us": run["tick_ns"]["p50"] / 1e3, "tick_p99_us": run["tick_ns"]["p99"] / 1e3}


def start_cyclictest(options, rate_hz, cpu, report):
    return subprocess.Popen(
        ["cyclictest", "--mlockall", f"--priority={PRIORITY}", f"--interval={round(1e6 / rate_hz)}",
         f"--affinity={cpu}", f"--duration={options.seconds}", f"--histogram={LONGEST_US}", "--quiet",
         f"--json={report}"],
        stdout=subprocess.DEVNULL)


def cyclictest_figures(report, rate_hz):
    """From a histogram of the times between deadline and wake-up, in microseconds."""
    period_us = round(1e6 / rate_hz)
    thread = json.loads(report.read_text())["thread"]["0"]
    late = sorted((int(us), count) for us, count in thread["histogram"].items())
    beyond = thread["cycles"] - sum(count for _, count in late)
    late += [(LONGEST_US, beyond)] if beyond > 0 else []

    def quantile(part):
        seen = 0
        for us, count in late:
            seen += count
            if seen >= part * thread["cycles"]:
                return us
        return LONGEST_US

    return {"wake_ups": thread["cycles"], "missed": sum(us // period_us * count for us, count in late),
            "late_wake_ups": sum(count for us, count in late if us >= period_us),
            "p50_us": quantile(0.5), "p99_us": quantile(0.99)}


def run_both(options, rate_hz, cpus, folder, more=()):
    summary, report = folder / "server.json", folder / "cyclictest.json"
    server = start_server(options, rate_hz, cpus[0], summary, more)
    cyclictest = start_cyclictest(options, rate_hz, cpus[1], report)
    for process in (cyclictest, server):
        if process.wait() != 0:
            raise subprocess.CalledProcessError(process.returncode, process.args)
    server.stdout.close()
    return server_figures(summary), cyclictest_figures(report, rate_hz)


def misses_more_p(server, cyclictest):
    """One-sided, of missed ticks in each round: a permutation test of pairs, by drawn signs."""
    draws, signs = 20_000, random.Random(1)
    differences = [a - b for a, b in zip(server, cyclictest)]
    as_many = sum(sum(d * signs.choice((-1, 1)) for d in differences) >= sum(differences) for _ in range(draws))
    return as_many / draws


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("server")
    parser.add_argument("scene")
    parser.add_argument("--assets", default="/usr/share/inventor/data")
    parser.add_argument("--seconds", type=int, default=1, help="of each round")
    parser.add_argument("--rounds", type=int, default=24, help="an even number is fair to both")
    parser.add_argument("--rates", default="1000,2000,4000,10000,20000", help="Hz")
    options = parser.parse_args()
    cpus = sorted(os.sched_getaffinity(0))[:2]
    if len(cpus) < 2:
        print("needs two processors", file=sys.stderr)
        return NEEDS_TWO
    rows = []
    for rate_hz in map(int, options.rates.split(",")):
        pieces = {"server": [], "cyclictest": []}
        with tempfile.TemporaryDirectory() as folder:
            for i in range(options.rounds):
                server, cyclictest = run_both(options, rate_hz, cpus[::-1] if i % 2 else cpus, Path(folder))
                pieces["server"].append(server)
                pieces["cyclictest"].append(cyclictest)
        row = {"rate_hz": rate_hz}
        for who, runs in pieces.items():
            for key in runs[0]:
                values = sorted(run[key] for run in runs)
                row[f"{who}_{key}"] = values[len(values) // 2] if key.endswith("_us") else sum(values)
        row["server_missed_in_each_round"] = [run["missed"] for run in pieces["server"]]
        row["cyclictest_missed_in_each_round"] = [run["missed"] for run in pieces["cyclictest"]]
        row["server_misses_more_p"] = misses_more_p(row["server_missed_in_each_round"],
                                                    row["cyclictest_missed_in_each_round"])
        rows.append(row)
    print(json.dumps({"seconds_each": options.seconds, "rounds": options.rounds, "same_instant": True, "rates": rows},
                     indent=2))
    return 0


if __name__ == "__main__":
    sys.exit(main())
