"""What haptic_eval advise makes of scenes: writes the advised scene of each and tries it on other strokes than it was advised by.

usage: advised_scenes.py HAPTIC_EVAL SCENE_OR_MESH... >advised_scenes.json

A mesh (OFF, PLY, ...) is felt by itself, 160 mm long and of 800 N/m.
"""
import json
import pathlib
import subprocess
import sys
import tempfile


def scene_of(mesh, folder):
    """A scene file of one mesh, and the options to read it with."""
    scene = pathlib.Path(folder, pathlib.Path(mesh).stem + ".scene")
    scene.write_text(f'operations {{ add {{ name: "{scene.stem}" mesh {{ file: "{pathlib.Path(mesh).name}" '
                     "largest_extent_m: 0.16 } material { stiffness_N_per_m: 800 } } }\n")
    return scene, ["--assets", str(pathlib.Path(mesh).parent)]


def rows_of(program, scene):
    """A row for each object: its mesh, what it takes in memory and in a tick, before and after, and the verdict."""
    with tempfile.TemporaryDirectory() as folder:
        options = []
        if pathlib.Path(scene).suffix != ".scene":
            scene, options = scene_of(scene, folder)
        done = subprocess.run([program, "advise", scene, *options, "--out", folder + "/out", "--apply", folder + "/advised"],
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
