"""The results page: one file without scripts, from what measure.py wrote.

usage: page.py RESULTS.json OUT.html
"""

import html
import json
import math
import sys
from pathlib import Path

STYLE = """
body { font: 16px/1.45 system-ui, sans-serif; margin: 0 auto; max-width: 70rem; padding: 0 1rem 3rem; color: #1b1b1b; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.2rem; margin-top: 2rem; }
.wide { overflow-x: auto; } table { border-collapse: collapse; font-size: .85rem; }
th, td { padding: .2rem .45rem; border: 1px solid #ddd; text-align: right; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; position: sticky; left: 0; background: #fff; }
.pass { background: #d9efd9; } .fail { background: #f6cfc9; } .fault { background: #e0b3e6; } .none { color: #999; }
figure { margin: 1rem 0; } svg { width: 100%; max-width: 34rem; height: auto; } svg text { font-size: 13px; }
.names { list-style: none; padding: 0; columns: 14rem; }
.names li { white-space: nowrap; }
code { font-size: .85rem; overflow-wrap: anywhere; } summary { cursor: pointer; } dt { font-weight: 600; } dd { margin: 0 0 .3rem 1rem; }
"""
COLOURS = ("#000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7a5195", "#8c8c8c", "#a6761d", "#1b5e20")


def cell(runs):
    if runs is None:
        return '<td class="none"></td>'
    ran = runs["pass"] + runs["fail"] + runs["fault"]
    if ran == 0:
        return f'<td class="none" title="{html.escape(runs["why"])}">n/a</td>'
    bad = runs["fail"] + runs["fault"]
    kind = "pass" if bad == 0 else "fault" if runs["fault"] else "fail"
    why = f' title="{html.escape(runs["why"])}"' if "why" in runs else ""
    return f'<td class="{kind}"{why}>{"." if bad == 0 else f"{bad}/{ran}"}</td>'


def failures(results):
    names = list(results["scenes"])
    rows = []
    for method in results["methods"]:
        cells = "".join(cell(method["failures"].get(name)) for name in names)
        runs = method["failures"].values()
        total = [sum(r[kind] for r in runs) for kind in ("pass", "fail", "fault", "not_applicable")]
        rows.append(f"<tr><td>{html.escape(method['name'])}</td>{cells}" + "".join(f"<td>{n}</td>" for n in total) + "</tr>")
    head = "".join(f"<th>{n}</th>" for n in (*names, "pass", "fail", "fault", "n/a"))
    about = "".join(f"<dt>{n}</dt><dd>{html.escape(results['scenes'][n])}</dd>" for n in names)
    return (f'<div class="wide"><table><tr><th>failed runs</th>{head}</tr>{"".join(rows)}</table></div>'
            f"<details><summary>What the scenes are</summary><dl>{about}</dl></details>")


RESOLUTIONS = (12, 192, 768, 3072, 12288, 65712)  # triangles that meshes are asked for: shapes round them each in its way


TIMES = ("median, caches hot", "median, caches cold", "slowest")


def points(method):
    """By resolution: error of the worst shape in units of what a hand notices, and TIMES of a tick in ns, None where not measured."""
    found, counts = {}, {}
    for record in method["accuracy"]:
        seen = counts.setdefault(record["scene"], [])
        if record["triangles"] not in seen:
            seen.append(record["triangles"])
        if "epsilon_p99_ratio" in record:
            resolution = RESOLUTIONS[seen.index(record["triangles"])]
            new = (record["epsilon_p99_ratio"], record["tick_p50_ns"], record["tick_max_ns"])
            found[resolution] = tuple(map(max, found.get(resolution, new), new))
    cold = method.get("cold_ns", {})
    return {resolution: (error, (hot or None, cold.get(str(resolution)), most or None))
            for resolution, (error, hot, most) in found.items()}


def duration(exponent):
    """Of 10**exponent ns."""
    return f"{10**(exponent % 3)} {('ns', 'us', 'ms', 's')[exponent // 3]}"


def panel(title, curves, place, ticks):
    """One time of a tick against the error, logarithmic; a line for each method that has it."""
    parts = []
    for exponent in ticks[0]:
        x = place[0](10**exponent)
        parts.append(f'<path d="M{x:.0f} 30V330" stroke="#ddd"/><text x="{x:.0f}" y="350" text-anchor="middle">{duration(exponent)}</text>')
    for exponent in ticks[1]:
        y = place[1](10**exponent)
        parts.append(f'<path d="M55 {y:.0f}H435" stroke="#ddd"/><text x="50" y="{y + 4:.0f}" text-anchor="end">{10**exponent:g}</text>')
    for colour, curve in curves:
        path = " ".join(f"{place[0](x):.1f},{place[1](y):.1f}" for x, y in curve)
        parts.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.5"/>')
        parts += [f'<circle cx="{place[0](x):.1f}" cy="{place[1](y):.1f}" r="3.5" fill="{colour}"/>' for x, y in curve]
    return (f'<svg viewBox="0 0 465 380" role="img" aria-label="Error against ticks: {title}">{"".join(parts)}'
            f'<text x="245" y="372" text-anchor="middle">tick: {title}</text>'
            '<text x="10" y="18">error of the force, in units of what a hand notices</text></svg>')


