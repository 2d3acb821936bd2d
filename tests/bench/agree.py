"""One hash for labels and sites, and one for the SVG, over backends, threads and windows; exits with 1 if there are more.

usage: agree.py BUILD SCRATCH [--quick | --long] - 256 x 256 px, 2048 x 2048 px (4 Mpx), or 8192 x 8192 px (64 Mpx): that
one whole, on two threads, by the CPU and by Vulkan. The portable CPU is what test_agree.c holds against brute force."""

import hashlib
import itertools
import sys

from PIL import Image

import bench
import libpave

SIDE = 256 if bench.options.quick else 8192 if bench.options.long else 2048
STEPS = 4
BACKENDS = {"cpu-portable": 2, "cpu": 1, "vulkan-compute": 4, "vulkan-raster": 5, "gles": 6}
if bench.options.long:
    del BACKENDS["cpu-portable"], BACKENDS["gles"]
THREADS = [2] if bench.options.long else [1, 2, 7]
GRIDS = [(1, 1)] if bench.options.long else [(1, 1), (2, 2), (5, 3)]
pave, scratch = bench.options.build / "bin" / "pave", bench.options.scratch
drawing = scratch / "agree.png"
pixels = bench.waves(SIDE)
Image.fromarray(pixels).save(drawing)


def diagram(backend, threads):
    """The hash of labels and sites."""
    library = libpave.Library(bench.options.build / "lib" / "libpave.so", threads, BACKENDS[backend])
    image = library.drawing(pixels)
    field = library.field(image, 0)
    cvd = library.diagram(field, STEPS)
    digest = hashlib.sha256(library.labels(cvd)).hexdigest()
    for kind, handle in (("pave_cvd", cvd), ("pave_field", field), ("pave_image", image)):
        library.free(kind, handle)
    return digest


def cuts(count):
    return [SIDE * i // count for i in range(count + 1)]


def stones(backend, threads, columns, rows, mode):
    """The hash of the SVG, laid in windows."""
    job = [pave, "lay", drawing, "-q", "--iterations", STEPS, "--mode", mode, "--backend", backend, "--threads", threads]
    parts = []
    for (top, bottom), (left, right) in itertools.product(itertools.pairwise(cuts(rows)), itertools.pairwise(cuts(columns))):
        parts.append(scratch / f"agree-{left}-{top}.stones")
        bench.output(*job, "--window", f"{left},{top},{right - left},{bottom - top}", "-o", parts[-1])
    bench.output(pave, "merge", *parts, "-q", "-o", scratch / "agree.svg")
    return hashlib.sha256((scratch / "agree.svg").read_bytes()).hexdigest()


found = {}
for backend, threads in itertools.product(BACKENDS, THREADS):
    cases = {"labels and sites": diagram(backend, threads)}
    for grid, mode in itertools.product(GRIDS, ["paper", "best"] if threads == 2 else ["paper"]):
        cases[f"{mode} mode, SVG", grid] = stones(backend, threads, *grid, mode)
    for case, digest in cases.items():
        what = case if isinstance(case, str) else case[0]
        found.setdefault(what, {}).setdefault(digest, []).append((backend, threads, case[1] if what != case else None))
    print(f"{backend}, {threads} threads: done", file=sys.stderr, flush=True)
for what, digests in found.items():
    for digest, runs in digests.items():
        print(f"{what}, {SIDE} x {SIDE} px, {STEPS} steps: {len(runs)} runs, sha256 {digest[:16]}")
        if len(digests) > 1:
            print("   ", runs)
sys.exit(any(len(digests) > 1 for digests in found.values()))
