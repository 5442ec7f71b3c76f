"""Psychophysical experiments on a haptic server: methods, trials, answers, a log that a crash does not tear, and results.

    EXPERIMENT = haptic_experiment.Experiment(name="stiffness_jnd", ..., stimulus=lambda stiffness: "operations { ... }")

    if __name__ == "__main__":
        haptic_experiment.main(EXPERIMENT, __doc__)

README.md beside this file shows a session; the modules' docstrings have formulas, units, errors and sources.
"""
from haptic_experiment.command_line import main  # noqa: F401
from haptic_experiment.design import Experiment, Press, Sequence, Stroke, Trial, percent_above  # noqa: F401
from haptic_experiment.felt import friction_coefficient, stiffness_N_per_m, wavelength_m  # noqa: F401