def chart(results):
    """A panel for each of TIMES, on the same axes."""
    found = {m["name"]: sorted(points(m).items()) for m in results["methods"]}
    panels = [[(COLOURS[i % len(COLOURS)], [(times[k], error) for _, (error, times) in curve if times[k] and error > 0])
               for i, curve in enumerate(found.values())] for k in range(len(TIMES))]
    every = [p for curves in panels for _, curve in curves for p in curve]
    if not every:
        return ""
    low, high = ([f(math.log10(p[k]) for p in every) for k in (0, 1)] for f in (min, max))
    low, high = [math.floor(v) for v in low], [math.ceil(v) for v in high]
    place = [lambda v: 55 + 380 * (math.log10(v) - low[0]) / max(1, high[0] - low[0]),
             lambda v: 330 - 300 * (math.log10(v) - low[1]) / max(1, high[1] - low[1])]
    ticks = [range(low[k], high[k] + 1) for k in (0, 1)]
    names = "".join(f'<li><span style="color:{COLOURS[i % len(COLOURS)]}">&#9679;</span> {html.escape(name)}</li>'
                    for i, (name, curve) in enumerate(found.items()) if curve)
    return (f'<figure><ul class="names">{names}</ul>{"".join(map(panel, TIMES, panels, *([v] * len(TIMES) for v in (place, ticks))))}'
            "<figcaption>Six exact shapes, 2 mm deep at 0.1 m/s; a point for each resolution of the mesh; the error that 99 % of "
            "the ticks keep to, and the tick, of the worst shape. Cold, with every cache swept before, is the median over all shapes, and "
            "of built-in methods alone. The slowest tick has in it what else the machine did."
            "</figcaption></figure>")


def accuracy(results):
    rows = []
    for method in results["methods"]:
        for triangles, (error, times) in sorted(points(method).items()):
            cells = "".join(f"<td>{time:,.0f}</td>" if time else '<td class="none"></td>' for time in times)
            rows.append(f"<tr><td>{html.escape(method['name'])}</td><td>{triangles}</td><td>{error:.3g}</td>{cells}</tr>")
    head = "".join(f"<th>ns, {time}</th>" for time in TIMES)
    return ('<details><summary>As a table</summary><div class="wide"><table><tr><th>method</th><th>triangles</th><th>error</th>'
            f'{head}</tr>{"".join(rows)}</table></div></details>')


def quoted(quote):
    parts = [f"<p>{html.escape(quote['of'])}. {html.escape(quote['how'])}</p>"]
    for table in quote["tables"]:
        rows = "".join("<tr>" + "".join(f"<td>{html.escape(c)}</td>" for c in row) + "</tr>" for row in table["rows"])
        head = "".join(f"<th>{html.escape(c)}</th>" for c in table["head"])
        parts.append(f"<h3>{html.escape(table['title'])}</h3><div class='wide'><table><tr>{head}</tr>{rows}</table></div>"
                     f"<p>{html.escape(table['since'])}</p>")
    return "".join(parts)


def page(results, quote):
    machine = ", ".join(f"{key} {value}" for key, value in results["machine"].items())
    methods = "".join(f"<dt>{html.escape(m['name'])}{' (from outside)' if m['outside'] else ''}</dt>"
                      f"<dd>{html.escape(m['version'])}</dd>" for m in results["methods"])
    repeat = "".join(f"<li><code>{html.escape(line)}</code></li>" for line in results["repeat"])
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Haptic rendering: methods by scenes</title><style>{STYLE}</style></head><body>
<h1>Haptic rendering: methods by scenes</h1>
<p>{len(results["methods"])} methods of rendering contact with a point, {len(results["scenes"])} failure scenes, seeds 1 to {results["seeds"]}.
A dot: every run passed. A number: runs that failed, of those made; violet: the method crashed, hung, or refused the scene.
n/a: the scene needs what the method does not declare; empty: the scene is about what it has no part in.</p>
<h2>Failure scenes</h2>{failures(results)}
<h2>Speed against accuracy</h2>{chart(results)}{accuracy(results)}
<h2>Methods and versions</h2><p>Libraries of bodies have no point in the hand but a sphere of 1 mm, felt from where the hand itself is
below the surface. Their adapters are this project's: whoever knows a better way to use one changes it.</p><dl>{methods}</dl>
<h2>Quoted</h2>{quoted(quote)}
<h2>Repeat it</h2><p>Each cell is one row of what these write; M is a method's name, or its library in <code>bin/methods</code>:</p>
<ul>{repeat}</ul><p>Times are of one machine: {html.escape(machine)}. Times of methods from outside leave out the way to their
process and back.</p>
</body></html>
"""


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: page.py RESULTS.json OUT.html")
    results, out = json.loads(Path(sys.argv[1]).read_text()), Path(sys.argv[2])
    quote = json.loads((Path(__file__).parent / "quoted.json").read_text())
    out.write_text(page(results, quote))


if __name__ == "__main__":
    main()
