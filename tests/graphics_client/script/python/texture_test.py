"""Models of recorded textures: of a recording, and of the toolkit's layout."""
import csv
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy
from haptics import scene

EXAMPLES = Path(__file__).parents[4] / "graphics_client/script/python/examples"
sys.path.insert(0, str(EXAMPLES))
import make_texture  # noqa: E402

POLES = numpy.array([0.9 * numpy.exp(0.4j), 0.9 * numpy.exp(-0.4j), 0.7 * numpy.exp(1.5j), 0.7 * numpy.exp(-1.5j)])


def process(count, rng):
    a = numpy.poly(POLES).real
    signal = numpy.zeros(count)
    for i, noise in enumerate(rng.standard_normal(count)):
        signal[i] = noise - a[1:] @ signal[max(0, i - 4):i][::-1] if i >= 4 else noise
    return signal


def density_dB(reflection, rate_Hz):
    a = numpy.array([1.0])
    for k in reflection:
        a = numpy.append(a, 0)
        a = a + k * a[::-1]
    z = numpy.exp(-2j * numpy.pi * numpy.arange(20, 401, 10) / rate_Hz)
    return 10 * numpy.log10(numpy.prod(1 - numpy.square(reflection)) / abs(numpy.polyval(a[::-1], z)) ** 2)


class MakeTexture(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def made(self, recording, *arguments):
        out = self.folder / "texture.scene"
        done = subprocess.run([sys.executable, EXAMPLES / "make_texture.py", recording, "--object", "box", "--out", out, *arguments],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        [operation] = scene.Scene.load(out).transaction.operations
        return operation.set_effects.effects[0]

    def refusal(self, recording):
        done = subprocess.run([sys.executable, EXAMPLES / "make_texture.py", recording, "--object", "box", "--out", self.folder / "out"],
                              capture_output=True, text=True)
        self.assertNotEqual(done.returncode, 0)
        self.assertFalse((self.folder / "out").exists())
        return done.stderr

    def recording(self, names=make_texture.COLUMNS, seconds=10.0, rate_Hz=2000):
        """Twice as loud at twice the speed."""
        time = numpy.arange(int(seconds * rate_Hz)) / rate_Hz
        speed, force = 0.1 * (1 + numpy.sin(time)), 1 + 0.5 * numpy.sin(2.7 * time)
        acceleration = speed / 0.1 * process(len(time), numpy.random.default_rng(1))
        path = self.folder / "stroke.csv"
        with open(path, "w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([names, *zip(time, speed, force, acceleration)])
        return path

    def test_a_recording_has_the_spectrum_of_its_models(self):
        effect = self.made(self.recording(), "--grid", "4", "--order", "8", "--mass", "0.1")
        self.assertAlmostEqual(effect.sample_rate_Hz, 2000, delta=1)
        models = numpy.array(effect.models).reshape(4, 4, 9)
        wanted = density_dB(make_texture.reflection_of(numpy.poly(POLES).real), 2000)
        for model in models[1:].reshape(-1, 9):
            self.assertLess(abs(density_dB(model[1:], 2000) - wanted).max(), 2.5)
        self.assertLess(abs(density_dB(models[1:, :, 1:].mean(axis=(0, 1)), 2000) - wanted).max(), 1)
        loudness = models[:, :, 0].mean(axis=1)
        self.assertAlmostEqual(loudness[3] / loudness[1], 2, delta=0.3)
        variance = 1 / numpy.prod(1 - numpy.square(make_texture.reflection_of(numpy.poly(POLES).real)))
        deviation = effect.amplitude_N / 0.1 * models[1, :, 0].mean()
        self.assertAlmostEqual(deviation / (effect.speeds_m_per_s[1] / 0.1 * variance ** 0.5), 1, delta=0.1)

    def test_what_is_wrong_with_a_recording_is_said(self):
        self.assertIn('has no column "speed [m/s]"', self.refusal(self.recording(("time [s]", "v", "force [N]", "a"))))
        self.assertIn("1,001 rows", self.refusal(self.recording(seconds=0.3)))
        self.assertIn("500 to 50,000", self.refusal(self.recording(seconds=20, rate_Hz=100)))
        self.assertIn("No such file", self.refusal(self.folder / "none.csv"))

    def toolkit_file(self, coefficients=(1, -0.5, 0.2), moving_average=0, units="mm/s"):
        """Four models at the corners of 0 to 200 mm/s and 0 to 4 N, silent where one is 0."""
        values = "".join(f"<value>{number}</value>" for number in coefficients)
        models = "".join(f"<model><ARcoeff>{values}</ARcoeff><var>{0.5 if speed * force else 0}</var><speedMod>{speed}</speedMod>"
                         f"<forceMod>{force}</forceMod></model>" for speed in (0, 200) for force in (0, 4))
        triangles = "".join("<tri>" + "".join(f"<value>{i}</value>" for i in triangle) + "</tri>" for triangle in ((1, 2, 3), (2, 4, 3)))
        path = self.folder / "Models_Test.xml"
        path.write_text(f"<modelSet><AccelUnits>m/s^2</AccelUnits><SpeedUnits>{units}</SpeedUnits><ForceUnits>N</ForceUnits>"
                        f"<SampleRate>10000</SampleRate>{triangles}<numARCoeff>{len(coefficients) - 1}</numARCoeff>"
                        f"<numMACoeff>{moving_average}</numMACoeff>{models}</modelSet>")
        return path

    def test_the_toolkits_models_are_read(self):
        effect = self.made(self.toolkit_file(), "--grid", "2")
        self.assertEqual((list(effect.speeds_m_per_s), list(effect.forces_N), effect.sample_rate_Hz), ([0.1, 0.2], [2, 4], 10_000))
        k = (-0.5 / 1.2, 0.2)
        deviation = (0.5 / ((1 - k[0] ** 2) * (1 - k[1] ** 2))) ** 0.5
        self.assertAlmostEqual(effect.amplitude_N, 0.05 * deviation, places=12)
        models = numpy.array(effect.models).reshape(4, 3)
        numpy.testing.assert_allclose(models[:, 0], (0, 0.5, 0.5, 1), atol=1e-12)
        numpy.testing.assert_allclose(models[:, 1:], [k] * 4, atol=1e-12)

    def test_what_is_wrong_with_the_toolkits_file_is_said(self):
        self.assertIn("pole on the unit circle", self.refusal(self.toolkit_file((1, -2.5, 1.1))))
        self.assertIn("zeros beside its poles", self.refusal(self.toolkit_file(moving_average=4)))
        self.assertIn("other units", self.refusal(self.toolkit_file(units="m/s")))
        other = self.folder / "other.xml"
        other.write_text("<modelSet><model/></modelSet>")
        self.assertIn("no set of models", self.refusal(other))


if __name__ == "__main__":
    unittest.main()
