"""Just noticeable difference of stiffness: which of two plates is stiffer?

    stiffness_jnd.py --participant anna                                     a person at the device of a running server
    stiffness_jnd.py --participant model --simulated --connect HOST:PORT    the server's simulated hand, with a Weber fraction
    stiffness_jnd.py --participant model --simulated --in-process           the same without a server, faster than real time
    stiffness_jnd.py --participant anna --resume                            goes on where the last run ended

The reference has 600 N/m. A level is how much stiffer the comparison is, in percent.
"""
from haptic_experiment import Experiment, Press, main, percent_above, stiffness_N_per_m

PLATE = """
operations { add { name: "plate" mesh { box { size_m { x: 0.12 y: 0.06 z: 0.02 } segments: 4 } }
                   pose { position { z: -0.01 } } material { stiffness_N_per_m: 600 damping_Ns_per_m: 0 } } }
"""


def stimulus(stiffness):
    return f'operations {{ set_material {{ object {{ name: "plate" }} material {{ stiffness_N_per_m: {stiffness:.9g} }} }} }}'


EXPERIMENT = Experiment(
    name="stiffness_jnd", version=1, question="Which interval was stiffer?",
    level_name="stiffness above the reference", level_unit="%", value_name="stiffness", value_unit="N/m",
    lowest=2, highest=50, scene=PLATE, value=percent_above(600), stimulus=stimulus,
    exploration=Press(place=(0, 0, 0), normal=(0, 0, 1), force_N=1.5, seconds=0.3), estimate=stiffness_N_per_m)

if __name__ == "__main__":
    main(EXPERIMENT, __doc__)
