"""Holds a mosaic's measures against its bars, and against what another judge says:
mosaics.py name coverage report [judge tiles]

The judge has seen all, and only the tiles without chips."""
import json
import sys

name, coverage, report = sys.argv[1:4]
m = json.load(open(report))
least = {"coverage": float(coverage), "corners4": 0.98, "sizes_met": 0.9}
most = {"overlap": 0, "squareness": 15, "field_angle": 7, "edge_angle": 6, "straddlers": 0.07, "delta_e": 0.3,
        "lost": 0.01 * m["tiles"], "coverage": 1 + 1e-9}
if m["parameters"]["mosaic"]["size_from"] == "even":
    most["side_cv"] = 0.2
bad = [f"{k} is {m[k]:.4g}, not {v:.4g}" for k, v in least.items() if not m[k] >= v]
bad += [f"{k} is {m[k]:.4g}, not {v:.4g}" for k, v in most.items() if not m[k] <= v]
if len(sys.argv) > 4:
    both, other = (json.load(open(name)) for name in sys.argv[4:6])
    other.update(coverage=both["coverage"], overlap=both["overlap"], invalid=both["invalid"])
    bad += [f"{k} is {m[k]:.6g}, but the judge says {other[k]:.6g}"
            for k in ("coverage", "corners4", "squareness", "aspect", "side_cv", "delta_e", "delta_e_p95", "overlap", "tiles")
            if not abs(m[k] - other[k]) <= 1e-4 * (abs(other[k]) if k[0] == "d" else 1e-3)]
    bad += [f"{other['invalid']} tiles are not simple"] * (other["invalid"] > 0)
    m["within"] = other["within"] / other["within_grid"]
print(name, *(f"{k} {m[k]:.4g}" for k in ("coverage", "corners4", "squareness", "aspect", "field_angle", "edge_angle",
                                          "straddlers", "lost", "sizes_met", "within") if k in m), *bad, sep="; ")
sys.exit(bool(bad))
