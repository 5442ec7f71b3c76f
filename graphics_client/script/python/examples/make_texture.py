"""Makes a recorded texture (EFFECT_KIND_RECORDED_TEXTURE) of a recording of a tool that strokes a surface.

    make_texture.py stroke.csv --object box --out sandpaper.scene     a recording of one's own
    make_texture.py Models_Wood.xml --object box --out wood.scene     models of the Penn Haptic Texture Toolkit, of 10 kHz
    hapticctl apply sandpaper.scene

The columns of the CSV are "time [s]", "speed [m/s]" of the tool along the surface, "force [N]" across it, and "acceleration [m/s^2]"
of the tool across the stroke; rows are evenly apart in time, 500 to 50,000 a second. Ten seconds in which speed and force go through
all of their ranges are enough.
"""
import argparse
import csv
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy

from haptics.scene import Scene, recorded_texture

MAX_ORDER, MAX_MODELS, MOST_REFLECTION = 32, 64, 0.99999
PART_S = 0.1            # of a recording, in which speed and force count as constant
LEAST_Hz = 10           # slower changes of an acceleration are the hand's
COLUMNS = ("time [s]", "speed [m/s]", "force [N]", "acceleration [m/s^2]")


def burg(parts, order):
    """Reflection coefficients of the autoregressive process that all parts are pieces of: Burg's method, by which each is within
    -1 and 1."""
    forward, backward = [part[1:] for part in parts], [part[:-1] for part in parts]
    reflection = []
    for _ in range(order):
        above = sum(numpy.dot(f, b) for f, b in zip(forward, backward))
        below = sum(numpy.dot(f, f) + numpy.dot(b, b) for f, b in zip(forward, backward))
        k = -2 * above / below if below > 0 else 0.0
        reflection.append(float(k))
        forward, backward = ([(f + k * b)[1:] for f, b in zip(forward, backward)],
                             [(b + k * f)[:-1] for f, b in zip(forward, backward)])
    return reflection


def reflection_of(coefficients):
    """Of 1 + a_1 / z + ...; ValueError: it has a pole on the unit circle or beyond."""
    a, reflection = numpy.asarray(coefficients, float) / coefficients[0], []
    while len(a) > 1:
        k = a[-1]
        if not abs(k) < 1:
            raise ValueError("has a pole on the unit circle or beyond")
        reflection.insert(0, float(k))
        a = ((a - k * a[::-1]) / (1 - k * k))[:-1]
    return reflection


def texture_of(speeds, forces, models, rate_Hz, mass_kg):
    """The effect. `models`: of each speed those of all forces, each a deviation (m/s^2) and reflection coefficients."""
    loudest = max(model[0] for model in models)
    if not loudest > 0:
        raise ValueError("is silent")
    clipped = [[model[0] / loudest, *numpy.clip(model[1], -MOST_REFLECTION, MOST_REFLECTION)] for model in models]
    return recorded_texture(amplitude_N=mass_kg * loudest, sample_rate_Hz=rate_Hz, speeds_m_per_s=speeds, forces_N=forces,
                            models=[float(number) for model in clipped for number in model])


