"""Sparse reconstruction of generated materials: the tables of docs/backends.md.

    python3 tests/bench/btf.py BUILD [--classes gravel,tile] [--texels 48] [--materials 12] [--json FILE]

Of each class so many materials are made (seeds 1, 2, ...); the last is tested, the others are the model's. One channel,
log luminance. Errors are over the whole of the tested texels; a crop in the middle is looked at."""

import argparse
import json
import pathlib
import sys
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
