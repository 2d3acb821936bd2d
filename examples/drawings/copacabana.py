#!/usr/bin/python3
"""Draws copacabana.png: the sidewalk's waves, black and white bands whose borders swing in two phases in turn.

usage: copacabana.py [OUT.png]      (needs Debian's python3-numpy and python3-pil)
"""
import sys

import numpy as np
from PIL import Image

WIDTH, HEIGHT, SAMPLES = 1024, 640, 4
WAVE, BAND, SWING, PHASE = 341.33, 80.0, 64.0, 0.4

y, x = np.mgrid[0:HEIGHT * SAMPLES, 0:WIDTH * SAMPLES].astype(np.float32)
x, y = (x + 0.5) / SAMPLES, (y + 0.5) / SAMPLES


def swing(phase):
    angle = 2 * np.pi * x / WAVE + phase
    return SWING * np.sin(angle + 0.2 * np.sin(2 * angle))


borders = swing(PHASE), swing(-PHASE)
crossed = np.zeros(x.shape, np.int32)
for k in range(-2, int(HEIGHT / BAND) + 3):
    crossed += y > k * BAND + borders[k % 2]
ink = (crossed % 2).reshape(HEIGHT, SAMPLES, WIDTH, SAMPLES).mean((1, 3))
Image.fromarray((255 * (1 - ink) + 0.5).astype(np.uint8)).save(sys.argv[1] if len(sys.argv) > 1 else "copacabana.png",
                                                               optimize=True)
