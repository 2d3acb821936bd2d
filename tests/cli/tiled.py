"""Judges a periodic pavement of best mode without joints: tiled.py pave drawing.pgm wrapped.svg cut.svg

The stones, three by three times, must not overlap, and leave next to no holes in the middle; those that are cut must
have the area of those that are whole."""
import json
import re
import subprocess
import sys

import numpy as np
from PIL import Image

pave, drawing, wrapped, cut = sys.argv[1:]


def load(path):
    text = open(path).read()
    return [np.array([[float(v) for v in p.split(",")] for p in points.split()])
            for points in re.findall(r'<polygon[^>]*points="([^"]*)"', text)]


def area(ring):
    x, y = ring.T
    return (np.roll(x, -1) * y - x * np.roll(y, -1)).sum() / 2


image = np.asarray(Image.open(drawing).convert("L"))
height, width = image.shape
stones, parts = load(wrapped), load(cut)
Image.fromarray(np.tile(image, (3, 3))).save("tiled.png")
with open("tiled.svg", "w") as file:
    file.write(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {3 * width} {3 * height}">\n')
    for dy in range(3):
        for dx in range(3):
            for ring in stones:
                points = " ".join(f"{x:.3f},{y:.3f}" for x, y in ring + (dx * width, dy * height))
                file.write(f'<polygon fill="#000000" points="{points}"/>\n')
    file.write("</svg>\n")
m = json.loads(subprocess.check_output([pave, "measure", "tiled.png", "tiled.svg", "--json"]))
whole, pieces = sum(map(area, stones)), sum(map(area, parts))
assert m["overlap"] == 0 and m["overlapping"] == 0 and m["invalid"] == 0, m
assert whole > 0.993 * width * height, whole / width / height
assert abs(whole - pieces) < 0.02 * len(parts) and len(parts) > len(stones) + 30, (whole, pieces)
print(f"best mode: {len(stones)} stones, {len(parts)} when cut, {100 * whole / width / height:.2f} % covered")
