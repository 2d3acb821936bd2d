"""Sparse reconstruction of generated materials: the tables of docs/backends.md (den Brok et al. 2014, Tables 1 and 2).

    /usr/bin/python3 tests/bench/btf.py BUILD [--classes gravel,tile] [--kinds paper,best] [--texels 32]
                                              [--materials 12] [--json FILE]

Of each class so many materials are made (seeds 1, 2, ...), 81 x 81 directions; the last is tested, 24 x 24 texels of its
middle, and the others are what models are made of. One channel, luminance. Sizes follow the paper's by the number of
pairs: 441 samples (21 x 21 of a 5 x 5 map) for 1369, 330 eigen-ABRDFs for 1024, 660 eigen-ABTFs for 2048.

    /usr/bin/python3 tests/bench/btf.py BUILD --real FOLDER

projects measured mean ABRDFs (derived_*_meanlogY_151x151_f32.bin: logarithms of luminance, [view][light]) on a model of
generated materials of all nine classes, from 151 x 151 directions."""

import argparse
import json
import pathlib
import sys
import tempfile
import time

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from libpave import Library

CLASSES = ["flat", "minerals", "sawn", "polished", "tile", "grooved", "brushed", "concrete", "cobble", "asphalt", "gravel"]
WEIGHTS = numpy.float32([0.299, 0.587, 0.114])


class Laboratory(Library):
    def params(self, kind, **fields):
        params = self.ffi.new(kind + " *")
        getattr(self.c, kind + "_init")(params, self.ffi.sizeof(params[0]))
        for name, value in fields.items():
            setattr(params, name, value)
        return params

    def samples(self, btf):
        """[texel][pair][channel]"""
        c = self.c
        size = c.pave_btf_views(btf) * c.pave_btf_lights(btf) * c.pave_btf_channels(btf)
        out = numpy.empty((c.pave_btf_height(btf) * c.pave_btf_width(btf), size), numpy.float32)
        for t in range(len(out)):
            c.pave_btf_abrdf(btf, t % c.pave_btf_width(btf), t // c.pave_btf_width(btf),
                             self.ffi.from_buffer("float[]", out[t]))
        return out.reshape(len(out), -1, c.pave_btf_channels(btf))

    def grey(self, btf, side=0):
        """One channel of luminance; of `side`, a square in the middle."""
        whole = self.c.pave_btf_width(btf)
        samples = (self.samples(btf) @ WEIGHTS).reshape(whole, whole, -1)
        side = side or whole
        first = (whole - side) // 2
        samples = numpy.ascontiguousarray(samples[first:first + side, first:first + side], numpy.float32)
        return self.of_samples(samples, btf)

    def of_samples(self, samples, like):
        params = self.params("pave_btf_params", width=samples.shape[1], height=samples.shape[0], channels=1,
                             type=5, views=self.c.pave_btf_views(like), lights=self.c.pave_btf_lights(like),
                             view_directions=self.c.pave_btf_view_directions(like),
                             light_directions=self.c.pave_btf_light_directions(like))
        return self.make(self.c.pave_btf_create, "pave_btf", self.context, params,
                         self.ffi.from_buffer(samples.astype(numpy.float32)))

    def synthesize(self, name, texels, seed, directions=0):
        params = self.params("pave_btf_synthesis_params", class_of=CLASSES.index(name), texels=texels, seed=seed,
                             directions=directions)
        return self.make(self.c.pave_btf_synthesize, "pave_btf", self.context, params)

    def model(self, btfs, **fields):
        return self.make(self.c.pave_btf_model_create, "pave_btf_model", self.context,
                         self.ffi.new("pave_btf *[]", btfs), len(btfs), self.params("pave_btf_model_params", **fields))

    def plan(self, model, **fields):
        return self.make(self.c.pave_btf_plan_create, "pave_btf_plan", self.context, model,
                         self.params("pave_btf_plan_params", **fields))

    def reconstruct(self, model, btf, plan, **fields):
        out = self.ffi.new("pave_btf **")
        result = self.c.pave_btf_reconstruct(self.context, model, btf, plan or self.ffi.NULL,
                                             self.params("pave_btf_reconstruct_params", type=5, **fields), out,
                                             self.ffi.NULL)
        if result:
            raise RuntimeError(self.ffi.string(self.c.pave_context_message(self.context)).decode())
        return out[0]

    def measure(self, a, b, epsilon):
        difference = self.ffi.new("pave_btf_difference *")
        difference.size = self.ffi.sizeof(difference[0])
        params = self.params("pave_btf_measure_params", texels=0, epsilon=epsilon)
        if self.c.pave_btf_measure(self.context, a, b, params, difference):
            raise RuntimeError(self.ffi.string(self.c.pave_context_message(self.context)).decode())
        return difference

    def error(self, model, truth, plan, epsilon, **fields):
        out = self.reconstruct(model, truth, plan, **fields)
        d = self.measure(out, truth, epsilon)
        self.free("pave_btf", out)
        return 100 * d.relative


