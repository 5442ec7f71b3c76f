"""What haptic_eval advise makes of scenes: writes the advised scene of each and tries it on other strokes than it was advised by.

usage: advised_scenes.py HAPTIC_EVAL SCENE... >advised_scenes.json
"""
import json
import pathlib
import subprocess
import sys
import tempfile


def rows_of(program, scene):
    """A row for each object: its mesh, what it takes in memory and in a tick, before and after, and the verdict."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([program, "advise", scene, "--out", folder + "/out", "--apply", folder + "/advised"],
                              capture_output=True, text=True)
        if done.returncode not in (0, 1) or not pathlib.Path(folder, "out", "advise.json").exists():
            raise SystemExit(f"{scene}: {done.stderr}")
        records = json.loads(pathlib.Path(folder, "out", "advise.json").read_text())
    for verdict in (r for r in records if "verdict" in r):
        meshes = [r for r in records if r["scene"] == verdict["scene"] and "triangles" in r]
        features = [r for r in records if r["scene"] == verdict["scene"] and "feature" in r]
        row = {"scene": pathlib.Path(scene).stem, "object": verdict["scene"], "verdict": verdict["verdict"]}
        for after in (False, True) if meshes else ():
            (mesh,) = [r for r in meshes if r["advised" if after else "own_mesh"]]
            for key in ("triangles", "memory_MB", "hot_tick_p50_ns"):
                row[f"{key}_{'after' if after else 'before'}"] = mesh[key]
        row["checked_below_1_ratio"] = verdict.get("checked_below_1_ratio")
        row["not_judged"] = [f["feature"] for f in features if not f["judged"]]
        row["not_felt"] = [f["feature"] for f in features if f["judged"] and not f["felt"]]
        yield row


def main(program, *scenes):
    print(json.dumps([row for scene in scenes for row in rows_of(program, scene)], indent=2))


if __name__ == "__main__":
    main(*sys.argv[1:])
