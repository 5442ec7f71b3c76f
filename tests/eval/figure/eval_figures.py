"""Draws what haptic_eval, haptic_stress and contact_figures measured: eval_figures.py KIND STEM < JSON writes STEM.png, of curves
STEM.svg too. KIND is a function below, its argument what the program of that kind writes (drawFigure() in figure.h)."""
import csv
import json
import math
import sys
from pathlib import Path

try:
    import matplotlib
    import numpy
except ImportError as error:
    sys.exit(f"{Path(__file__).name}: {error}; install python3-matplotlib")
matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402
from matplotlib.patches import Rectangle  # noqa: E402
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter  # noqa: E402

DPI = 100
INK, SOFT, RULE, PAPER = "#21262e", "#616b78", "#dbdfe3", "#f8f9fa"
GOOD, BAD = "#1a8c54", "#c72929"
# Okabe and Ito's, which colour-blind people tell apart.
BLUE, VERMILION, GREEN, PINK, AMBER, SKY = "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"
ORANGE, RED, YELLOW, GREY = "#e67e00", "#cc3d33", "#f2c740", "#8c9199"
MANY = (BLUE, VERMILION, GREEN, PINK, AMBER, SKY, GREY, "#994fa3", "#664221", "#b0b01a", "#1a1a1a", "#cc1a40")
DISC, DIAMOND, CROSS, DASHED = "o", "D", "x", None  # dashed: of a formula, not measured
TITLE_px, TEXT_px, SMALL_px = 32, 20, 17


class Page:
    """Of so many pixels; places are from the upper left corner."""

    def __init__(self, width, height):
        self.size = numpy.array([width, height])
        self.figure = pyplot.figure(figsize=self.size / DPI, dpi=DPI, facecolor="white")

    def text(self, left, top, words, px=TEXT_px, colour=INK, bold=False, **style):
        """`top`: of the letters' foot. Returns where the words end."""
        written = self.figure.text(left / self.size[0], 1 - top / self.size[1], words, size=px * 72 / DPI, color=colour,
                                   weight="bold" if bold else "normal", **style)
        return written.get_window_extent().x1

    def head(self, left, top, title, caption, px=SMALL_px):
        """Returns where it ends."""
        self.text(left, top, title, TITLE_px, bold=True)
        for i, line in enumerate(caption):
            self.text(left, top + 34 + 27 * i, line, px, SOFT)
        return top + 20 + 27 * len(caption)

    def box(self, left, top, width, height, colour):
        self.figure.add_artist(Rectangle((left / self.size[0], 1 - (top + height) / self.size[1]), width / self.size[0],
                                         height / self.size[1], facecolor=colour, linewidth=0, zorder=-1))

    def disc(self, x, y, px, colour):
        self.figure.add_artist(matplotlib.lines.Line2D([x / self.size[0]], [1 - y / self.size[1]], marker="o", color=colour,
                                                       markersize=px * 72 / DPI, markeredgewidth=0))

    def axes(self, left, top, width, height):
        axes = self.figure.add_axes((left / self.size[0], 1 - (top + height) / self.size[1], width / self.size[0],
                                     height / self.size[1]), facecolor="none")
        axes.tick_params(colors=INK, labelsize=SMALL_px * 72 / DPI)
        axes.spines[["top", "right"]].set_visible(False)
        return axes

    def save(self, stem, *endings):
        for ending in endings:
            self.figure.savefig(f"{stem}.{ending}", metadata={"Date": None} if ending == "svg" else None)


# Panels that are logarithmic in both, a legend beside them.

def style(name, note, colour, marker=DISC, strong=False):
    return {"name": name, "note": note, "colour": colour, "marker": marker, "strong": strong}


def decades(values, least=-99, most=99):
    """Of the smallest powers of ten that hold the values; at least one. What is beyond `least` and `most` lies on the rim."""
    logs = [math.log10(value) for value in values if value > 0] or [0]
    low, high = max(least, math.floor(min(logs))), min(most, math.ceil(max(logs)))
    return low, max(high, low + 1)


