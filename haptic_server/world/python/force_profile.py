"""Strokes across a rough plate and draws the force over the way: force_profile.py [PICTURE.png]

Needs numpy and matplotlib, and build/release/python on PYTHONPATH.
"""
import sys

import matplotlib
import numpy

import haptics

matplotlib.use("Agg")
import matplotlib.pyplot as plot  # noqa: E402

# A plate of 100 mm by 40 mm whose top, at z = 0, has waves of 0.5 mm along x.
x, y = numpy.meshgrid(numpy.linspace(-0.05, 0.05, 401), numpy.linspace(-0.02, 0.02, 9), indexing="ij")
vertices = numpy.stack([x, y, 0.0005 * numpy.sin(2 * numpy.pi * x / 0.01)], axis=-1).reshape(-1, 3)
corner = numpy.arange(400 * 9).reshape(400, 9)[:, :8].reshape(-1)
triangles = numpy.concatenate([numpy.stack([corner, corner + 9, corner + 10], axis=-1),
                               numpy.stack([corner, corner + 10, corner + 1], axis=-1)])

world = haptics.World(haptics.Device.named("omni"))
world.add("plate", vertices, triangles, haptics.Material(stiffness_N_per_m=600, static_friction=0.3, dynamic_friction=0.2))

# One second down to 2 mm below the plate, then 80 mm along it at 40 mm/s: a position for each millisecond.
down, along = numpy.linspace(0.01, -0.002, 1000), numpy.linspace(-0.04, 0.04, 2000)
positions = numpy.zeros((3000, 3))
positions[:, 0] = numpy.concatenate([numpy.full(1000, -0.04), along])
positions[:, 2] = numpy.concatenate([down, numpy.full(2000, -0.002)])
samples = world.run(positions)

stroke = samples[1000:]
print(f"{len(samples)} ticks; pressed with {stroke['force_N'][:, 2].mean():.2f} N on average, "
      f"friction {abs(stroke['force_N'][:, 0]).mean():.2f} N")
plot.figure(figsize=(8, 4))
plot.plot(along * 1e3, stroke["force_N"][:, 2], label="normal")
plot.plot(along * 1e3, stroke["force_N"][:, 0], label="along the stroke")
plot.xlabel("x (mm)")
plot.ylabel("force on the hand (N)")
plot.legend()
plot.tight_layout()
plot.savefig(sys.argv[1] if len(sys.argv) > 1 else "force_profile.png")
