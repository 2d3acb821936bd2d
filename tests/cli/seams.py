"""Judges a periodic pavement by its files: seams.py wrapped.svg cut.svg tessellation.svg picture.png open.svg

The stones of wrapped.svg and cut.svg must be the same; the joints of tessellation.svg (no grout, no corner dropped)
must continue over the border, those of open.svg, of a plane with borders, must not; the rows and columns of the picture beside the border must look like all others."""
import re
import sys
from collections import Counter

import numpy as np
from PIL import Image


def load(path):
    text = open(path).read()
    width, height = map(int, re.search(r'viewBox="0 0 (\d+) (\d+)"', text).groups())
    stones = {}
    for match in re.finditer(r'<polygon id="s(\d+)(?:-\d+)?" points="([^"]*)"', text):
        ring = [tuple(round(1000 * float(v)) for v in p.split(",")) for p in match[2].split()]
        stones.setdefault(int(match[1]), []).append(ring)
    return 1000 * width, 1000 * height, stones


def double_area(ring):
    return sum(b[0] * a[1] - a[0] * b[1] for a, b in zip(ring, ring[1:] + ring[:1]))


def shifts(width, height, ring, most=0):
    """The ways by which a ring's copies come to meet the first period, or to lie at most so far beside it."""
    xs, ys = [p[0] for p in ring], [p[1] for p in ring]
    return [(x * width, y * height) for x in range(-3, 4) for y in range(-3, 4)
            if max(xs) + x * width > -most and min(xs) + x * width < width + most
            and max(ys) + y * height > -most and min(ys) + y * height < height + most]


def judge_cut(wrapped, cut):
    width, height, whole = wrapped
    crossing = 0
    assert set(whole) == set(cut[2])
    for name, parts in cut[2].items():
        ring = whole[name][0]
        crossing += len(parts) > 1
        for part in parts:
            assert all(0 <= x <= width and 0 <= y <= height for x, y in part), name
            assert double_area(part) > 0, name
        loss = double_area(ring) - sum(map(double_area, parts))
        assert abs(loss) < 20000 * len(parts), (name, loss)
        assert len(parts) > 1 or len(shifts(width, height, ring)) == 1 or abs(loss) > 0, name
    assert crossing > 8, crossing
    return crossing


def judge_joints(tessellation):
    """Each side of a stone is a side of its neighbour, run through the other way. A stone that crosses the border must
    find as many of its sides again as an inner one: all, but where the text makes cells cross each other."""
    width, height, stones = tessellation
    rings = {name: parts[0] for name, parts in stones.items()}
    sides = Counter()
    for ring in rings.values():
        for dx in (-width, 0, width):
            for dy in (-height, 0, height):
                moved = [(x + dx, y + dy) for x, y in ring]
                sides.update(zip(moved, moved[1:] + moved[:1]))
    found = {True: [0, 0], False: [0, 0]}
    for ring in rings.values():
        crosses = len(shifts(width, height, ring, 1)) > 1 # or ends there
        for a, b in zip(ring, ring[1:] + ring[:1]):
            found[crosses][0] += 1
            found[crosses][1] += sides[b, a] == 1
    inner, border = (found[k][1] / found[k][0] for k in (False, True))
    spread = (inner * (1 - inner) / found[True][0]) ** 0.5
    assert found[True][0] > 100 and inner > 0.9, found
    return inner, border, border > inner - 3 * spread


def judge_picture(path):
    picture = np.asarray(Image.open(path).convert("RGB")).astype(float)
    for axis in (0, 1):
        steps = np.abs(picture - np.roll(picture, 1, axis)).mean(axis=(1 - axis, 2)) # [0]: over the border
        deviation = (steps[0] - steps[1:].mean()) / steps[1:].std()
        assert abs(deviation) < 3.5, (axis, deviation)
        levels = picture.mean(axis=(1 - axis, 2))
        jump = abs(levels[0] - levels[-1]) / np.abs(np.diff(levels)).max()
        assert jump <= 1, (axis, jump)


wrapped, cut, tessellation = map(load, sys.argv[1:4])
crossing = judge_cut(wrapped, cut)
inner, border, continues = judge_joints(tessellation)
assert continues, (inner, border)
assert not judge_joints(load(sys.argv[5]))[2], "an open plane passes as periodic"
judge_picture(sys.argv[4])
print(f"{crossing} stones cross the border; sides found again: {inner:.4f} inside, {border:.4f} on the border")
