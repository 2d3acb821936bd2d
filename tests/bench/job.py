"""The whole job, from a drawing in PNG to stones in SVG, against a mosaic filter that makes another PNG."""

import os
import shutil

from PIL import Image

import bench

SIDE = 512 if bench.options.quick else 1024
pave = bench.options.build / "bin" / "pave"
drawing = bench.options.scratch / "drawing.png"
Image.fromarray(bench.waves(SIDE)).save(drawing)
os.environ["GEGL_THREADS"] = "2"


def by_pave():
    bench.output(pave, "lay", drawing, "-o", bench.options.scratch / "stones.svg", "--threads", 2, "--backend", "cpu", "-q")


def by_gegl(*operation):
    bench.output("gegl", drawing, "-o", bench.options.scratch / "mosaic.png", "--", *operation)


jobs = {"pave": by_pave}
if shutil.which("gegl"):
    jobs["gegl"] = lambda: by_gegl("gegl:mosaic", "tile-size=8", "tile-type=squares")
    jobs["nothing"] = lambda: by_gegl("gegl:nop")
least = bench.in_turn(jobs, 1 if bench.options.quick else 5)

what = f"PNG to stones in SVG, {SIDE}² px, 20 steps, 2 threads"
if "gegl" in least:
    bench.pair(what, least["pave"], "`gegl:mosaic` of the same drawing, PNG to PNG", least["gegl"])
    bench.pair(what, least["pave"], "the same without the time of `gegl:nop`", least["gegl"] - least["nothing"])
else:
    bench.skipped(what, "`gegl:mosaic`", "not installed")
bench.done("job")
