"""Just noticeable difference of a grating's wavelength: which of two gratings is coarser?

    grating_wavelength.py --participant anna                                     a person at the device of a running server
    grating_wavelength.py --participant model --simulated --connect HOST:PORT    the server's simulated hand
    grating_wavelength.py --participant model --simulated --in-process           the same without a server
    grating_wavelength.py --participant anna --resume                            goes on where the last run ended

The reference has waves of 3 mm. A level is how much longer those of the comparison are, in percent.
"""
from haptic_experiment import Experiment, Stroke, main, percent_above, wavelength_m

PLATE = """
operations { add { name: "plate" mesh { box { size_m { x: 0.12 y: 0.06 z: 0.02 } segments: 80 } }
                   pose { position { z: -0.01 } } material { stiffness_N_per_m: 600 damping_Ns_per_m: 0 } } }
"""


def stimulus(wavelength_mm):
    return (f'operations {{ set_material {{ object {{ name: "plate" }} material {{ texture {{ amplitude_m: 0.0001 field {{ '
            f'fourier {{ terms {{ direction {{ x: 1 }} wavelength_m: {wavelength_mm / 1000:.9g} }} }} }} }} }} }} }}')


EXPERIMENT = Experiment(
    name="grating_wavelength", version=1, question="Which interval had the coarser grating?",
    level_name="wavelength above the reference", level_unit="%", value_name="wavelength", value_unit="mm",
    lowest=2, highest=50, scene=PLATE, value=percent_above(3), stimulus=stimulus,
    exploration=Stroke(place=(-0.025, 0, 0), end=(0.025, 0, 0), normal=(0, 0, 1), force_N=1, speed=0.08),
    estimate=wavelength_m)

if __name__ == "__main__":
    main(EXPERIMENT, __doc__)