def from_recording(path, order, count, mass_kg):
    """Of a CSV; ValueError says what is wrong with it."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = csv.DictReader(file)
        missing = [name for name in COLUMNS if name not in (rows.fieldnames or ())]
        if missing:
            raise ValueError(f'has no column "{missing[0]}"')
        data = numpy.array([[float(row[name]) for name in COLUMNS] for row in rows])
    if not numpy.isfinite(data).all():
        raise ValueError("has a number that is not finite")
    time, speed, force, acceleration = data.T if len(data) else numpy.zeros((4, 0))
    steps = numpy.diff(time)
    if len(steps) < 1000 or steps.min() <= 0 or steps.max() > 1.5 * steps.mean():
        raise ValueError("has fewer than 1,001 rows, or they are not evenly apart in time")
    rate_Hz = 1 / steps.mean()
    if not 500 <= rate_Hz <= 50_000:
        raise ValueError(f"has {rate_Hz:.4g} rows a second; 500 to 50,000 are needed")
    spectrum = numpy.fft.rfft(acceleration)
    spectrum[numpy.fft.rfftfreq(len(acceleration), 1 / rate_Hz) < LEAST_Hz] = 0
    acceleration = numpy.fft.irfft(spectrum, len(acceleration))
    size = int(PART_S * rate_Hz)
    parts = [slice(i, i + size) for i in range(0, len(data) - size, size // 2)]
    at = numpy.array([[speed[part].mean(), force[part].mean()] for part in parts])
    most = numpy.quantile(at, 0.95, axis=0)
    if not (most > 0).all():
        raise ValueError("has no stroke: speed or force is 0")
    speeds, forces = ([float(top * (i + 1) / count) for i in range(count)] for top in most)
    models = []
    for v in speeds:
        for f in forces:
            apart = numpy.hypot(*((at - (v, f)) / most * count).T)
            near = [acceleration[part] for part, far in zip(parts, apart) if far <= max(0.5, apart.min())]
            models.append((float(numpy.sqrt(numpy.mean(numpy.square(near)))), burg(near, order)))
    return texture_of(speeds, forces, models, float(rate_Hz), mass_kg)


def from_toolkit(path, count, mass_kg):
    """Of a file of the Penn Haptic Texture Toolkit (Culbertson, Lopez Delgado & Kuchenbecker 2014), with elements as its own public
    scripts read them; ValueError says what is wrong with it."""
    try:
        root = ElementTree.parse(path).getroot()
        if root.tag != "modelSet":
            raise ValueError("is no set of models")
        found = root.findall("model")
        at = numpy.array([(float(model.findtext("speedMod")) * 1e-3, float(model.findtext("forceMod"))) for model in found])
        if int(root.findtext("numMACoeff") or 0) > 0:
            raise ValueError("was made for another rate, with zeros beside its poles; give the one of 10 kHz")
        if root.findtext("SpeedUnits") != "mm/s" or root.findtext("ForceUnits") != "N" or root.findtext("AccelUnits") != "m/s^2":
            raise ValueError("has other units than mm/s, N and m/s^2")
        triangles = [[int(value.text) - 1 for value in triangle.iter("value")] for triangle in root.findall("tri")]
        rate_Hz = float(root.findtext("SampleRate"))
        reflection = numpy.array([reflection_of([float(value.text) for value in model.find("ARcoeff")]) for model in found])
        variance = numpy.array([float(model.findtext("var")) for model in found])
        corners = at[numpy.array(triangles)]
    except (ElementTree.ParseError, AttributeError, TypeError, IndexError) as error:
        raise ValueError(f"is no set of models: {error}") from None
    order = reflection.shape[1]
    if not 1 <= order <= MAX_ORDER:
        raise ValueError(f"has {order} coefficients; an effect has at most {MAX_ORDER}")
    deviation = numpy.sqrt(variance / numpy.prod(1 - reflection ** 2, axis=1))
    speeds, forces = ([float(top * (i + 1) / count) for i in range(count)] for top in at.max(axis=0))

    def model_at(place):
        for triangle, (a, b, c) in zip(triangles, corners):
            sides = numpy.array([b - a, c - a]).T
            if abs(numpy.linalg.det(sides)) < 1e-12:
                continue
            u, v = numpy.linalg.solve(sides, place - a)
            if min(u, v, 1 - u - v) >= -1e-6:
                weights = numpy.array([1 - u - v, u, v])
                return weights @ deviation[triangle], weights @ reflection[triangle]
        nearest = numpy.argmin(numpy.hypot(*((at - place) / at.max(axis=0)).T))
        return deviation[nearest], reflection[nearest]

    models = [model_at(numpy.array([v, f])) for v in speeds for f in forces]
    return texture_of(speeds, forces, [(float(of), list(k)) for of, k in models], rate_Hz, mass_kg)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", type=Path, metavar="FILE", help="CSV, or XML of the toolkit")
    parser.add_argument("--object", required=True, metavar="NAME", help="which is to have the texture")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="a scene file that sets it")
    parser.add_argument("--mass", type=float, default=0.05, metavar="KG", help="of the tool: what makes a force of an acceleration (0.05)")
    parser.add_argument("--order", type=int, default=16, metavar="N", help=f"of the models of a CSV, 1 to {MAX_ORDER} (16)")
    parser.add_argument("--grid", type=int, default=6, metavar="N", help="speeds, and forces, that have models, 1 to 8 (6)")
    arguments = parser.parse_args()
    if not 1 <= arguments.order <= MAX_ORDER or not 1 <= arguments.grid <= 8 or not 0 < arguments.mass <= 10:
        parser.error(f"give an order of 1 to {MAX_ORDER}, a grid of 1 to 8, a mass of up to 10 kg")
    try:
        if arguments.recording.suffix.lower() == ".xml":
            texture = from_toolkit(arguments.recording, arguments.grid, arguments.mass)
        else:
            texture = from_recording(arguments.recording, arguments.order, arguments.grid, arguments.mass)
        scene = Scene()
        scene.set_effects(object={"name": arguments.object}, effects=[texture])
        scene.save(arguments.out)
    except (OSError, ValueError) as error:
        sys.exit(f"make_texture: {arguments.recording}: {error}")
    print(f"{arguments.out}: {len(texture.speeds_m_per_s) * len(texture.forces_N)} models, {texture.amplitude_N:.3g} N where it is "
          "loudest; it replaces the effects of the object")


if __name__ == "__main__":
    main()
