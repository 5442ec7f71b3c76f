"""Writes what the hand feels to a CSV file (or standard output) until --seconds are over or Ctrl-C.

    stream_forces.py --seconds 10 --rate 1000 --out forces.csv
"""
import argparse
import csv
import sys

from haptic_client import Client, Refused
from haptic_text import printable

COLUMNS = ["tick", "time_s", "object", "hip_x_m", "hip_y_m", "hip_z_m", "penetration_m", "force_x_N", "force_y_N",
           "force_z_N", "scene_revision"]


def row(sample, start_ns, names):
    hip, force = sample.hip, sample.force.written
    return [sample.tick, f"{(sample.time_ns - start_ns) * 1e-9:.6f}", names.get(sample.object, ""), hip.x, hip.y, hip.z,
            sample.penetration_m, force.x, force.y, force.z, sample.scene_revision]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--connect", default="127.0.0.1:7654", metavar="HOST:PORT")
    parser.add_argument("--credentials", metavar="FILE")
    parser.add_argument("--rate", type=float, default=1000, metavar="HZ", help="samples a second at most (1000)")
    parser.add_argument("--seconds", type=float, metavar="S")
    parser.add_argument("--out", type=argparse.FileType("w"), default=sys.stdout, metavar="FILE")
    arguments = parser.parse_args()
    try:
        with arguments.out, Client(arguments.connect, "stream_forces", arguments.credentials, arguments.rate) as client:
            writer = csv.writer(arguments.out)
            writer.writerow(COLUMNS)
            start_ns, written = None, 0
            for sample in client.samples(arguments.seconds):
                start_ns = sample.time_ns if start_ns is None else start_ns
                writer.writerow(row(sample, start_ns, {state.id: printable(name) for name, state in client.objects().items()}))
                first, last, written = (first if written else sample), sample, written + 1
            if written:
                print(f"{written} of {last.tick - first.tick + 1} ticks; the servo missed "
                      f"{last.missed_ticks - first.missed_ticks}, others were not sent or came too late; "
                      "hapticctl watch --every-tick leaves none out", file=sys.stderr)
    except Refused as error:
        sys.exit(f"stream_forces: {error}")
    except KeyboardInterrupt:
        pass  # the file is whole up to here


if __name__ == "__main__":
    main()
