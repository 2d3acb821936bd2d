"""Shows a pavement from above in the sun, from the maps that pave maps wrote:

    python3 render.py FOLDER PICTURE.png [AZIMUTH ELEVATION]

Sun with shadows, sky by the occlusion map, a dull gloss by the roughness map. Needs numpy and Pillow."""
import json
import math
import os
import sys

import numpy as np
from PIL import Image

folder, picture = sys.argv[1:3]
azimuth, elevation = (float(v) for v in (sys.argv[3:5] or (135, 38)))
about = json.load(open(os.path.join(folder, "maps.json")))
scale = about["maps"]["scale"]


def load(name, full):
    return np.asarray(Image.open(os.path.join(folder, about["files"][name]))).astype(np.float32) / full


def linear(v):
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


def display(v):
    return np.where(v <= 0.0031308, 12.92 * v, 1.055 * np.clip(v, 1e-9, None) ** (1 / 2.4) - 0.055)


colour, occlusion, roughness = linear(load("colour", 255)), load("occlusion", 255), load("roughness", 255)
low, high = about["height_lowest"], about["height_highest"]
height = (low + (high - low) * load("height", 65535)) * scale  # px of the maps
slope = np.gradient(height)
normal = np.dstack([-slope[1], slope[0], np.ones_like(height)])
normal /= np.linalg.norm(normal, axis=2, keepdims=True)

a, e = math.radians(azimuth), math.radians(elevation)
sun = np.array([math.cos(a) * math.cos(e), math.sin(a) * math.cos(e), math.sin(e)])  # x right, y up, z towards us
shadow = np.ones_like(height)
reach = int((height.max() - height.min()) / math.tan(e)) + 2
for step in range(1, reach):  # how far a point's ray to the sun passes over what is there, softly
    dx, dy = round(step * math.cos(a)), -round(step * math.sin(a))
    ahead = np.roll(height, (-dy, -dx), (0, 1))
    clear = height + math.hypot(dx, dy) * math.tan(e) - ahead
    shadow = np.minimum(shadow, np.clip(0.5 + clear / 1.5, 0, 1))

lambert = np.clip(normal @ sun, 0, None) * shadow
half = (sun + [0, 0, 1]) / np.linalg.norm(sun + [0, 0, 1])
power = 2 / np.clip(roughness, 0.2, 1) ** 4
gloss = np.clip(normal @ half, 0, 1) ** power * (power + 2) / 8 * 0.04 * shadow
warm, cool = np.array([1.0, 0.93, 0.82]), np.array([0.75, 0.87, 1.0])
light = colour * (2.0 * lambert[..., None] * warm + 0.55 * occlusion[..., None] * cool) + (2 * gloss * lambert)[..., None]
Image.fromarray((np.clip(display(light * 0.5), 0, 1) * 255 + 0.5).astype(np.uint8)).save(picture)
