"""Does the server keep its rates as well as this machine lets anyone? At each rate, in turn, haptic_server on a scene
with its simulated device, and cyclictest (rt-tests) with the same period and priority: the server's missed ticks beside
the periods that cyclictest slept through. Prints JSON.

usage: servo_rates.py HAPTIC_SERVER SCENE [--seconds N] [--rounds N] [--rates HZ,...] [--assets FOLDER]
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

PRIORITY = 80  # the servo thread's
LONGEST_US = 100_000  # wake-ups later than this count as this late


def server_run(options, rate_hz, out):
    summary = out / "server.json"
    subprocess.run([options.server, "--scene", options.scene, "--assets", options.assets, "--listen", "127.0.0.1:0",
                    "--rate", str(rate_hz), "--seconds", str(options.seconds), "--summary", summary],
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    run = json.loads(summary.read_text())
    return {"ticks": run["ticks"], "missed": run["missed_ticks"], "allocations": run["allocations_in_servo"],
            "p50_us": run["wake_latency_ns"]["p50"] / 1e3, "p99_us": run["wake_latency_ns"]["p99"] / 1e3,
            "tick_p50_us": run["tick_ns"]["p50"] / 1e3, "tick_p99_us": run["tick_ns"]["p99"] / 1e3}


def cyclictest_run(options, rate_hz, out):
    """Times between deadline and wake-up, as a histogram of microseconds."""
    report = out / "cyclictest.json"
    period_us = round(1e6 / rate_hz)
    subprocess.run(["cyclictest", "--mlockall", f"--priority={PRIORITY}", f"--interval={period_us}",
                    f"--duration={options.seconds}", f"--histogram={LONGEST_US}", "--quiet", f"--json={report}"],
                   check=True, stdout=subprocess.DEVNULL)
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


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("server")
    parser.add_argument("scene")
    parser.add_argument("--assets", default="/usr/share/inventor/data")
    parser.add_argument("--seconds", type=int, default=4, help="of each piece")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--rates", default="1000,2000,4000,10000,20000", help="Hz")
    options = parser.parse_args()
    rows = []
    for rate_hz in map(int, options.rates.split(",")):
        pieces = {"server": [], "cyclictest": []}
        with tempfile.TemporaryDirectory() as folder:
            for _ in range(options.rounds):
                pieces["server"].append(server_run(options, rate_hz, Path(folder)))
                pieces["cyclictest"].append(cyclictest_run(options, rate_hz, Path(folder)))
        row = {"rate_hz": rate_hz}
        for who, runs in pieces.items():
            for key in runs[0]:
                values = sorted(run[key] for run in runs)
                row[f"{who}_{key}"] = values[len(values) // 2] if key.endswith("_us") else sum(values)
        row["server_missed_in_each_round"] = [run["missed"] for run in pieces["server"]]
        row["cyclictest_missed_in_each_round"] = [run["missed"] for run in pieces["cyclictest"]]
        rows.append(row)
    print(json.dumps({"seconds_each": options.seconds, "rounds": options.rounds, "rates": rows}, indent=2))


if __name__ == "__main__":
    main()
