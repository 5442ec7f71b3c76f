#!/usr/bin/python3
"""Merges what server and viewer say of one run into summary.json and prints the key figures.

usage: merge_summaries.py SERVER.json VIEWER.json SUMMARY.json
"""
import json
import sys
from pathlib import Path

SERVER_KEYS = ("ticks", "missed_ticks", "rate_hz", "tick_ns", "wake_latency_ns", "contact_ticks", "max_force_N",
               "allocations_in_servo", "scene_revision", "scene_hash", "realtime")
VIEWER_KEYS = ("viewer_frames", "client_scene_hash", "telemetry_age_ms")


def read(path, program, keys):
    try:
        summary = json.loads(Path(path).read_text())
    except (OSError, ValueError) as error:
        sys.exit(f"no summary of {program}: {error}")
    missing = [key for key in keys if key not in summary]
    if missing:
        sys.exit(f"{path}: the summary of {program} lacks {', '.join(missing)}")
    return summary


def merge(server, viewer):
    """Both hashes were computed by their own process; they say something only about one and the same revision."""
    merged = {**viewer, **server}
    merged["client_scene_revision"] = viewer.get("scene_revision")
    merged["hashes_equal"] = (server["scene_hash"] == viewer["client_scene_hash"] and
                              server["scene_revision"] == viewer.get("scene_revision"))
    return merged


def key_figures(summary):
    ticks = max(summary["ticks"], 1)
    equal = "equal" if summary["hashes_equal"] else "NOT EQUAL"
    age = summary["telemetry_age_ms"]
    realtime = ", ".join(f"{name.replace('_', ' ')} {'yes' if held else 'no'}" for name, held in summary["realtime"].items())
    return [
        ("servo", f"{summary['rate_hz']:.0f} Hz, {summary['ticks']} ticks, {summary['missed_ticks']} missed"),
        ("tick", f"p50 {summary['tick_ns']['p50'] / 1000:.1f} us, p99 {summary['tick_ns']['p99'] / 1000:.1f} us"),
        ("wake-up", f"p50 {summary['wake_latency_ns']['p50'] / 1000:.0f} us, "
                    f"p99 {summary['wake_latency_ns']['p99'] / 1000:.0f} us"),
        ("real time", realtime),
        ("contact", f"{100 * summary['contact_ticks'] / ticks:.0f} % of ticks, at most {summary['max_force_N']:.2f} N"),
        ("viewer", f"{summary['viewer_frames']} frames, telemetry age p50 {age['p50']:.1f} ms, p99 {age['p99']:.1f} ms"),
        ("scene", f"revision {summary['scene_revision']}, hashes {equal}"),
        ("", f"server {summary['scene_hash']}"),
        ("", f"viewer {summary['client_scene_hash']}"),
    ]


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    summary = merge(read(sys.argv[1], "the server", SERVER_KEYS), read(sys.argv[2], "the viewer", VIEWER_KEYS))
    Path(sys.argv[3]).write_text(json.dumps(summary, indent=2) + "\n")
    for name, figures in key_figures(summary):
        print(f"  {name:<10} {figures}")
    if not summary["client_scene_hash"]:
        sys.exit("the viewer ended before it held the whole scene")
    if not summary["hashes_equal"]:
        sys.exit(f"server and viewer do not hold the same scene: revisions {summary['scene_revision']} and "
                 f"{summary['client_scene_revision']}")


if __name__ == "__main__":
    main()
