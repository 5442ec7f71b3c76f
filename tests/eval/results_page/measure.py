"""Other people's libraries and the built-in methods in the failure scenes and on the exact shapes. Writes OUT.json, from which
page.py makes the results page. A minute or so for each method and seed.

usage: measure.py BIN OUT.json [--seeds N] [--finest TRIANGLES]
"""

import argparse
import collections
import csv
import json
import os
import platform
import re
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
BUILT_IN = ("ours", "pseudocode_closed", "god_object", "finite_proxy_1mm", "global_closest", "intermediate_plane_100Hz")
OUTSIDE = ("bullet", "ode", "mujoco", "vtk_locator")
ACCURACY = ("scene", "triangles", "depth_mm", "ihip_error_max_mm", "force_error_max_N", "direction_error_max_deg",
            "epsilon_p99_ratio", "force_above_100Hz_rms_N", "tick_p50_ns", "tick_p99_ns", "tick_max_ns", "pipe_p50_ns",
            "fault", "pass")


def scenes():
    """Names and what each is about, as haptic_eval has them."""
    text = (HERE.parent / "scenes" / "scenes.h").read_text()
    return dict(re.findall(r'FailureScene\{"([SP]\d+)",\s*"([^"]*)"', text))


def run(program, verb, method, *options, file):
    """The text of what the verb writes."""
    with tempfile.TemporaryDirectory() as out:
        done = subprocess.run([program, verb, "--method", str(method), *options, "--out", out], capture_output=True, text=True)
        written = Path(out) / file
        if not written.exists():
            sys.exit(f"{verb} --method {method}: {done.stderr}")
        return written.read_text()


def cold_ticks(table):
    """Median ticks in ns with every cache swept before, by resolution, where they are measured."""
    rows = csv.DictReader(table.splitlines())
    return {row["triangles"]: float(row["cold_tick_p50_ns"]) for row in rows if float(row["cold_tick_p50_ns"]) > 0}


def failures(records):
    """By scene: how many runs passed, failed, were stopped by a fault of the method, and are not applicable."""
    counts = collections.defaultdict(lambda: {"pass": 0, "fail": 0, "fault": 0, "not_applicable": 0})
    for record in records:
        of = counts[record["scene"]]
        if record["pass"] is None:
            of["not_applicable"] += 1
            of["why"] = record["not_applicable"]
        elif "fault" in record:
            of["fault"] += 1
            of["why"] = record["fault"]
        else:
            of["pass" if record["pass"] else "fail"] += 1
    return counts


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("usage: ")[1])
    parser.add_argument("bin", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--finest", type=int, default=3072)
    options = parser.parse_args()
    program = options.bin / "haptic_eval"
    libraries = [options.bin / "methods" / f"{name}.so" for name in OUTSIDE]
    missing = [str(library) for library in libraries if not library.exists()]
    if missing:
        print("left out, for they are not built:", *missing, file=sys.stderr)
    methods = []
    for method in (*BUILT_IN, *(library for library in libraries if library.exists())):
        print(method, file=sys.stderr)
        seeds, finest = ("--seeds", str(options.seeds)), ("--finest", str(options.finest))
        found = json.loads(run(program, "failures", method, *seeds, file="failures.json"))
        accuracy = json.loads(run(program, "accuracy", method, *finest, file="accuracy.json"))
        accuracy = [r for r in accuracy if r.get("depth_mm", 2) == 2]
        cold = cold_ticks(run(program, "chart", method, *finest, file="chart.csv")) if method in BUILT_IN else {}
        methods.append({"name": found[0]["method"], "outside": method not in BUILT_IN, "version": version(method),
                        "failures": failures(found), "cold_ns": cold,
                        "accuracy": [{key: r[key] for key in ACCURACY if key in r} for r in accuracy]})
    options.out.write_text(json.dumps({
        "repeat": [f"haptic_eval failures --method M --seeds {options.seeds}",
                   f"haptic_eval accuracy --method M --finest {options.finest}",
                   f"haptic_eval chart --method M --finest {options.finest}"],
        "seeds": options.seeds, "scenes": scenes(), "machine": machine(), "methods": methods}, indent=1) + "\n")


def version(method):
    """What a library says that it runs, by the protocol's first message."""
    if method in BUILT_IN:
        return "this project's"
    host = Path(method).parent.parent / "method_host"
    hello = (1).to_bytes(4, "little") + (8).to_bytes(4, "little") + (1).to_bytes(4, "little") + bytes(4)
    said = subprocess.run([host, method], input=hello, capture_output=True, check=True).stdout
    return said[16:].decode().split("\n")[1]


def machine():
    cpu = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    return {"cpu": cpu[1] if cpu else platform.machine(), "cores": os.cpu_count(), "kernel": platform.release(),
            "load_average": round(os.getloadavg()[0], 1)}


if __name__ == "__main__":
    main()
