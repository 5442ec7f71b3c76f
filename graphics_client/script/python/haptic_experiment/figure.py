"""The picture of a session: proportion correct against level with the fit, and the levels trial by trial."""
import numpy

from haptic_experiment.psychometric import tally

COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:red")


def draw_figure(results, paths):
    """Draws the Results into files, whose names say the kind: .png, .svg."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plot
    figure, (function, track) = plot.subplots(1, 2, figsize=(11, 4.4))
    header = results.header
    figure.suptitle(f"{header['experiment']}, {header['participant']}" + (f": {results.simulated}" if results.simulated else ""),
                    color="darkred" if results.simulated else "black")
    draw_function(function, results)
    draw_track(track, results)
    figure.tight_layout()
    for path in paths:
        figure.savefig(path, dpi=110)
    plot.close(figure)


def draw_function(axes, results):
    levels, n, right = tally([(answer["level"], answer["correct"]) for answer in results.answers])
    axes.scatter(levels, right / n, s=12 + 4 * n, color="tab:blue", alpha=0.7, label="answers (area: n)", zorder=3)
    for level, count, correct in zip(levels, n, right):
        axes.annotate(f"{int(count)}", (level, correct / count), textcoords="offset points", xytext=(0, 7), ha="center",
                      fontsize=7)
    if results.fit:
        draw_fit(axes, results.fit, results.unit, levels)
    else:
        axes.text(0.5, 0.06, "no threshold", transform=axes.transAxes, ha="center", color="darkred")
    axes.axhline(0.5, color="grey", linewidth=0.8, linestyle=":")
    axes.set_xscale("log")
    axes.set_ylim(-0.05, 1.12)
    label_levels(axes.xaxis, results, [*levels, *([results.fit.low, results.fit.high] if results.fit else [])])
    axes.set_ylabel("proportion correct")
    axes.legend(loc="lower right", fontsize=8)


def draw_fit(axes, fit, unit, levels):
    over = numpy.geomspace(min(levels[0], fit.low) / 1.2, max(levels[-1], fit.high) * 1.2, 200)
    axes.plot(over, fit.proportion_correct(over), color="black", label=f"{fit.family} fit")
    axes.errorbar([fit.threshold], [0.75], xerr=[[fit.threshold - fit.low], [fit.high - fit.threshold]], color="tab:red", fmt="o",
                  capsize=4, zorder=4, label=f"threshold {fit.threshold:.3g} {unit} [{fit.low:.3g}, {fit.high:.3g}]")


def draw_track(axes, results):
    for staircase in sorted({answer["staircase"] for answer in results.answers}):
        own = [answer for answer in results.answers if answer["staircase"] == staircase]
        colour = COLOURS[(staircase - 1) % len(COLOURS)]
        axes.plot([answer["trial"] for answer in own], [answer["level"] for answer in own], color=colour, linewidth=0.8,
                  label=f"staircase {staircase}" if "staircase" in str(results.definition["method"]) else "levels")
        for correct, filled in ((True, colour), (False, "white")):
            shown = [answer for answer in own if answer["correct"] == correct]
            axes.scatter([answer["trial"] for answer in shown], [answer["level"] for answer in shown], s=16, facecolors=filled,
                         edgecolors=colour, zorder=3)
    if results.fit:
        axes.axhspan(results.fit.low, results.fit.high, color="tab:red", alpha=0.15)
        axes.axhline(results.fit.threshold, color="tab:red", linewidth=0.8)
    axes.set_yscale("log")
    axes.set_xlabel("trial (filled: correct)")
    label_levels(axes.yaxis, results, [answer["level"] for answer in results.answers])
    axes.legend(loc="upper right", fontsize=8)


def label_levels(axis, results, shown):
    from matplotlib.ticker import FixedLocator, NullFormatter, ScalarFormatter
    low, high = min(shown), max(shown)
    ticks = [mantissa * 10.0 ** power for power in range(-4, 6) for mantissa in (1, 2, 5)
             if low / 1.5 <= mantissa * 10.0 ** power <= high * 1.5]
    axis.set_major_locator(FixedLocator(ticks))
    axis.set_major_formatter(ScalarFormatter())
    axis.set_minor_formatter(NullFormatter())
    axis.set_label_text(f"{results.definition['level_name']} ({results.unit})")
