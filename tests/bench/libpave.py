"""The library through cffi: what the benchmarks call in their own process."""

import pathlib
import subprocess
import tempfile

import cffi
import numpy

INCLUDE = pathlib.Path(__file__).resolve().parents[2] / "include"


def declarations():
    with tempfile.TemporaryDirectory() as empty:
        for name in ("stddef.h", "stdint.h"):  # cffi knows the fixed-width types
            (pathlib.Path(empty) / name).write_text("")
        command = ["cc", "-E", "-P", "-nostdinc", "-I", empty, "-I", INCLUDE, INCLUDE / "pave" / "pave.h"]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout


class Library:
    def __init__(self, path, threads, backend=0, most=0):
        """`most`: bytes that may be held, unless 0."""
        self.ffi = cffi.FFI()
        self.ffi.cdef(declarations())
        self.c = self.ffi.dlopen(str(path))
        params = self.ffi.new("pave_context_params *")
        self.c.pave_context_params_init(params, self.ffi.sizeof(params[0]))
        params.threads, params.backend = threads, backend
        limits = self.ffi.new("pave_limits *")
        self.c.pave_limits_init(limits, self.ffi.sizeof(limits[0]))
        limits.max_bytes = most or limits.max_bytes
        params.limits = limits
        self.context = self.make(self.c.pave_context_create, "pave_context", params)

    def make(self, create, kind, *arguments):
        """Calls a function whose last argument takes the new handle."""
        out = self.ffi.new(kind + " **")
        result = create(*arguments, out)
        if result:
            raise RuntimeError(f"{kind}: {self.ffi.string(self.c.pave_result_name(result)).decode()}")
        return out[0]

    def free(self, kind, handle):
        getattr(self.c, kind + "_free")(self.ffi.new(kind + " **", handle))

    def drawing(self, pixels):
        params = self.ffi.new("pave_image_params *")
        self.c.pave_image_params_init(params, self.ffi.sizeof(params[0]))
        params.height, params.width = pixels.shape
        return self.make(self.c.pave_image_create, "pave_image", self.context, params,
                         self.ffi.from_buffer(numpy.ascontiguousarray(pixels)))

    def field(self, drawing, metric):
        params = self.ffi.new("pave_field_params *")
        self.c.pave_field_params_init(params, self.ffi.sizeof(params[0]))
        params.metric = metric
        return self.make(self.c.pave_field_create, "pave_field", self.context, drawing, params)

    def distances(self, field, shape):
        data = self.ffi.buffer(self.c.pave_field_distance(field), 4 * shape[0] * shape[1])
        return numpy.frombuffer(data, numpy.float32).reshape(shape).copy()

    def diagram(self, field, iterations):
        params = self.ffi.new("pave_cvd_params *")
        self.c.pave_cvd_params_init(params, self.ffi.sizeof(params[0]))
        params.iterations = iterations
        return self.make(self.c.pave_cvd_create, "pave_cvd", self.context, field, params)

    def labels(self, cvd):
        """Of every pixel, and after them every site, as bytes."""
        pixels = self.c.pave_cvd_width(cvd) * self.c.pave_cvd_height(cvd)
        sites = self.c.pave_cvd_site_count(cvd) * self.ffi.sizeof("pave_site")
        return (bytes(self.ffi.buffer(self.c.pave_cvd_labels(cvd), 4 * pixels)) +
                bytes(self.ffi.buffer(self.c.pave_cvd_sites(cvd), sites)))
