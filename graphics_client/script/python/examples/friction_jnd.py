"""Just noticeable difference of friction: which of two plates has more friction?

    friction_jnd.py --participant anna                                     a person at the device of a running server
    friction_jnd.py --participant model --simulated --connect HOST:PORT    the server's simulated hand, with a Weber fraction
    friction_jnd.py --participant model --simulated --in-process           the same without a server, faster than real time
    friction_jnd.py --participant anna --resume                            goes on where the last run ended

The reference has the coefficient 0.4. A level is how much more friction the comparison has, in percent.
"""
from haptic_experiment import Experiment, Stroke, friction_coefficient, main, percent_above

PLATE = """
operations { add { name: "plate" mesh { box { size_m { x: 0.12 y: 0.06 z: 0.02 } segments: 4 } }
                   pose { position { z: -0.01 } } material { stiffness_N_per_m: 600 damping_Ns_per_m: 0 } } }
"""


def stimulus(coefficient):
    return (f'operations {{ set_material {{ object {{ name: "plate" }} material {{ friction {{ '
            f'mu_static: {coefficient:.9g} mu_dynamic: {coefficient:.9g} }} }} }} }}')


EXPERIMENT = Experiment(
    name="friction_jnd", version=1, question="Which interval had more friction?",
    level_name="friction above the reference", level_unit="%", value_name="coefficient of friction", value_unit="1",
    lowest=2, highest=50, scene=PLATE, value=percent_above(0.4), stimulus=stimulus,
    exploration=Stroke(place=(-0.02, 0, 0), end=(0.02, 0, 0), normal=(0, 0, 1), force_N=1.5, speed=0.1),
    estimate=friction_coefficient)

if __name__ == "__main__":
    main(EXPERIMENT, __doc__)
