"""What the hand felt in an interval, and what can be estimated from it."""
import math
from dataclasses import dataclass

import numpy

MIN_TOUCHING = 15      # samples, without which nothing is estimated,
MIN_OF_SPECTRUM = 150  # and no wavelength


class NothingFelt(Exception):
    """Too little was felt in an interval to estimate anything from it."""


@dataclass(frozen=True)
class Felt:
    """Samples of n ticks in which the hand touched the surface, SI units, world frame."""
    tick: numpy.ndarray           # (n,)
    hip_m: numpy.ndarray          # (n, 3), the haptic interface point
    force_N: numpy.ndarray        # (n, 3), on the hand, as written
    normal: numpy.ndarray         # (n, 3), of the surface, unit
    penetration_m: numpy.ndarray  # (n,)
    rate_Hz: float                # of the samples

    @property
    def normal_force_N(self):
        """(n,): F_n = F . N."""
        return (self.force_N * self.normal).sum(axis=1)

    def summary(self):
        """For the log: first and last tick of contact, seconds of contact, mean normal force and largest force."""
        touched = len(self.tick) > 0
        return {"first_tick": int(self.tick[0]) if touched else 0, "last_tick": int(self.tick[-1]) if touched else 0,
                "contact_s": round(len(self.tick) / self.rate_Hz, 4),
                "normal_force_N": round(float(self.normal_force_N.mean()), 5) if touched else 0.0,
                "peak_force_N": round(float(numpy.linalg.norm(self.force_N, axis=1).max()), 5) if touched else 0.0}


def stiffness_N_per_m(felt):
    """Mean normal force over mean penetration: k = F_n / d. Needs a press; raises NothingFelt."""
    check_touched(felt)
    return float(felt.normal_force_N.mean() / felt.penetration_m.mean())


def friction_coefficient(felt):
    """Mean tangential over mean normal force: mu = |F - F_n N| / F_n (Coulomb), without the first fifth of the stroke, in which
    friction still sticks. Raises NothingFelt."""
    check_touched(felt)
    first = len(felt.tick) // 5
    normal_force = felt.normal_force_N[first:]
    tangential = felt.force_N[first:] - normal_force[:, None] * felt.normal[first:]
    return float(numpy.linalg.norm(tangential, axis=1).mean() / normal_force.mean())


def wavelength_m(felt):
    """Of the strongest periodic part of the normal force along a straight stroke: the peak of its Fourier transform over
    the distance, in a Hann window, refined by a parabola through the logarithm of three bins. Raises NothingFelt."""
    check_touched(felt, MIN_OF_SPECTRUM)
    way = felt.hip_m[-1] - felt.hip_m[0]
    length = float(numpy.linalg.norm(way))
    along = (felt.hip_m - felt.hip_m[0]) @ way / length if length else numpy.zeros(len(felt.tick))
    forward = numpy.concatenate([[True], numpy.diff(numpy.maximum.accumulate(along)) > 0])
    count = 1024
    places = numpy.linspace(0, length, count)
    force = numpy.interp(places, along[forward], felt.normal_force_N[forward])
    force = (force - numpy.polyval(numpy.polyfit(places, force, 1), places)) * numpy.hanning(count)
    bins = 16 * count
    spectrum = numpy.log(numpy.abs(numpy.fft.rfft(force, bins)) + 1e-12)
    first = 3 * bins // count  # three periods in the stroke
    peak = first + int(spectrum[first:-1].argmax())
    left, top, right = spectrum[peak - 1:peak + 2]
    bend = left - 2 * top + right
    return length * bins / (count - 1) / (peak + (0.5 * (left - right) / bend if bend else 0.0))


def check_touched(felt, least=MIN_TOUCHING):
    if len(felt.tick) < least or not math.isfinite(float(felt.force_N.sum())):
        raise NothingFelt(f"the hand touched the surface in {len(felt.tick)} samples; {least} or more are wanted")
