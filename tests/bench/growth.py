"""How a step grows with the drawing and with the stones: ns per pixel and step, and the peak memory of `pave lay`."""

import os
import subprocess

from PIL import Image

import bench

SIDES = [256, 512] if bench.options.quick else [1024, 2048, 4096] + [8192] * bench.options.long
HALVES = [2.5, 8] if bench.options.quick else [2.5, 4, 8, 16, 32]
ROUNDS = 1 if bench.options.quick else 3


def peak(side):
    """MiB resident of a whole job."""
    drawing = bench.options.scratch / "growth.png"
    Image.fromarray(bench.waves(side)).save(drawing)
    job = subprocess.Popen([bench.options.build / "bin" / "pave", "lay", drawing, "-q", "--threads", "2", "--backend",
                            "cpu", "-o", bench.options.scratch / "growth.svg"])
    _, status, usage = os.wait4(job.pid, 0)
    job.returncode = os.waitstatus_to_exitcode(status)
    if job.returncode:
        raise SystemExit("pave lay failed")
    return usage.ru_maxrss / 1024


def cost(side, half):
    report = bench.step("--side", side, "--half-side", half, "--rounds", ROUNDS, "cpu:1")
    return 1e9 * report["engines"][0]["step_s"] / side**2


for side in SIDES:
    bench.value(f"one step, cpu, 1 thread, {side}² px, h = 4", cost(side, 4), "ns per pixel")
for half in HALVES:
    bench.value(f"one step, cpu, 1 thread, {SIDES[0]}² px, h = {half:g}", cost(SIDES[0], half), "ns per pixel")
for side in SIDES:
    bench.value(f"`pave lay`, {side}² px, h = 4, peak resident", peak(side), "MiB")
bench.done("growth")
