"""Digital stones: time by size, best mode against the paper's, and the time of a voxel, which should not grow."""

import random

from PIL import Image

import bench

sizes = (16, 24) if bench.options.quick else (32, 64, 128)
pave = bench.options.build / "bin" / "pave"
sample = bench.options.scratch / "sample.png"
random.seed(1)
image = Image.effect_noise((128, 128), 60)
image.save(sample)


def stone(side, mode):
    bench.output(pave, "solid", sample, "--size", f"{side},{side},{side}", "--mode", mode, "--threads", 2, "-q", "-o",
                 bench.options.scratch / "stone.nrrd")


for side in sizes:
    jobs = {"best": lambda: stone(side, "best")}
    if side < 128:
        jobs["paper"] = lambda: stone(side, "paper")
    least = bench.in_turn(jobs, 1 if bench.options.quick or side > 64 else 3)
    what = f"stone of {side}³ voxels from 128² px, {least['best'] * 1e6 / side ** 3:.1f} µs a voxel"
    if "paper" in least:
        bench.pair(what, least["best"], "the paper's mode", least["paper"])
    else:
        bench.skipped(what + f", {least['best']:.1f} s", "the paper's mode", "too slow")
bench.done("solid")
