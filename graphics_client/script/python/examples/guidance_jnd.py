"""Just noticeable difference of guidance: which of two guides along a line holds the hand more firmly?

    guidance_jnd.py --participant anna                                     a person at the device of a running server
    guidance_jnd.py --participant model --simulated --connect HOST:PORT    the server's simulated hand, with a Weber fraction
    guidance_jnd.py --participant model --simulated --in-process           the same without a server, faster than real time
    guidance_jnd.py --participant anna --resume                            goes on where the last run ended

The line lies on a plate. The reference has 200 N/m, as the guide of trace_letter.scene. A level is how much stiffer the comparison is,
in percent: what fades in smaller steps fades without being noticed.
"""
import numpy

from haptic_experiment import Experiment, Stroke, main, percent_above
from haptic_experiment.felt import check_touched

PLATE = """
operations { add { name: "plate" mesh { box { size_m { x: 0.12 y: 0.06 z: 0.02 } segments: 4 } }
                   pose { position { z: -0.01 } } material { stiffness_N_per_m: 600 damping_Ns_per_m: 0 } } }
"""


def stimulus(stiffness):
    return (f'operations {{ set_effects {{ object {{ name: "plate" }} effects {{ kind: EFFECT_KIND_GUIDE '
            f'path_m: [-0.04, 0, 0.01, 0.04, 0, 0.01] stiffness_N_per_m: {stiffness:.9g} reach_m: 0.008 }} }} }}')


def guidance_N_per_m(felt):
    """Mean force across the line over the mean distance from it."""
    check_touched(felt)
    return float(numpy.abs(felt.force_N[:, 1]).mean() / numpy.abs(felt.hip_m[:, 1]).mean())


EXPERIMENT = Experiment(
    name="guidance_jnd", version=1, question="Which interval held you more firmly?",
    level_name="stiffness above the reference", level_unit="%", value_name="stiffness of the guide", value_unit="N/m",
    lowest=2, highest=50, scene=PLATE, value=percent_above(200), stimulus=stimulus,
    exploration=Stroke(place=(-0.02, 0.004, 0), end=(0.02, 0.004, 0), normal=(0, 0, 1), force_N=1.5, speed=0.1),
    estimate=guidance_N_per_m)

if __name__ == "__main__":
    main(EXPERIMENT, __doc__)
