#!/usr/bin/env python3
"""Draws sprinkles.png, the height map of the doughnut: rounded sprinkles in random directions, none on another, on a tile
that repeats. 16 bits a sample, black the glaze, white the top of a sprinkle.

  deploy/scenes/make_sprinkles.py deploy/scenes/sprinkles.png
"""
import math
import random
import struct
import sys
import zlib

SIDE = 256  # samples
SPRINKLES = 30
HALF_LENGTH, RADIUS = 22.0, 9.0  # samples; of the middle line, and around it
CLEARANCE = 4.0  # samples between two
SEED = 8
WHITE = 65535


def wrapped(difference):
    """The shortest way on the tile, which repeats."""
    return (difference + SIDE / 2) % SIDE - SIDE / 2


def distance(sprinkle, x, y):
    """From a sprinkle's middle line."""
    centre_x, centre_y, direction_x, direction_y = sprinkle
    across_x, across_y = wrapped(x - centre_x), wrapped(y - centre_y)
    along = max(-HALF_LENGTH, min(HALF_LENGTH, across_x * direction_x + across_y * direction_y))
    return math.hypot(across_x - along * direction_x, across_y - along * direction_y)


def clear_of(one, others):
    ends = [(one[0] + s * one[2], one[1] + s * one[3]) for s in (-HALF_LENGTH, -HALF_LENGTH / 2, 0, HALF_LENGTH / 2, HALF_LENGTH)]
    return all(distance(other, x, y) > 2 * RADIUS + CLEARANCE for other in others for x, y in ends)


def scattered():
    chance, sprinkles = random.Random(SEED), []
    for _ in range(20000):
        angle = chance.uniform(0, math.pi)
        one = chance.uniform(0, SIDE), chance.uniform(0, SIDE), math.cos(angle), math.sin(angle)
        if len(sprinkles) < SPRINKLES and clear_of(one, sprinkles):
            sprinkles.append(one)
    return sprinkles


def height(sprinkles, x, y):
    """(1 - r^2)^2 over each sprinkle: smooth where it meets the glaze."""
    r = min(distance(sprinkle, x, y) for sprinkle in sprinkles) / RADIUS
    return (1 - r * r) ** 2 if r < 1 else 0.0


def png(rows):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", SIDE, SIDE, 16, 0, 0, 0, 0)
    data = b"".join(b"\0" + struct.pack(f">{SIDE}H", *row) for row in rows)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(data, 9)) + chunk(b"IEND", b"")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sprinkles = scattered()
    rows = [[round(WHITE * height(sprinkles, x, y)) for x in range(SIDE)] for y in range(SIDE)]
    with open(sys.argv[1], "wb") as file:
        file.write(png(rows))


if __name__ == "__main__":
    main()