def decade_text(value, _=None):
    """0.01, 1, 100, 10 k, 1 M."""
    decade = round(math.log10(value))
    return f"{value:.{-decade}f}" if decade < 0 else f"{10 ** (decade % 3)}" + ("", " k", " M", " G")[decade // 3]


def write_where_free(axes, taken, candidates, **look):
    """The first of (x, y, words, offset in px, alignments) that is within the panel and covers nothing; none where all do."""
    for x, y, words, offset_px, alignments in candidates:
        written = axes.annotate(words, (x, y), numpy.array(offset_px) * 72 / DPI, textcoords="offset points",
                                size=SMALL_px * 72 / DPI, **look, **alignments)
        box = written.get_window_extent()
        inside = axes.bbox.x0 <= box.x0 and box.x1 <= axes.bbox.x1 and axes.bbox.y0 <= box.y0
        if inside and not any(box.padded(2).contains(*point) for point in taken):
            taken += [(px, py) for px in numpy.linspace(box.x0, box.x1, 9) for py in (box.y0, (box.y0 + box.y1) / 2, box.y1)]
            return
        written.remove()


def draw_panel(axes, panel, styles):
    taken = []  # pixels
    for set_scale, set_limits, axis, (low, high) in ((axes.set_xscale, axes.set_xlim, axes.xaxis, panel["x"]),
                                                    (axes.set_yscale, axes.set_ylim, axes.yaxis, panel["y"])):
        set_scale("log")
        set_limits(10.0 ** low, 10.0 ** high)
        axis.set_major_locator(LogLocator(numticks=high - low + 2))
        axis.set_major_formatter(FuncFormatter(decade_text))
        axis.set_minor_locator(LogLocator(subs=range(2, 10), numticks=high - low + 2))
        axis.set_minor_formatter(NullFormatter())
    axes.grid(which="major", color="#dee2e6", linewidth=1)
    axes.grid(which="minor", color="#f1f2f4", linewidth=0.7)
    axes.tick_params(which="both", length=0, pad=7)
    axes.set_axisbelow(True)
    axes.set_title(panel["title"], loc="left", size=TEXT_px * 72 / DPI, weight="bold", color=INK)
    axes.set_xlabel(panel["x_label"], size=TEXT_px * 72 / DPI, color=INK)
    axes.set_ylabel(panel["y_label"], size=TEXT_px * 72 / DPI, color=INK)
    labels = []
    for curve in panel["curves"]:
        look, points = styles[curve["style"]], curve["points"]
        if not points:
            continue
        places = numpy.array([[numpy.clip(p[0], *axes.get_xlim()), numpy.clip(p[1], *axes.get_ylim())] for p in points])
        above = 4 if look["strong"] else 3
        axes.plot(*places.T, color=look["colour"], linewidth=3.5 if look["strong"] else 1.8, zorder=above, clip_on=False,
                  linestyle="--" if look["marker"] is DASHED else "-")
        for i, place in enumerate(places):
            marker = curve.get("markers", [look["marker"]] * len(points))[i]
            if marker is not DASHED:
                axes.plot(*place, marker, color=look["colour"], markersize=13 if look["strong"] else 8.5, clip_on=False,
                          zorder=above, markeredgewidth=2.2 if marker == CROSS else 0)
        pixels = axes.transData.transform(places)
        for a, b in zip(pixels, pixels[1:] if len(pixels) > 1 else pixels):
            taken += list(numpy.linspace(a, b, int(math.dist(a, b) / 3) + 2))
        labels += [(*place, text, look) for place, text in zip(places, curve.get("labels", ()))]
    for x, colour, words in panel.get("marks", ()):
        axes.axvline(x, color=colour, linewidth=1.8, linestyle="--")
        taken += [axes.transData.transform((x, 10.0 ** y)) for y in numpy.linspace(*panel["y"], 120)]
        if words:
            write_where_free(axes, taken, [(x, 10.0 ** panel["y"][1], words, (side * 14, -14), {"ha": "center", "va": "top"})
                                           for side in (1, -1)], color=colour, rotation=90)
    if "threshold" in panel:
        y, words = panel["threshold"]
        axes.axhline(y, color="#333842", linewidth=1.8, linestyle="--")
        write_where_free(axes, taken, [(10.0 ** panel["x"][1], y, words, (-6, -8), {"ha": "right", "va": "top"})], color="#333842")
    for x, y, words, look in reversed(labels):
        write_where_free(axes, taken, [(x, y, words, (-16, 0), {"ha": "right", "va": "center"}),
                                       (x, y, words, (16, 0), {"ha": "left", "va": "center"})],
                         color=look["colour"], weight="bold" if look["strong"] else "normal")


def log_panels(stem, title, caption, columns, panels, legend, styles, notes=()):
    cell, below = (548, 504), 86 + 27 * len(caption)
    rows = -(-len(panels) // columns)
    page = Page(30 + columns * cell[0] + 520, below + max(rows * cell[1], 114 + 72 * len(styles) + 28 * len(notes)))
    page.head(60, 56, title, caption, TEXT_px)
    for i, panel in enumerate(panels):
        draw_panel(page.axes(148 + i % columns * cell[0], below + i // columns * cell[1] + 30, 400, 360), panel, styles)
    left, y = 60 + columns * cell[0], below + 40
    page.text(left, y, legend, bold=True)
    y += 50
    for look in styles:
        ends = numpy.array([left, left + 52]) / page.size[0]
        for xs, marker in ((ends, None), (ends.mean(keepdims=True), look["marker"])):
            page.figure.add_artist(matplotlib.lines.Line2D(
                xs, [1 - (y - 7) / page.size[1]] * len(xs), color=look["colour"], linewidth=3.5 if look["strong"] else 1.8,
                linestyle="--" if look["marker"] is DASHED else "-", marker=marker or "", markersize=13 if look["strong"] else 8.5,
                markeredgewidth=2.2 if marker == CROSS else 0))
        page.text(left + 66, y, look["name"], bold=look["strong"])
        page.text(left + 66, y + 26, look["note"], SMALL_px, SOFT)
        y += 72
    for note in notes:
        page.text(left, y, note, SMALL_px, SOFT)
        y += 28
    page.save(stem, "png", "svg")


def panel(title, x_label, y_label, x, y, curves, **more):
    return {"title": title, "x_label": x_label, "y_label": y_label, "x": x, "y": y, "curves": curves, **more}


def chart(data, stem):
    # What is not named is in the table only: a variant that would be drawn over another.
    looks = (("ours", "this runtime", VERMILION), ("ours_shaded", "this runtime, force shading", "#99121f"),
             ("ours_without_substeps", "this runtime, no substeps", "#4d290f"),
             ("ours_float", "this runtime, search in float", AMBER), ("god_object", "god-object", BLUE),
             ("finite_proxy_1mm", "finite proxy, 1 mm", SKY), ("global_closest", "closest point, penalty", GREEN),
             ("intermediate_plane_100Hz", "tangent plane, 100 Hz", PINK),
             ("intermediate_plane_30Hz", "tangent plane, 30 Hz", "#854d80"),
             ("pseudocode_open", "paper as printed, open", "#737373"), ("pseudocode_closed", "paper as printed, closed", "#000000"))
    looks = tuple(look for look in looks if look[0] in data["notes"])
    looks += tuple((method, f"{method}, from outside", MANY[-1 - i % len(MANY)]) for i, method in enumerate(data["from_outside"]))
    with open(data["table"]) as table:
        rows = [{key: value if "scenes" in key or key == "method" else float(value) for key, value in row.items()}
                for row in csv.DictReader(table)]
    rows.sort(key=lambda row: row["triangles"])
    worst = max(row["worst_tick_instructions"] for row in rows)
    worst_us = worst / data["instructions_per_us"]
    columns = (("Caches hot", "hot_tick_p50_ns", "contact tick, ns (median)", worst_us * 1e3, f"worst tick, {worst_us:.0f} us"),
               ("Caches cold", "cold_tick_p50_ns", "contact tick, ns (median)", 0, ""),
               ("Instructions", "instructions_per_tick", "instructions per tick", worst, f"worst tick, {worst / 1e6:.2f} M"))
    panels = []
    for y, y_label, limits, shown in (("epsilon_p99_ratio", "force error, 1: just noticeable", (-2, 3), [0.5]),
                                      ("force_above_100Hz_rms_N", "false force above 100 Hz, N rms", (-3, 1), [])):
        for title, x, x_label, mark, words in columns:
            curves = []
            for i, (method, *_) in enumerate(looks):
                own = [row for row in rows if row["method"] == method and row[x] > 0]
                curves.append({"style": i, "points": [(row[x], row[y]) for row in own], "markers": [
                    CROSS if row["failed_scenes"].strip() else
                    DISC if row["limit_cycle_um"] <= row["limit_cycle_allowed_um"] else DIAMOND for row in own]})
                if method == "ours" and not panels:
                    curves[-1]["labels"] = [f"{n:.0f}" if n < 1000 else f"{n / 1e3:.0f} k" if n < 1e6 else f"{n / 1e6:.0f} M"
                                           for n in (row["triangles"] for row in own)]
            panels.append(panel(title, x_label, y_label, decades([row[x] for row in rows] + [mark], 0, 7),
                                decades([row[y] for row in rows] + shown, *limits), curves,
                                marks=[(mark, VERMILION, words)] if mark else []))
            if shown:
                panels[-1]["threshold"] = (1, "too small to notice")
    log_panels(
        stem, "Speed and accuracy of point-based haptic rendering",
        ["Sphere, torus, cylinder, cube, L-shape and sine grating, stroked 2 mm deep at 0.1 m/s, 1 kHz, k = 1000 N/m. "
         "One point for each mesh resolution, numbers: triangles."], 3, panels, "Method",
        [style(name, data["notes"][method], colour, CROSS if data["notes"][method].startswith("fails") else DISC, method == "ours")
         for method, name, colour in looks],
        ["Disc: passes every scripted failure scene.", "Diamond: so it does, but rings: under 1 N",
         "the HIP moves over 2 encoder steps.", "Cross: fails some; the scenes are those of", "haptic_eval failures.",
         "Upright: this runtime's worst tick of what", f"hunts found, at {data['instructions_per_us']:.0f} instructions a us.",
         "No substeps, search in float: one over the", "other, by the guarded path in every tick.",
         "Dashed: what a hand with vision notices,", "7 % of a force (Pang et al. 1991) or 0.05 N,",
         "18.4 deg (Barbagli et al. 2006)."])


def tool_points(data, stem):
    """Of what haptic_bench wrote; STEM.csv too."""
    with open(data["bench"]) as file:
        try:
            runs = json.load(file)["benchmarks"]
        except (ValueError, KeyError, TypeError):
            sys.exit(f"{data['bench']}: no benchmarks")
    rows = []
    for run in runs:
        name, *words = run["name"].split("/")
        if name in ("tool_tick", "field_tick") and len(words) >= 4:
            numbers = [int(word.split("_")[0]) for word in words[2:5 if name == "field_tick" else 4]]
            rows.append({"method": name, "motion": words[1], **dict(zip(("points", "triangles", "cells"), numbers + [0])),
                         "tick_p50_us": run["p50_ns"] / 1e3, "deepest_um": run["deepest_um"], "touching": run["touching"],
                         "build_s": run.get("build_s", 0.0), "field_MB": run.get("field_MB", 0.0)})
    if not rows:
        sys.exit(f"{data['bench']}: no tool_tick and no field_tick")
    with open(f"{stem}.csv", "w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(rows[0])
        table.writerows([*list(row.values())[:5], f"{row['tick_p50_us']:.3f}", f"{row['deepest_um']:.1f}", f"{row['touching']:.1f}",
                         f"{row['build_s']:.2f}", f"{row['field_MB']:.1f}"] for row in rows)
    looks = (("tool_tick", 65536, 0, "this runtime, 65,536 triangles", AMBER, DISC),
             ("tool_tick", 1048576, 0, "this runtime, 1,048,576 triangles", VERMILION, DISC),
             ("field_tick", 65536, 128, "distance field, 128 cells", SKY, CROSS),
             ("field_tick", 65536, 256, "distance field, 256 cells", BLUE, CROSS))
    of = {look: [row for row in rows if (row["method"], row["triangles"], row["cells"]) == look[:3]] for look in looks}
    styles = []
    for look, own in of.items():
        note = "passes nothing"
        if look[2]:
            note = "sinks in by up to {:.1f} mm; {:.0f} s, {:.0f} MB".format(
                *(max((row[key] for row in own), default=0) / per for key, per in
                  (("deepest_um", 1e3), ("build_s", 1), ("field_MB", 1))))
        styles.append(style(look[3], note, look[4], look[5], look[1] > 1e6))
    # Medians of CHAI3D's finger proxy for one point on a sphere of 1M triangles: by default, and in its most accurate mode.
    of_one_us = (1.382, 3.436)
    styles += [style("CHAI3D, one point, times N", "no torque of a shape", GREEN, DASHED),
               style("the same, most accurate mode", "", "#737373", DASHED)]
    panels = [panel(motion, "points of the tool", "tick, us (median)", (0, 4), (-1, 4),
                    [{"style": i, "points": [(row["points"], row["tick_p50_us"]) for row in own if row["motion"] == motion]}
                     for i, own in enumerate(of.values())] +
                    [{"style": len(of) + i, "points": [(1, us), (4000, 4000 * us)]} for i, us in enumerate(of_one_us)],
                    threshold=(1000, "1 kHz")) for motion in ("blunt", "flat")]
    log_panels(stem, "What a tool's points cost",
               ["An ellipsoid pressed into a torus and turned at 1 kHz: with its end (blunt), or lying on the ring (flat).",
                "Crosses: a point shell of springs over a distance field that is built beforehand (McNeely et al. 1999, "
                "Barbic & James 2008).",
                "Cells are along the longest side, seconds and MB the field's; it passes what is thinner than a cell.",
                "Dashed: no tool, but the time of one point on 1M triangles as often as there are points."],
               2, panels, "Method", styles)


def stability(data, stem):
    records = [record for record in data["records"] if "K_crit_N_per_m" in record]
    methods, stiffness = data["methods"], (1, 6)
    styles = [style(method["title"], method["note"], colour, strong=method["name"] == "ours")
              for method, colour in zip(methods, (GREY, RED, ORANGE, GREEN, BLUE))]
    styles += [style("passive", "b > K T / 2 + |B| (Colgate & Schenkel)", "#80479e", DASHED),
               style("passive with friction", "2 b / T, 2 f_c / step (Abbott, Okamura)", "#db70a8", DASHED),
               style("stable with delay", "K (T / 2 + t_d) < b + B (Gil et al.)", "#8c5729", DASHED),
               style("stable", "eigenvalues of the sampled system", INK, DASHED)]

    def curves(scene, device, over, least, wanted):
        return [{"style": i, "points": sorted(
            (max(least, r[over]), r["K_crit_N_per_m"]) for r in records
            if (r["scene"], r["device"], r["method"]) == (scene, device["name"], method["name"]) and wanted(r))}
            for i, method in enumerate(methods)]

    panels = []
    for device in data["devices"]:
        if device["name"] == "touch":  # the omni's mechanics
            continue
        formulas = [{"style": len(methods) + i, "points": points} for i, points in enumerate(device["formulas"])]
        panels.append(panel(device["title"], "rendered damping B, N s/m", "stiffness, N/m", (-1, 2), stiffness,
                            formulas + curves("z_width", device, "B_Ns_per_m", 0.1, lambda r: True),
                            threshold=(device["most_N_per_m"], "the maker's limit")))
    serial = next(device for device in data["devices"] if device["name"] == "desktop")
    for over, label, x, least, wanted in (
            ("delay_ms", "delay, ms, at 1 kHz (none: left rim)", (-1, 1), 0.1, lambda r: r["rate_Hz"] == 1000),
            ("rate_Hz", "servo rate, Hz, a period of delay", (3, 4), 1, lambda r: abs(r["delay_ms"] - 1e3 / r["rate_Hz"]) < 1e-9)):
        panels.append(panel(serial["title"], label, "stiffness, N/m", x, stiffness,
                            curves("wall", serial, over, least, lambda r: r["hand"] == "none" and wanted(r)),
                            threshold=(serial["most_N_per_m"], "the maker's limit")))
    panels.append(panel("At the maker's K", "b / (K T)", "f_c / (K step)", (-3, 1), (-2, 2),
                        [{"style": 0, "points": [device["region"]], "labels": [device["name"]]} for device in data["devices"]],
                        threshold=(0.5, "rings below"), marks=[(0.5, INK, "")]))
    log_panels(stem, "How stiff a wall each device bears",
               ["Largest stiffness up to which a device in nobody's hand comes to rest after pushes of 0.5 and 1 N and taps at 0.02",
                "and 0.15 m/s, against the damping rendered with it. 1 kHz, one period of delay. No damping: left rim."],
               3, panels, "Method", styles,
               ["Dashed: the literature's limits for a spring", "and a damper, without encoder; what lies",
                "below the first two makes no energy.", "Last panel: the regions of Diolaiti et al.",
                "Right of the line passive, left of it only", "locally stable; below the other, it rings."])


def teleoperation(data, stem):
    page = Page(1640, 1010)
    page.head(60, 50, "A robot that a hand leads over a line", [
        "Above: a hand (dashed) presses 10, then 15 mm into a wall of 10 kN/m that a robot touches for it, 200 ms away each way, with 10 ms of",
        "jitter and 5 % loss. Below: the same by delay; nominal hand, omega.3 at both ends, coupling 600 N/m."])
    wide, colours = 320, dict(zip((name for name, _ in data["methods"]), (BLUE, GREEN, AMBER, VERMILION)))
    runs = [run for run in data["runs"] if run["hand"] == "nominal"]
    shown = [run for run in runs if (run["scene"], run["delay_ms"]) == ("hard", 200)]
    for i, run in enumerate(shown):
        time, meant, master, follower, *_ = numpy.array(run["samples"]).T
        axes = small_plot(page, 60 + 395 * i, 190, wide, 290, f"{run['title']}, mm deep", "s",
                          [("", SOFT, [(0, 0)], 1), ("hand", BLUE, numpy.c_[time, master], 2.5), ("robot", VERMILION, numpy.c_[time, follower], 2.5)])
        axes.plot(time, meant, color=SOFT, linewidth=1, linestyle="--")
        axes.set_ylim(-35, 25)
    delays = sorted({run["delay_ms"] for run in runs})
    for i, (title, scene, value) in enumerate((
            ("stiffness felt in the wall, N/m", "hard", lambda run: run["felt_N_per_m"]),
            ("stiffness felt in 200 N/m, N/m", "soft", lambda run: run["felt_N_per_m"]),
            ("energy made, mJ, 20 and more at the rim", "hard", lambda run: min(20, max(0, -1e-3 * run["least_energy_uJ"]))),
            ("packets, % of a thousand a second each way", "hard", lambda run: run["packets_percent"]))):
        curves = [("", colours[method], [(run["delay_ms"], value(run)) for run in runs if (run["method"], run["scene"]) == (method, scene)], 3)
                  for method in colours]
        axes = small_plot(page, 60 + 395 * i, 600, wide, 270, title, "delay each way, ms", curves, from_zero=True)
        axes.set_xticks(delays)
        for line in axes.lines:
            line.set_marker("o")
    left = 60
    for name, title in data["methods"]:
        page.disc(left + 6, 966, 12, colours[name])
        left = page.text(left + 20, 972, title, SMALL_px) + 40
    page.save(stem, "png", "svg")


def worst(data, stem):
    tails = [tail for tail in data["tails"] if tail["survival"]]
    panels = [panel(title, "tick, us", "part of the ticks that takes longer", (-2, 5), (-6, 0),
                    [{"style": i, "points": tail["survival"]} for i, tail in enumerate(tails) if (tail["method"] == "ours") == ours])
              for title, ours in (("ours, by scene", True), ("baselines, in the worst of ours", False))]
    log_panels(stem, "How long ticks take where a hunter looks for the slowest",
               [f"A tick of ours may take the instructions of {data['limit_us']:.0f} us.",
                "Times of this machine, with what else it did meanwhile."], 2, panels, "Scenes, methods",
               [style(tail["name"], tail["method"], MANY[i % len(MANY)], DISC if tail["method"] == "ours" else CROSS)
                for i, tail in enumerate(tails)])


def worst_import(data, stem):
    files, limit_s, per = data["files"], data["limit_s"], 1e5
    x, y = (decades([point[axis] for file in files for point in file["points"]]) for axis in (0, 1))
    half = (len(files) + 1) // 2
    ends = [(10.0 ** decade, limit_s * 10.0 ** decade / per) for decade in x]
    panels = [panel("worst of each kind", "triangles", "import, s", x, y,
                    [{"style": i, "points": files[i]["points"]} for i in range(first, min(first + half, len(files)))] +
                    [{"style": len(files), "points": ends}]) for first in range(0, len(files), half)]
    log_panels(stem, "How long imports take where a hunter looks for the slowest",
               [f"100,000 triangles may take {limit_s:.3g} s: dashed.",
                "Time of the processor on this machine, with what else it did meanwhile."], 2, panels, "Files",
               [style(file["name"], f"grows with {file['exponent']:.2f}", MANY[i % half % 10], DISC if i < half else CROSS)
                for i, file in enumerate(files)] + [style("limit", "grows with 1", "#1a1a1a", DASHED)])


def advise(data, stem):
    """A candidate: triangles, error, time, memory. Its own mesh has no error against itself: it is left out."""
    objects, panels = data["objects"], []
    for column, title, label, least, shown in ((1, "Force error", "force error, 1: just noticeable", -3, 0.5),
                                               (2, "Time, caches hot", "contact tick, ns (median)", 0, 10),
                                               (3, "Memory", "server's database, MB", -3, 0.1)):
        points = [[(c[0], c[column]) for c in each["candidates"] if c[column] > 0] for each in objects]
        every = [point for own in points for point in own]
        panels.append(panel(title, "triangles", label, decades([x for x, _ in every]),
                            decades([y for _, y in every] + [shown], least),
                            [{"style": i, "points": own} for i, own in enumerate(points)]))
    panels[0]["threshold"] = (1, "too small to notice")
    panels.append(panel("Rate, with its own damping", "stiffness, N/m", "lowest steady rate, Hz",
                        decades([k for each in objects for k, _ in each["rates"]]), decades(data["rates_Hz"]),
                        [{"style": i, "points": [(k, rate) for k, rate in each["rates"] if rate]} for i, each in enumerate(objects)]))
    colours = (VERMILION, BLUE, GREEN, PINK, SKY, AMBER, "#000000")
    log_panels(stem, f"What {data['scene']} needs",
               ["Decimated copies of each object against its own mesh, stroked with 1 N at 0.1 m/s, on the production contact core."],
               2, panels, "Object", [style(each["name"], each["note"], colours[i % len(colours)]) for i, each in enumerate(objects)],
               ["Dashed: what a hand just notices.", *data["notes"]])


# Sheets of cards and small plots.

def small_plot(page, left, top, width, height, title, x_label, curves, from_zero=False):
    """Linear in both. A curve: name, colour, points, width. Names stand above, on the right."""
    axes = page.axes(left, top, width, height)
    for _, colour, points, wide in curves:
        axes.plot(*numpy.array(points).T, color=colour, linewidth=0.72 * wide)
    axes.margins(x=0, y=0.06)
    if from_zero:
        axes.set_ylim(bottom=0)
    axes.spines["left"].set_visible(False)
    axes.spines["bottom"].set_color(SOFT)
    axes.grid(axis="y", color=RULE, linewidth=0.7)
    axes.tick_params(axis="y", length=0)
    axes.tick_params(colors=SOFT, labelsize=12 * 72 / DPI)
    axes.xaxis.set_major_locator(MaxNLocator(4, steps=(1, 2, 5, 10)))
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=(1, 2, 5, 10)))
    page.text(left, top - 6, title, 13)
    page.text(left + width / 2, top + height + 34, x_label, 12, SOFT, ha="center")
    right = left + width
    for name, colour, *_ in reversed(curves):
        if name:
            page.text(right, top - 6, name, 13, colour, ha="right")
            right -= 8 * len(name) + 10
    return axes


def relief(heights):
    """Light from the upper left, the colour by height. Rows from the lowest y on, over 16 mm."""
    spread = numpy.ptp(heights)
    slope_y, slope_x = numpy.gradient(heights * (0.8e-3 / spread), 0.016 / len(heights))
    light = numpy.array((-0.55, 0.6, 1.0)) / math.hypot(-0.55, 0.6, 1.0)
    lit = numpy.maximum(0, (-slope_x * light[0] - slope_y * light[1] + light[2]) / numpy.sqrt(slope_x ** 2 + slope_y ** 2 + 1))
    share = ((heights - heights.min()) / spread)[..., None]
    ground = (1 - share) * (0.16, 0.30, 0.48) + share * (0.98, 0.93, 0.82)
    shades = 24  # of each colour: a small file
    return numpy.round(numpy.clip(ground * (0.25 + 0.95 * lit[..., None]), 0, 1) * shades) / shades


def texture_card(page, card, left, top, data):
    record, wide, tall = card["record"], 916, 226
    page.box(left, top, wide, tall, PAPER)
    page.disc(left + 20, top + 21, 14, GOOD if record["pass"] else BAD)
    page.text(left + 36, top + 28, card["title"], 19, bold=True)
    picture = page.axes(left + 14, top + 46, 152, 152)
    picture.imshow(relief(numpy.array(card["heights"])), origin="lower", interpolation="nearest")
    picture.axis("off")
    page.text(left + 90, top + 218, "16 mm", 13, SOFT, ha="center")
    small_plot(page, left + 212, top + 64, 192, 120, "force, N", "mm along the stroke",
               [("into", BLUE, card["into"], 2), ("along", ORANGE, card["along"], 1.6)])
    small_plot(page, left + 454, top + 64, 192, 120, "height, um", "waves per mm",
               [("reference", YELLOW, card["reference"], 5), ("felt", BLUE, card["felt"], 1.6)], True)

    def rests(method):
        return sum(r["scene"] == "rest_" + card["name"] and r["hand"] == "light" and r["method"] == method and
                   r["rate_Hz"] == 1000 and r["steady"] for r in data["resting"])

    verdict = [f"gradient within {record['gradient_error_ratio']:.0e}", f"C1: jumps below {record['gradient_jump_ratio']:.0e}",
               f"wavelength felt {record['wavelength_of_force_mm']:.3f} mm, set {record['wavelength_set_mm']:.0f}"
               if "wavelength_set_mm" in record else f"spectrum within {record['force_spectrum_difference_ratio']:.0e}",
               f"loop {record['loop_up_work_mJ']:.4f} mJ, derived {record['loop_up_derived_mJ']:.4f}",
               f"side {record['lateral_stiffness_max_N_per_m']:.0f} N/m, derived "
               f"{record['lateral_stiffness_derived_max_N_per_m']:.0f}",
               f"buzz at 1 kHz {1e3 * record['false_force_above_100Hz_at_1kHz_rms_N']:.1f} mN rms",
               f"rests on {rests('ours')} of {len(data['devices'])} devices;", f"by bump mapping on {rests('bump_mapping')}"]
    for i, words in enumerate(verdict):
        page.text(left + 664, top + 52 + 20 * i, words, 13)


def rest_grids(page, top, data):
    keys = ((GREEN, "rests by every method"), (YELLOW, "rings by bump mapping"),
            (ORANGE, "rings by Eq. (4) where K is not clamped"), (RED, "rings"))
    page.text(36, top + 30, "A grating under a device and the light hand at 1 kHz: does it rest?", 20, bold=True)
    left = 36
    for colour, meaning in keys:
        page.box(left, top + 46, 16, 16, colour)
        left = page.text(left + 24, top + 60, meaning, 15) + 24
    waves, heights, side, foot = data["wavelengths_mm"], data["heights_mm"], 34, top + 282
    steady = {(r["device"], r["height_mm"], r["wavelength_mm"], r["method"]) for r in data["map"] if r["hand"] == "light" and r["steady"]}
    for j, height in enumerate(heights):
        page.text(114, foot - side * j - 12, f"{height:g}", 13, SOFT, ha="right")
    page.text(50, foot - side * len(heights) / 2, "height, mm", 13, SOFT, ha="center", va="center", rotation=90)
    for g, device in enumerate(data["devices"]):
        left = 124 + (1850 - 88) / len(data["devices"]) * g
        page.text(left + side * len(waves) / 2, foot - side * len(heights) - 8, device["title"], 15, ha="center")
        for i, wave in enumerate(waves):
            for j, height in enumerate(heights):
                rests = [(device["name"], height, wave, m) in steady for m in ("bump_mapping", "ours_without_gain_clamp", "ours")]
                colour = RED if not rests[2] else ORANGE if not rests[1] else YELLOW if not rests[0] else GREEN
                page.box(left + side * i + 1, foot - side * (j + 1) + 1, side - 2, side - 2, colour)
            page.text(left + side * (i + 0.5), foot + 18, f"{wave:g}", 13, SOFT, ha="center")
        page.text(left + side * len(waves) / 2, foot + 38, "wavelength, mm", 13, SOFT, ha="center")


def textures(data, stem):
    worst_of = {key: max(r[key] for r in data["wrapped"]) for key in ("gradient_error_ratio", "gradient_jump_ratio")}
    rows = (len(data["cards"]) + 1) // 2
    page = Page(1922, 149 + 244 * rows + 610)
    page.head(36, 56, "Textures, friction and force shading as they are felt",
              ["Ho, Basdogan & Srinivasan (1999), section 4, by the production step. Relief 0.5 mm on a board of 500 N/m, stroked "
               "0.8 mm deep, Eq. (4) with K = 1.5; green disc: within every limit.",
               "Loop: work that a press in the valley, slide to the crest and lift give the hand. Side: largest lateral "
               "stiffness. Buzz: false force above 100 Hz, positions rounded to 30 um, 50 mm/s. Rests: light hand, 1 kHz.",
               "The last four wrapped round cube, cylinder and sphere, seams, poles and edges included: gradient within "
               f"{worst_of['gradient_error_ratio']:.0e}, jumps below {worst_of['gradient_jump_ratio']:.0e}."], 15)
    for i, card in enumerate(data["cards"]):
        texture_card(page, card, 36 + i % 2 * 934, 160 + i // 2 * 244, data)
    top = 149 + 244 * rows
    rest_grids(page, top, data)
    page.text(36, top + 370, "Friction and force shading", 20, bold=True)
    traces = data["traces"]
    for i, (title, curves, from_zero) in enumerate((
            ("pull over pressing force: to and fro, 0.6 / 0.4", [("", BLUE, traces["to_and_fro"], 2)], False),
            ("periodic friction, 4 mm", [("", BLUE, traces["periodic"], 2)], True),
            ("sandpaper, two grades", [("fine", ORANGE, traces["fine"], 1.4), ("coarse", BLUE, traces["coarse"], 2)], True),
            ("turn of the force on a sphere, deg",
             [("1,728 flat", "#9ea6b0", traces["unshaded"], 1.4), ("shaded", BLUE, traces["shaded"], 2)], False))):
        small_plot(page, 82 + 462 * i, top + 410, 400, 140, title, "mm", curves, from_zero)
    page.save(stem, "png")


def combinations(data, stem):
    features, wide, tall, gap = data["features"], 246, 162, 8
    page = Page(72 + len(features) * (wide + gap) - gap, 178 + len(features) * (tall + gap) + 36)
    top = page.head(36, 54, "Surface features, two at a time", data["caption"], 15) + 36
    left = 36
    for colour, height, meaning in ((YELLOW, 6, "reference"), (BLUE, 2.5, "felt"), (GOOD, 10, "within its limit"), (BAD, 10, "beyond it")):
        page.box(left, top - 5 - height / 2, 26, height, colour)
        left = page.text(left + 34, top, meaning, 15) + 26
    top += 24

    def card(row, column, title, colour=PAPER):
        at = 36 + column * (wide + gap), top + row * (tall + gap)
        page.box(*at, wide, tall, colour)
        return *at, page.text(at[0] + 12, at[1] + 22, title, 12, bold=True)

    for i, (title, note) in enumerate(features):
        x, y, _ = card(i, i, "", "#294d7a")
        page.text(x + wide / 2, y + tall / 2 - 4, title, 19, "white", bold=True, ha="center")
        page.text(x + wide / 2, y + tall / 2 + 22, note, 12, "#ccdbed", ha="center")
    for pair in data["pairs"]:
        x, y, end = card(pair["row"], pair["column"], pair["title"])
        page.text(end + 8, y + 22, pair["plotted"], 12, SOFT)
        page.disc(x + wide - 14, y + 16, 12, GOOD if all(bar[1] <= 1 for bar in pair["bars"]) else BAD)
        if pair["right"]:
            axes = small_plot(page, x + 46, y + 34, wide - 60, tall - 60, "", "",
                              [("", YELLOW, pair["right"], 5), ("", BLUE, pair["felt"], 1.6)])
            low, high = axes.get_ylim()  # a curve that hardly changes is shown as level, not as its rounding
            room = max(0, 0.1 * max(abs(low), abs(high)) - (high - low)) / 2
            axes.set_ylim(low - room, high + room + 1e-12)
            axes.set_xticks([0, pair["right"][-1][0]], ["0", f"{pair['right'][-1][0]:.3g} s"])
            axes.get_xticklabels()[1].set_ha("right")
        x, y, _ = card(pair["column"], pair["row"], pair["title"])
        for i, (name, share, value) in enumerate(pair["bars"]):
            foot, ink = y + 44 + 17.5 * i, INK if share <= 1 else BAD
            page.text(x + 12, foot, name, 12, ink)
            page.box(x + 146, foot - 10, 52, 8, RULE)
            page.box(x + 146, foot - 10, 52 * min(1, max(share, 0.015)), 8, GOOD if share <= 1 else BAD)
            page.box(x + 197.3, foot - 13, 1.4, 14, INK)
            page.text(x + wide - 8, foot, value, 12, ink, ha="right")
    page.save(stem, "png")


# Two panels beside one another: without a correction, and with it.

HIP, IHIP, WRONG, SPRING, SLOW, EDGE = VERMILION, BLUE, "#cc0d26", "#9ea3ab", GREEN, "#b8bfc9"
PANEL_px = (440, 330)


def number_text(value):
    return f"{value:.0f}" if value >= 1000 else f"{value:.3g}"


def length_text(metres):
    return next(number_text(metres / unit) + name for unit, name in ((1e-3, " mm"), (1e-6, " um"), (1e-9, " nm"))
                if metres >= unit or unit == 1e-9)


def scale_bar(axes, px_per_m):
    length = 10.0 ** math.floor(math.log10(PANEL_px[0] / px_per_m / 4))
    length *= next((more for more in (5, 2) if more * length * px_per_m <= PANEL_px[0] / 3), 1)
    right = PANEL_px[0] - 12
    axes.plot([right - length * px_per_m, right], [12, 12], color=INK, linewidth=1.5)
    axes.text(right - length * px_per_m / 2, 17, length_text(length), size=9, color=INK, ha="center")


def section(axes, data, panel):
    """Of the ticks: HIP and IHIP in px, whether there is a contact, and whether the HIP or the IHIP is where it must not be."""
    shades = numpy.array([(255, 255, 255), (222, 222, 226), (196, 196, 200), (172, 172, 176)], dtype=numpy.uint8)
    axes.imshow(shades[numpy.minimum(numpy.array(data["inside"]), 3)], origin="lower", extent=(0, PANEL_px[0], 0, PANEL_px[1]))
    for line in data["slow"]:
        axes.plot(*zip(*line), color=SLOW, linewidth=1.5)
    ticks, last = panel["ticks"], (-1e9, -1e9)
    for hip, ihip, touching, *_ in ticks:
        if touching and math.dist(hip, last) >= 9:
            axes.plot(*zip(hip, ihip), color=SPRING, linewidth=0.8)
            last = hip
    axes.plot(*zip(*(tick[0] for tick in ticks)), color=HIP, linewidth=0.8)
    dots = [(hip, WRONG if missed else HIP) for hip, _, _, missed, _ in ticks]
    dots += [(ihip, WRONG if entered else IHIP) for _, ihip, touching, _, entered in ticks if touching]
    axes.scatter(*zip(*(place for place, _ in dots)), s=13, c=[colour for _, colour in dots], linewidths=0, zorder=3)
    scale_bar(axes, data["px_per_m"])
    return (f"longest spring {length_text(panel['longest_m'])}; inside without force {sum(tick[3] for tick in ticks)} ticks, "
            f"IHIP inside {sum(tick[4] for tick in ticks)}")


def values(axes, data, panel):
    highest = max(*data["panels"][0]["values"], *data["panels"][1]["values"], 1e-30)
    left, width, height = 56, PANEL_px[0] - 68, PANEL_px[1] - 40
    for share in (0, 0.25, 0.5, 0.75, 1):
        axes.plot([left, left + width], [26 + share * height] * 2, color=EDGE, linewidth=0.7)
        axes.text(left - 5, 26 + share * height, number_text(share * highest), size=9, color=INK, ha="right", va="center")
    own = numpy.array(panel["values"])
    axes.plot(left + width * numpy.arange(len(own)) / len(own), 26 + height * own / highest, color=IHIP, linewidth=1.5)
    axes.text(left, 6, "tick 0", size=9, color=INK)
    axes.text(left + width, 6, str(len(own)), size=9, color=INK, ha="right")
    return f"largest value {number_text(own.max())} {data['unit']}"


def places(axes, data, panel):
    axes.add_collection(matplotlib.collections.LineCollection(data["edges"], colors=EDGE, linewidths=0.6))
    if panel["places"]:
        axes.scatter(*zip(*panel["places"]), s=13, c=WRONG, linewidths=0, zorder=3)
    scale_bar(axes, data["px_per_m"])
    return f"{panel['count']} segments pass without a contact"


def correction(data, stem):
    wide, tall = PANEL_px
    page = Page(48 + 2 * wide, 128 + tall)
    page.text(16, 30, data["title"], 17, bold=True)
    for i, panel in enumerate(data["panels"]):
        left = 16 + i * (wide + 16)
        axes = page.axes(left, 90, wide, tall)
        verdict = {"section": section, "values": values, "places": places}[data["kind"]](axes, data, panel)
        axes.set(xlim=(0, wide), ylim=(0, tall), xticks=[], yticks=[])
        for spine in axes.spines.values():
            spine.set(visible=True, color="#b8bdc4")
        page.text(left, 67, panel["heading"], 14, bold=True)
        page.text(left, 84, verdict, 12)
    keys = {"section": [("HIP, each tick", HIP, "o"), ("IHIP", IHIP, "o"), ("spring", SPRING, "_"),
                        ("HIP without force, or IHIP, inside a body", WRONG, "o")],
            "values": [(data.get("meaning"), IHIP, "_")],
            "places": [("place of a lost segment (those on this side of the mesh)", WRONG, "o"),
                       ("edges of the mesh", EDGE, "_")]}[data["kind"]]
    left = 16
    for meaning, colour, mark in keys + ([("IHIP of a slow hand", SLOW, "_")] if data.get("slow") else []):
        page.disc(left + 7, tall + 108, 8, colour) if mark == "o" else page.box(left, tall + 107, 14, 2, colour)
        left = page.text(left + 20, tall + 112, meaning, 12) + 22
    page.save(stem, "png")


def timeline(data, stem):
    """Panels one below another over the same time, logarithmic in y."""
    page = Page(1640, 320 + 312 * len(data["panels"]))
    page.head(90, 50, data["title"], data["caption"], 16)
    for i, panel in enumerate(data["panels"]):
        axes = page.axes(90, 291 + 312 * i, 1500, 250)
        low, high = panel["decades"]
        axes.set(xlim=(0, data["seconds"]), yscale="log", ylim=(10.0 ** low, 10.0 ** high))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.grid(axis="y", color=RULE)
        axes.set_axisbelow(True)
        for begin, end, kind in data["bands"]:
            axes.axvspan(begin, end, color={"attack": "#fbf0e8", "cut": "#ccccd1"}[kind], linewidth=0, zorder=0)
        axes.set_title(panel["title"], loc="left", size=12, color=INK)
        right = 1590
        for curve in reversed(panel["curves"]):
            colour = {"udp": BLUE, "tcp": VERMILION, "servo": "#00805c", "missed": "#bf1a1a"}[curve["colour"]]
            if curve["points"]:
                x, y = numpy.array(curve["points"]).T
                axes.plot(x, numpy.maximum(y, 10.0 ** low), color=colour, linewidth=1.2)
            page.text(right, 283 + 312 * i, curve["name"], 16, colour, ha="right")
            right -= 10 * len(curve["name"]) + 30
        if i == 0:
            for at, what in data["events"]:
                axes.annotate(what, (at, 10.0 ** high), (3, 18), textcoords="offset points", rotation=90, size=9, color=INK,
                              va="bottom", ha="center", annotation_clip=False)
    axes.set_xlabel("s", size=12, color=INK)
    page.save(stem, "png", "svg")


if __name__ == "__main__":
    matplotlib.rcParams["svg.hashsalt"] = "haptics"
    {function.__name__: function for function in (chart, tool_points, stability, teleoperation, worst, worst_import, advise, textures,
                                                  combinations, correction, timeline)}[sys.argv[1]](json.load(sys.stdin), sys.argv[2])
