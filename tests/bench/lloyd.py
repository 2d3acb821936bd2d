"""One Lloyd step at 16k sites and 1 Mpx, against the Delaunay triangulation and dual of the same sites.

The others solve an easier problem: Euclidean distance to points, one diagram without pixels; a step of pave finds the
nearest oriented box for each pixel, and moves and turns every site."""

import shutil

import bench

SIDE = 256 if bench.options.quick else 1024
sites = bench.options.scratch / "sites.txt"
cgal, d3 = bench.options.build / "bench" / "delaunay", bench.options.build / "bench" / "delaunay.mjs"


def by_pave():
    return bench.step("--side", SIDE, "--sites", sites, "cpu:1")["engines"][0]["step_s"]


by_pave()  # writes the sites
jobs = {"pave": by_pave}
rivals = {"cgal": ("CGAL `Delaunay_triangulation_2` and dual", cgal.exists(), "not built"),
          "d3": ("d3-delaunay, triangulation and Voronoi cells",
                 (d3.parent / "node_modules" / "d3-delaunay").exists() and shutil.which("node"), "not installed")}
if rivals["cgal"][1]:
    jobs["cgal"] = lambda: float(bench.output(cgal, sites))
if rivals["d3"][1]:
    jobs["d3"] = lambda: float(bench.output("node", d3, sites, SIDE))
least = bench.in_turn(jobs, 2 if bench.options.quick else 7)

count = sum(1 for _ in sites.open())
what = f"one Lloyd step, {count} sites, {SIDE}² px, oriented boxes, 1 thread"
for name, (rival, there, why) in rivals.items():
    if there:
        bench.pair(what, least["pave"], rival, least[name], "the rival's problem is Euclidean")
    else:
        bench.skipped(what, rival, why)
bench.done("lloyd")