PAPER, PROJECT, ABRDFS, ABTFS = 1, 2, 1, 2
GREEDY, SWAP, MAP = 0, 1, 2
EPSILON = 0.00032
NINE = ["gravel", "tile", "grooved", "sawn", "cobble", "polished", "concrete", "asphalt", "brushed"]


def plain_model(lab, btfs):
    """The text to the letter: no copies, no prior."""
    return lab.model(btfs, components=660, abrdfs=660, material=100, stride=2, symmetric=0, validate=0)


def swap_for_patches(lab, model):
    return lab.plan(model, samples=441, method=SWAP, components=660, steps=150)


def pairs_of(lab, plan):
    return [numpy.frombuffer(lab.ffi.buffer(f(plan), 4 * 441), numpy.int32).copy()
            for f in (lab.c.pave_btf_plan_views, lab.c.pave_btf_plan_lights)]


def swapped(lab, btfs):
    model = plain_model(lab, btfs)
    plan = swap_for_patches(lab, model)
    pairs = pairs_of(lab, plan)
    lab.free("pave_btf_plan", plan)
    lab.free("pave_btf_model", model)
    return pairs


def paper(lab, btfs, truth, error):
    model = plain_model(lab, btfs)
    plans = {"map": lab.plan(model, samples=441, method=MAP), "greedy": lab.plan(model, samples=441)}
    row = {}
    for k in (82, 165, 330, 660):
        row[f"A{k}"] = error(model, None, mode=PROJECT, basis=ABRDFS, abrdfs=k)
    for k in (330, 660):
        row[f"T{k}"] = error(model, None, mode=PROJECT, basis=ABTFS, components=k)
    plans["swap"] = lab.plan(model, samples=441, method=SWAP, patches=0, abrdfs=330, steps=300)
    for name in ("map", "swap", "greedy"):
        row[f"A330 {name}"] = error(model, plans[name], mode=PAPER, basis=ABRDFS, abrdfs=330)
    row["A73 map"] = error(model, plans["map"], mode=PAPER, basis=ABRDFS, abrdfs=73)
    row["A73"] = error(model, None, mode=PROJECT, basis=ABRDFS, abrdfs=73)
    lab.free("pave_btf_plan", plans["swap"])
    plans["swap"] = swap_for_patches(lab, model)
    for name in ("map", "swap", "greedy"):
        row[f"T660 {name}"] = error(model, plans[name], mode=PAPER, basis=ABTFS, components=660)
    pairs = pairs_of(lab, plans["swap"])
    for plan in plans.values():
        lab.free("pave_btf_plan", plan)
    lab.free("pave_btf_model", model)
    own = lab.model([truth], patch=1, abrdfs=128, material=128, symmetric=0, validate=0)
    row["own 128"] = error(own, None, mode=PROJECT, basis=ABRDFS)
    lab.free("pave_btf_model", own)
    return row, pairs


def best(lab, btfs, truth, error, swap, folder):
    began = time.time()
    model = lab.model(btfs, components=1400, abrdfs=1024, material=100, stride=2)
    row = {"model seconds": time.time() - began}
    began = time.time()
    greedy = lab.plan(model, samples=441)
    row["plan seconds"] = time.time() - began
    row["A floor"] = error(model, None, mode=PROJECT, basis=ABRDFS)
    row["T floor"] = error(model, None, mode=PROJECT, basis=ABTFS)
    for k in (441, 220, 65, 16):
        row[f"A {k}"] = error(model, greedy, basis=ABRDFS, samples=k)
        row[f"T {k}"] = error(model, greedy, basis=ABTFS, samples=k)
        began = time.time()
        row[f"both {k}"] = error(model, greedy, samples=k)
        row[f"reconstruct seconds {k}"] = time.time() - began
    others = {"map": lab.plan(model, samples=441, method=MAP), "dome": lab.plan(model, samples=65, dome=1)}
    path = str(folder / "swap.csv").encode()
    (folder / "swap.csv").write_text("view,light\n" + "".join(f"{v},{l}\n" for v, l in zip(*swap)))
    others["swap"] = lab.make(lab.c.pave_btf_plan_read, "pave_btf_plan", lab.context, model, path)
    for name, plan in others.items():
        row[f"both {name}"] = error(model, plan)
        row[f"{name} samples"] = lab.c.pave_btf_plan_samples(plan)
        lab.free("pave_btf_plan", plan)
    lab.free("pave_btf_plan", greedy)
    lab.free("pave_btf_model", model)
    return row


