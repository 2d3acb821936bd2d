"""The distance field of a drawing, against OpenCV and SciPy."""

import numpy

import bench
from libpave import Library

SIDE = 1024 if bench.options.quick else 4096
THREADS = 2
drawing = bench.waves(SIDE)
pave = Library(bench.options.build / "lib" / "libpave.so", THREADS)
image = pave.drawing(drawing)


def edges():
    """The pixels beside an edge are 0: what the others measure the distance to, made before the clock starts."""
    clear = numpy.full_like(drawing, 1)
    for a, b in ((numpy.s_[1:, :], numpy.s_[:-1, :]), (numpy.s_[:, 1:], numpy.s_[:, :-1])):
        differs = drawing[a] != drawing[b]
        clear[a][differs] = 0
        clear[b][differs] = 0
    return clear


def by_pave(metric):
    pave.free("pave_field", pave.field(image, metric))


target = edges()
jobs = {"chamfer": lambda: by_pave(0), "euclid": lambda: by_pave(1)}
if bench.available("cv2"):
    import cv2
    cv2.setNumThreads(THREADS)

    def opencv():
        cv2.distanceTransform(target, cv2.DIST_L2, 3)

    jobs["opencv"] = opencv
if bench.available("scipy"):
    from scipy import ndimage

    def scipy():
        ndimage.distance_transform_edt(target)

    jobs["scipy"] = scipy
least = bench.in_turn(jobs, 2 if bench.options.quick else 9)

size = f"{SIDE}² px, {THREADS} threads"
for metric, name, rival in (("chamfer", "opencv", "OpenCV `distanceTransform(DIST_L2, 3)`"),
                            ("chamfer", "scipy", "SciPy `distance_transform_edt` (exact)"),
                            ("euclid", "scipy", "SciPy `distance_transform_edt`")):
    what = f"distance field, {metric}, {size}"
    if name in least:
        bench.pair(what, least[metric], rival, least[name])
    else:
        bench.skipped(what, rival, "not installed")
bench.done("field")
