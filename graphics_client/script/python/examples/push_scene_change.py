"""Pushes a scene change and says from which tick on it is felt.

    push_scene_change.py [--connect HOST:PORT] [--credentials FILE] SCENE_FILE
    push_scene_change.py --stiffness 900 torus

The second form reads the object, and changes it only if nobody else did in between; else it reads again.
"""
import argparse
import sys

from haptic_client import Client, Conflict, Refused, Rejected, UploadRefused
from haptics.scene import Scene


def scene_of(file):
    try:
        return Scene.load(file)
    except OSError as error:
        sys.exit(f"push_scene_change: {file}: {error.strerror}")
    except ValueError as error:
        sys.exit(f"push_scene_change: {error}")


def set_stiffness(client, name, stiffness):
    while True:
        known = client.objects().get(name)
        if known is None:
            raise Rejected("", f'there is no object "{name}"')
        try:
            return client.apply(f'preconditions {{ object {{ id: {known.id} }} expected_revision: {known.revision} }}'
                                f'operations {{ set_material {{ object {{ id: {known.id} }} '
                                f'material {{ stiffness_N_per_m: {stiffness} }} }} }}')
        except Conflict as conflict:
            print(f"{conflict}; reading again", file=sys.stderr)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--connect", default="127.0.0.1:7654", metavar="HOST:PORT")
    parser.add_argument("--credentials", metavar="FILE")
    parser.add_argument("--stiffness", type=float, metavar="N_PER_M", help="of the object named instead of a file")
    parser.add_argument("what", metavar="SCENE_FILE")
    arguments = parser.parse_args()
    scene = scene_of(arguments.what) if arguments.stiffness is None else None
    try:
        with Client(arguments.connect, "push_scene_change", arguments.credentials) as client:
            accepted, tick = (client.apply(scene) if scene is not None else
                              set_stiffness(client, arguments.what, arguments.stiffness))
            print(f"revision {accepted.revision}, live since tick {tick}, root {accepted.root.hex()}")
    except (Refused, Rejected, Conflict, UploadRefused, ValueError) as error:
        sys.exit(f"push_scene_change: {error}")


if __name__ == "__main__":
    main()