def study(lab, name, options, folder):
    btfs = []
    for seed in range(1, options.materials + 1):
        made = lab.synthesize(name, options.texels, seed)
        btfs.append(lab.grey(made, 24 if seed == options.materials else 0))
        lab.free("pave_btf", made)
    truth = btfs.pop()
    same = lab.measure(truth, truth, EPSILON)
    row = {"whole": same.whole, "variation": same.variation}

    def error(model, plan, **fields):
        return lab.error(model, truth, plan, EPSILON, **fields)

    swap = None
    if "paper" in options.kinds:
        figures, swap = paper(lab, btfs, truth, error)
        row.update(figures)
    if "best" in options.kinds:
        row.update(best(lab, btfs, truth, error, swap or swapped(lab, btfs), folder))
    for btf in btfs + [truth]:
        lab.free("pave_btf", btf)
    return row


def real(lab, folder):
    """How far generated materials are from measured ones."""
    btfs = [lab.grey(lab.synthesize(name, 12, seed, directions=1)) for name in NINE for seed in (1, 2, 3)]
    model = lab.model(btfs, patch=1, abrdfs=1024, material=100, validate=0)
    plan = lab.plan(model, samples=1369)
    print(f"{lab.c.pave_btf_model_components(model, 0, 0)} eigen-ABRDFs of {len(btfs)} generated materials")
    for path in sorted(pathlib.Path(folder).glob("derived_*_meanlogY_151x151_f32.bin")):
        logs = numpy.fromfile(path, "<f4")
        truth = lab.of_samples(numpy.exp(logs).reshape(1, 1, -1), btfs[0])
        same = lab.measure(truth, truth, EPSILON)
        light = numpy.cos([d.theta for d in lab.ffi.unpack(lab.c.pave_btf_light_directions(truth), 151)])
        shape = logs.reshape(151, 151) - numpy.log(light)
        whole, varies = same.whole, shape.std()
        print(path.name, f"root mean square {whole:.3f}, of what differs from a grey diffuse plane {varies:.3f}")
        for k in (16, 64, 128, 330, 1024):
            error = lab.error(model, truth, None, EPSILON, mode=PROJECT, abrdfs=k) / 100 * whole
            print(f"  {k:4d} eigen-ABRDFs leave {error:.4f}: {100 * error / whole:.2f} % of all, "
                  f"{100 * error / varies:.1f} % of what differs")
        for k in (1369, 228, 40):
            error = lab.error(model, truth, plan, EPSILON, samples=k) / 100 * whole
            print(f"  {k:4d} of 22801 samples leave {error:.4f}: {100 * error / varies:.1f} % of what differs")


def table(rows, title, columns):
    print(f"\n{title}\n\n| class | " + " | ".join(columns) + " |\n|---" * 1 + "|---" * len(columns) + "|")
    for name, row in rows.items():
        print(f"| {name} | " + " | ".join(f"{row[c]:.3g}" if c in row else "" for c in columns) + " |")


def show(rows):
    table(rows, "Projection, percent", ["whole", "variation", "own 128", "A82", "A165", "A330", "A660", "T330", "T660"])
    table(rows, "Paper mode, 441 samples", ["A330", "A330 map", "A330 swap", "A330 greedy", "A73", "A73 map", "T660",
                                            "T660 map", "T660 swap", "T660 greedy"])
    table(rows, "Best mode", ["A floor", "T floor"] + [f"{of} {k}" for k in (441, 220, 65, 16) for of in ("A", "T", "both")] +
          ["both map", "both swap", "both dome", "dome samples"])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("--classes", default=",".join(NINE))
    parser.add_argument("--kinds", default="paper,best")
    parser.add_argument("--texels", type=int, default=32)
    parser.add_argument("--materials", type=int, default=12)
    parser.add_argument("--json")
    parser.add_argument("--real")
    options = parser.parse_args()
    lab = Laboratory(pathlib.Path(options.build) / "lib" / "libpave.so", 2)
    if options.real:
        return real(lab, options.real)
    rows = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in options.classes.split(","):
            began = time.time()
            rows[name] = study(lab, name, options, pathlib.Path(folder))
            rows[name]["seconds"] = time.time() - began
            print(name, {k: round(v, 3) for k, v in rows[name].items()}, flush=True)
            if options.json:
                pathlib.Path(options.json).write_text(json.dumps(rows, indent=1))
    show(rows)


if __name__ == "__main__":
    main()
