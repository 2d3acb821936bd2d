"""Textures: processor time by mode and size of the result, one thread, and that of a pixel, which should not grow."""

import random
import resource

from PIL import Image

import bench

pave = bench.options.build / "bin" / "pave"
exemplars = {side: bench.options.scratch / f"exemplar{side}.png" for side in (128, 512)}
random.seed(1)
for side, path in exemplars.items():
    Image.effect_noise((side // 8, side // 8), 90).resize((side, side), Image.BICUBIC).save(path)


def spent(side, size, mode):
    """CPU seconds of one run, with reading and writing files."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    bench.output(pave, "tile", exemplars[side], "--size", f"{size}x{size}", "--mode", mode, "--threads", 1, "-q", "-o",
                 bench.options.scratch / "tiling.png")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


sizes = [(128, 256)] if bench.options.quick else [(128, 256), (128, 512), (128, 1024), (512, 2048)]
for side, size in sizes:
    modes = {mode: lambda mode=mode: spent(side, size, mode)
             for mode in ("best", "fast", "paper") if size < 2048 or mode == "best"}
    least = bench.in_turn(modes | {"start": lambda: spent(side, 8, "fast")}, 3 if size == 256 else 1)
    for mode in modes:
        seconds = least[mode] - least["start"]
        bench.value(f"texture of {size}² px from {side}², mode {mode}, CPU time without starting", seconds, "s")
        bench.value("the same a pixel", seconds * 1e6 / size ** 2, "µs")
bench.done("tiling")
