"""Draws a session that `hapticctl export` wrote as HDF5: force, penetration, the path on the surface, the force's spectrum and
the energy by cause.

    haptic_plot.py --out session.png session.h5
    haptic_plot.py --out session.svg --title "Wood, 0.4 N" session.h5

`hapticctl plot` does both from a recording. In a program: figure(session, title) gives the matplotlib figure.
"""
import argparse
import sys

COLOURS = {"x": "tab:red", "y": "tab:green", "z": "tab:blue"}
CAUSES = ("contact", "shading", "friction", "texture", "motion", "edit", "wrench")
MAX_POINTS = 4000  # of a curve: more make a vector file slow, and are not seen
SPECTRUM_S = 1.0   # of a part of the signal whose spectrum is averaged


def figure(session, title=""):
    """`session`: an h5py.File. Raises ValueError where it is none of `hapticctl export`."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot

    if "ticks/force/written" not in session:
        raise ValueError("holds no ticks/force/written: it is not what hapticctl export writes")
    ticks = session["ticks"]
    period_s = 1 / session.attrs["rate_Hz"]
    number = ticks["tick"][:].astype("int64")
    if not len(number):
        raise ValueError("holds no tick")
    time_s = (number - number[0]) * period_s
    drawing = pyplot.figure(figsize=(10, 9), layout="constrained")
    grid = drawing.add_gridspec(3, 2)
    _force(drawing.add_subplot(grid[0, :]), time_s, ticks["force/written"][:], session, number[0], period_s)
    _penetration(drawing.add_subplot(grid[1, 0]), time_s, ticks)
    _path(drawing, drawing.add_subplot(grid[1, 1]), ticks)
    _spectrum(drawing.add_subplot(grid[2, 0]), ticks, period_s)
    _energy(drawing.add_subplot(grid[2, 1]), time_s, ticks["energy_given"][:])
    missed, lost = session.attrs["ticks_missed_by_servo"], session.attrs["ticks_lost"]
    drawing.suptitle(f"{title or session.attrs['source']}\n{session.attrs['device']}, {session.attrs['rate_Hz']:g} Hz, "
                     f"{len(number)} ticks, {missed} missed by the servo, {lost} lost", fontsize=10)
    return drawing


def _thinned(time_s, values):
    """Lowest and highest value of each stretch, where there are more than are seen."""
    import numpy
    count = len(values)
    if count <= MAX_POINTS:
        return time_s, values
    stretch = -(-count // (MAX_POINTS // 2))
    whole = count // stretch * stretch
    parts = values[:whole].reshape(-1, stretch)
    begins = numpy.arange(0, whole, stretch)
    at = numpy.sort(numpy.concatenate([begins + parts.argmin(1), begins + parts.argmax(1)]))
    return time_s[at], values[at]


def _force(axes, time_s, force, session, first, period_s):
    import numpy
    for i, (name, colour) in enumerate(COLOURS.items()):
        axes.plot(*_thinned(time_s, force[:, i]), color=colour, linewidth=0.7, label=name)
    axes.plot(*_thinned(time_s, numpy.linalg.norm(force, axis=1)), color="black", linewidth=0.9, label="magnitude")
    for group, colour, what in (("edits", "tab:green", "edit"), ("faults", "tab:red", "fault")):
        label = what
        for tick in session[group]["tick"][:].astype("int64"):
            if tick > first:
                axes.axvline((tick - first) * period_s, color=colour, linestyle=":", linewidth=1, label=label)
                label = None
    axes.set(xlabel="time (s)", ylabel="force on the hand (N)", xlim=(0, max(time_s[-1], period_s)))
    axes.legend(loc="upper right", ncols=6, fontsize=8)


def _penetration(axes, time_s, ticks):
    axes.plot(*_thinned(time_s, 1e3 * ticks["penetration"][:]), color="tab:purple", linewidth=0.8)
    axes.set(xlabel="time (s)", ylabel="penetration (mm)")


def _path(drawing, axes, ticks):
    """Of the IHIP while it touches, in the plane in which it spreads most."""
    import numpy
    touching = ticks["object"][:] != 0
    places = 1e3 * ticks["ihip"][:][touching]
    axes.set(xlabel="IHIP, along its path (mm)", ylabel="across (mm)")
    if len(places) < 2:
        axes.text(0.5, 0.5, "nothing was touched", ha="center", va="center", transform=axes.transAxes)
        return
    force = numpy.linalg.norm(ticks["force/written"][:][touching], axis=1)
    every = -(-len(places) // MAX_POINTS)
    middle = places.mean(0)
    directions = numpy.linalg.svd((places - middle)[::every], full_matrices=False)[2]
    flat = (places - middle)[::every] @ directions[:2].T
    shown = axes.scatter(flat[:, 0], flat[:, 1], c=force[::every], s=2, cmap="viridis", rasterized=True)
    axes.set_aspect("equal", adjustable="datalim")
    drawing.colorbar(shown, ax=axes, label="force (N)")


def _spectrum(axes, ticks, period_s):
    """Amplitude density of the force along the normal, while something is touched."""
    import numpy
    normal = ticks["surface_normal"][:]
    signal = (ticks["force/written"][:] * normal).sum(1)
    length = max(16, round(SPECTRUM_S / period_s))
    touching = ticks["object"][:] != 0
    parts = [signal[i:i + length] for i in range(0, len(signal) - length + 1, length // 2) if touching[i:i + length].all()]
    axes.set(xlabel="frequency (Hz)", ylabel="normal force (N/√Hz)")
    if not parts:
        axes.text(0.5, 0.5, f"nothing was touched for {SPECTRUM_S:g} s", ha="center", va="center", transform=axes.transAxes)
        return
    window = numpy.hanning(length)
    spectra = [numpy.abs(numpy.fft.rfft(window * (part - part.mean()))) ** 2 for part in parts]
    density = numpy.sqrt(2 * period_s / (window ** 2).sum() * numpy.mean(spectra, 0))
    axes.loglog(numpy.fft.rfftfreq(length, period_s)[1:], numpy.maximum(density[1:], 1e-9), linewidth=0.8)


def _energy(axes, time_s, energy_J):
    for cause, energy in zip(CAUSES, energy_J.T):
        given = 1e3 * (energy - energy[0])
        if abs(given).max() > 0:
            axes.plot(*_thinned(time_s, given), linewidth=0.8, label=cause)
    axes.set(xlabel="time (s)", ylabel="energy given to the hand (mJ)")
    if axes.lines:
        axes.legend(fontsize=8)


def main():
    parser = argparse.ArgumentParser(prog="haptic_plot.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", required=True, metavar="FILE", help="a picture: .png, .svg or .pdf")
    parser.add_argument("--title", default="", metavar="TEXT")
    parser.add_argument("session", metavar="SESSION.h5")
    arguments = parser.parse_args()
    try:
        import h5py
        import matplotlib  # noqa: F401
    except ImportError as error:
        sys.exit(f"haptic_plot: {error}; install python3-matplotlib and python3-h5py")
    try:
        with h5py.File(arguments.session) as session:
            drawn = figure(session, arguments.title)
        drawn.savefig(arguments.out, dpi=150)
    except (OSError, ValueError) as error:
        sys.exit(f"haptic_plot: {error}")


if __name__ == "__main__":
    main()
