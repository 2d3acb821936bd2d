"""How a step grows with the drawing and with the stones, and the peak memory of `pave lay`."""

import shutil

from PIL import Image

import bench

SIDES = [256, 512] if bench.options.quick else [1024, 2048, 4096, 8192]
PEAKS = SIDES if bench.options.quick or bench.options.long else SIDES[:-1]
HALVES = [2.5, 8] if bench.options.quick else [2.5, 4, 8, 16, 32]
ROUNDS = 1 if bench.options.quick else 3


def peak(side):
    """MiB resident of a whole job. By time(1), for a child of this process would be charged with what this one holds."""
    drawing, said = bench.options.scratch / "growth.png", bench.options.scratch / "peak"
    Image.fromarray(bench.waves(side)).save(drawing)
    bench.output("time", "-f", "%M", "-o", said, bench.options.build / "bin" / "pave", "lay", drawing, "-q",
                 "--threads", 2, "--backend", "cpu", "-o", bench.options.scratch / "growth.svg")
    return int(said.read_text()) / 1024


def cost(side, half):
    """Of the processor: other work beside disturbs it less than the clock."""
    return bench.step("--side", side, "--half-side", half, "cpu:1")["engines"][0]["cpu_s"]


cases = [(side, 4) for side in SIDES] + [(SIDES[0], half) for half in HALVES if half != 4]
least = bench.in_turn({case: lambda case=case: cost(*case) for case in cases}, ROUNDS)
for side, half in cases:
    bench.value(f"one step, cpu, 1 thread, {side}² px, h = {half:g}", 1e9 * least[side, half] / side**2, "ns per pixel")
first, last = (least[side, 4] / side**2 for side in (SIDES[0], SIDES[-1]))
bench.value(f"a step costs per pixel at {SIDES[-1]}² px", last / first, f"times that at {SIDES[0]}² px")
for side in PEAKS if shutil.which("time") else []:
    bench.value(f"`pave lay`, {side}² px, h = 4, peak resident", peak(side), "MiB")
bench.done("growth")
