"""A session's results: CSV, HDF5, figure, report. All are made from the log alone, and say where a participant is simulated."""
import csv
import json
from pathlib import Path

from haptic_experiment.participants import SIMULATED
from haptic_experiment.psychometric import NoThreshold, fit

# Name, unit ("" of none), what it is, and where it stands in an event "answer".
INTERVAL = (("first_tick", "", "first servo tick of contact"), ("last_tick", "", "last servo tick of contact"),
            ("contact_s", "s", "time in contact"), ("normal_force_N", "N", "mean force along the surface's normal, in contact"),
            ("peak_force_N", "N", "largest force"))


class Results:
    """header and answers: of the log (trial_log.read()). `fit` is a psychometric.Fit, or None: then `why` says why."""

    def __init__(self, header, answers):
        self.header, self.answers, self.definition = header, answers, header["definition"]
        self.unit = self.definition["level_unit"]
        self.fit, self.why = None, ""
        try:
            self.fit = fit([(answer["level"], answer["correct"]) for answer in answers])
        except NoThreshold as error:
            self.why = str(error)

    @property
    def simulated(self):
        """SIMULATED, or "" of a person."""
        return SIMULATED if self.header["simulated"] else ""

    @property
    def threshold_words(self):
        """With unit and interval; where there is no threshold, why."""
        if not self.fit:
            return f"no threshold: {self.why}"
        return (f"threshold (75 % correct) {self.fit.threshold:.3g} {self.unit}, 95 % interval {self.fit.low:.3g} to "
                f"{self.fit.high:.3g} {self.unit}, of {len(self.answers)} trials")

    def columns(self):
        """[(name, unit, description, values)] of the trial table."""
        given = self.definition
        found = [("trial", "", "number, from 1", "trial"), ("level", self.unit, given["level_name"], "level"),
                 ("staircase", "", "number of the staircase that asked", "staircase"),
                 ("comparison_interval", "", "interval, 1 or 2, of the comparison", "order"),
                 ("reference_value", given["value_unit"], f"{given['value_name']} of the reference", "reference_value"),
                 ("comparison_value", given["value_unit"], f"{given['value_name']} of the comparison", "comparison_value"),
                 ("answer", "", "interval, 1 or 2, that was chosen", "answer"), ("correct", "", "1: the comparison's", "correct"),
                 ("seconds", "s", "from the first interval to the answer", "seconds")]
        columns = [(name, unit, description, [answer[key] for answer in self.answers]) for name, unit, description, key in found]
        for interval in (1, 2):
            columns += [(f"interval_{interval}_{name}", unit, f"interval {interval}: {description}",
                         [answer["intervals"][interval - 1][name] for answer in self.answers])
                        for name, unit, description in INTERVAL]
        return columns

    def write(self, stem):
        """stem.csv, .h5, .png, .svg and .md; the names of the files."""
        from haptic_experiment.figure import draw_figure
        self._write_csv(f"{stem}.csv")
        self._write_hdf5(f"{stem}.h5")
        draw_figure(self, [f"{stem}.png", f"{stem}.svg"])
        Path(f"{stem}.md").write_text(self.report(Path(stem).name), encoding="utf-8")
        return [f"{stem}.{kind}" for kind in ("csv", "h5", "png", "svg", "md")]

    def _write_csv(self, path):
        columns = self.columns()
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            names = [f"{name} ({unit})" if unit else name for name, unit, _, _ in columns]
            writer.writerow([*names, "participant", "simulated"])
            for row in zip(*(values for *_, values in columns)):
                values = [int(value) if isinstance(value, bool) else value for value in row]
                writer.writerow([*values, self.header["participant"], self.simulated])

    def _write_hdf5(self, path):
        import h5py
        import numpy
        with h5py.File(path, "w") as file:
            attributes = {**{key: self.header[key] for key in ("experiment", "participant", "seed", "device", "server", "started")},
                          "simulated": self.simulated, "recording": self.header.get("recording") or "",
                          "definition": json.dumps(self.definition), "result": self.threshold_words}
            file.attrs.update(attributes)
            trials = file.create_group("trials")
            for name, unit, description, values in self.columns():
                column = numpy.array(values)
                trials[name] = column.astype(numpy.int8) if column.dtype == bool else column
                trials[name].attrs.update({"units": unit or "1", "description": description})
            if self.fit:
                fitted = file.create_group("fit")
                fitted.attrs.update({"family": self.fit.family, "guess_rate": 0.5, "lapse_rate": self.fit.lapse_rate})
                for name, value, unit in (("threshold", self.fit.threshold, self.unit), ("low", self.fit.low, self.unit),
                                          ("high", self.fit.high, self.unit), ("slope", self.fit.slope, "1")):
                    fitted[name] = value
                    fitted[name].attrs["units"] = unit

    def report(self, name):
        """Markdown, of a session whose files have this stem."""
        header, given = self.header, self.definition
        rows = [("Experiment", f"{header['experiment']}, version {given['version']}, definition {header['definition_sha256']}"),
                ("Participant", f"{header['participant']}{', **' + self.simulated + '**' if self.simulated else ''}"),
                ("Device", header["device"]), ("Server", header["server"]), ("Started", header["started"]),
                ("Seed", header["seed"]), ("Method", described(given["method"])),
                ("Question", given["question"]), ("Level", f"{given['level_name']}, {self.unit}"),
                ("Trials", f"{len(self.answers)}, {sum(answer['correct'] for answer in self.answers)} correct"),
                ("Recording", header.get("recording") or "none")]
        lines = [f"# {header['experiment']}, {header['participant']}", ""]
        if self.simulated:
            lines += [f"**{SIMULATED}.** No person took part. Its Weber fraction is {header['simulated']['weber_fraction']:g}, "
                      f"which implies a threshold of {header['simulated']['true_threshold_percent']:.3g} %.", ""]
        lines += ["| | |", "| --- | --- |", *(f"| {key} | {value} |" for key, value in rows), "",
                  self.threshold_words[0].upper() + self.threshold_words[1:] + ".", "", *self._fit_lines(),
                  f"![Proportion correct against level, and the levels trial by trial]({name}.png)", "",
                  *self._table_lines()]
        return "\n".join(lines) + "\n"

    def _fit_lines(self):
        if not self.fit:
            return []
        return [f"Fit: {self.fit.family} in log10(level), guess rate 0.5, lapse rate {self.fit.lapse_rate:.3f}, slope "
                f"{self.fit.slope:.3g}, deviance {self.fit.deviance:.3g}. The interval is that of the profile likelihood.", ""]

    def _table_lines(self):
        from haptic_experiment.psychometric import tally
        levels, n, right = tally([(answer["level"], answer["correct"]) for answer in self.answers])
        return [f"| level ({self.unit}) | trials | correct |", "| --- | --- | --- |",
                *(f"| {level:g} | {int(count)} | {int(correct)} |" for level, count, correct in zip(levels, n, right))]


def described(method):
    """In a line."""
    parts = method.get("staircases")
    if parts:
        return f"{method['method']}: {len(parts)} of " + described({**parts[0], "start": [part["start"] for part in parts],
                                                                    "trials": [part["trials"] for part in parts]})
    return f"{method['method']}, " + ", ".join(f"{key} {value}" for key, value in method.items() if key != "method")

