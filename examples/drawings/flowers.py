"""Draws flowers.png, a pattern that repeats: waves, and a flower that hangs over a corner.

    python3 flowers.py flowers.png
"""
import sys

import numpy as np
from PIL import Image

SIDE = 320

y, x = np.mgrid[:SIDE, :SIDE]
waves = np.sin(2 * np.pi * (2 * y / SIDE) + 1.2 * np.sin(2 * np.pi * x / SIDE)) > 0
dx, dy = (np.array([x - 20, y - 22]) + SIDE // 2) % SIDE - SIDE // 2
radius, angle = np.hypot(dx, dy), np.arctan2(dy, dx)
flower = (radius < 52 + 16 * np.cos(6 * angle)) & (radius > 18)
Image.fromarray((255 * (waves ^ flower)).astype(np.uint8)).convert("1").save(sys.argv[1])
