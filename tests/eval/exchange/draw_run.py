"""Draws what `haptic_eval failures --export` wrote, or anybody in its place: a scene with the ways of hand and IHIP, and the
forces. Written from README.md alone; copy it and change it.

usage: draw_run.py FOLDER OUT.png [LOAD]      LOAD: which of the scene's loads, from 0 on; the first one
"""

import csv
import json
import sys
from pathlib import Path

import matplotlib
import numpy

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402
from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # noqa: E402

MOST_TRIANGLES = 4000  # of a mesh that is drawn


def read_ply(path):
    lines = path.read_text().split("\n")
    count = {line.split()[1]: int(line.split()[2]) for line in lines if line.startswith("element")}
    body = lines[lines.index("end_header") + 1:]
    vertices = numpy.array([line.split() for line in body[:count["vertex"]]], float).reshape(-1, 3)
    faces = [line.split() for line in body[count["vertex"]:count["vertex"] + count["face"]]]
    return vertices, numpy.array(faces, int).reshape(-1, 4)[:, 1:]


def read_csv(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def vectors(rows, name, unit):
    return numpy.array([[row[f"{name}_{axis}_{unit}"] for axis in "xyz"] for row in rows], float).reshape(-1, 3)


def turned(quaternion, points):
    w, u = quaternion[0], quaternion[1:]
    across = numpy.cross(u, points)
    return points + 2 * (w * across + numpy.cross(u, across))


class Run:
    """The rows of one load."""

    def __init__(self, folder, load):
        self.scene = json.loads((folder / "scene.json").read_text())
        if self.scene["format"] != "haptics scene 1":
            sys.exit(f"{folder}: \"format\": \"haptics scene 1\" is right")
        if not 0 <= load < len(self.scene["loads"]):
            sys.exit(f"{folder}: has loads 0 to {len(self.scene['loads']) - 1}")
        self.bodies = self.scene["loads"][load]["bodies"]
        motion = [row for row in read_csv(folder / "motion.csv") if int(row["load"]) == load]
        first, last = int(motion[0]["row"]), int(motion[-1]["row"])
        self.hip = {int(row["row"]): row for row in motion}
        self.forces = [row for row in read_csv(folder / "forces.csv") if first <= int(row["row"]) <= last]
        self.poses = {}  # of the load's last row
        for row in read_csv(folder / "poses.csv"):
            if first <= int(row["row"]) <= last:
                self.poses[int(row["body"])] = ([float(row[f"rotation_{k}"]) for k in "wxyz"], vectors([row], "position", "m")[0])
        self.meshes = [read_ply(folder / body["mesh"]) for body in self.bodies]

    def ticks(self):
        """Places of the hand, of the IHIP, and forces, a row for each tick; 1 where it touches."""
        hip = vectors([self.hip[int(row["row"])] for row in self.forces], "hip", "m")
        touching = numpy.array([int(row["touching"]) for row in self.forces], bool)
        return hip, vectors(self.forces, "ihip", "m"), vectors(self.forces, "force", "N"), touching


def draw_scene(axes, run, hip, ihip, force, touching):
    every = [hip]
    for i, (vertices, triangles) in enumerate(run.meshes):
        rotation, position = run.poses[i]
        placed = turned(numpy.array(rotation), vertices) + position
        every.append(placed)
        shown = placed[triangles[::max(1, len(triangles) // MOST_TRIANGLES)]]
        axes.add_collection3d(Poly3DCollection(shown * 1e3, facecolor="#8fb3d9", edgecolor="#4a6a8a", linewidth=0.2, alpha=0.25))
    axes.plot(*hip.T * 1e3, color="#d55e00", linewidth=1, label="hand")
    axes.plot(*ihip.T * 1e3, color="#000000", linewidth=1, label="IHIP")
    held = numpy.flatnonzero(touching)
    held = held[::max(1, len(held) // 40)]
    if len(held):
        longest = numpy.abs(force[held]).max() or 1
        size = 1e3 * numpy.ptp(numpy.concatenate(every), axis=0).max()
        axes.quiver(*ihip[held].T * 1e3, *force[held].T / longest * size / 8, color="#009e73", linewidth=0.8, label="force")
    low, high = numpy.min(numpy.concatenate(every), axis=0) * 1e3, numpy.max(numpy.concatenate(every), axis=0) * 1e3
    middle, half = (low + high) / 2, (high - low).max() / 2 or 1
    for set_limits, at in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), middle):
        set_limits(at - half, at + half)
    axes.set_xlabel("x, mm"), axes.set_ylabel("y, mm"), axes.set_zlabel("z, mm")
    axes.legend(loc="upper left", fontsize=8)


def draw_forces(axes, run, force, touching):
    seconds = run.scene["tick_s"] * numpy.arange(len(force))
    for k, colour in enumerate(("#0072b2", "#e69f00", "#cc79a7")):
        axes.plot(seconds, force[:, k], color=colour, linewidth=0.8, label="xyz"[k])
    axes.plot(seconds, numpy.linalg.norm(force, axis=1), color="#000000", linewidth=1, label="length")
    axes.fill_between(seconds, 0, 1, where=touching, transform=axes.get_xaxis_transform(), color="#009e73", alpha=0.1, linewidth=0)
    axes.set_xlabel("ticks, s; shaded: touching"), axes.set_ylabel("force on the hand, N")
    axes.legend(fontsize=8)


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__.split("\n\n")[1])
    folder = Path(sys.argv[1])
    run = Run(folder, int(sys.argv[3]) if len(sys.argv) == 4 else 0)
    hip, ihip, force, touching = run.ticks()
    figure = pyplot.figure(figsize=(13, 6))
    draw_scene(figure.add_subplot(1, 2, 1, projection="3d"), run, hip, ihip, force, touching)
    draw_forces(figure.add_subplot(1, 2, 2), run, force, touching)
    verdict = json.loads((folder / "verdict.json").read_text()) if (folder / "verdict.json").exists() else {}
    said = {True: ", passes", False: ", fails"}.get(verdict.get("pass"), "")
    figure.suptitle(f"{run.scene['method']} in {run.scene['scene']}, seed {run.scene['seed']}{said}: "
                    f"{len(force)} ticks, {touching.sum()} touching, up to {numpy.abs(force).max(initial=0):.3g} N")
    figure.savefig(sys.argv[2], dpi=100)
    print(f"{len(run.meshes)} bodies, {len(force)} ticks, {touching.sum()} touching, "
          f"{numpy.linalg.norm(force, axis=1).max(initial=0):.6g} N at most: {sys.argv[2]}")


if __name__ == "__main__":
    main()
