"""The public headers, after the preprocessor, go into cffi as they stand; the whole job runs through them."""
import glob
import os
import subprocess
import sys

import cffi

prefix, work = sys.argv[1:3]
include = os.path.join(prefix, "include")
empty = os.path.join(work, "empty")
os.makedirs(empty, exist_ok=True)
for name in ("stddef.h", "stdint.h"):  # cffi knows the fixed-width types
    open(os.path.join(empty, name), "w").close()
text = subprocess.run(["cc", "-E", "-P", "-nostdinc", "-I", empty, "-I", include, os.path.join(include, "pave/pave.h")],
                      check=True, capture_output=True, text=True).stdout
ffi = cffi.FFI()
ffi.cdef(text)
library = glob.glob(os.path.join(prefix, "lib*", "**", "libpave.so"), recursive=True)[0]
pave = ffi.dlopen(library)

context, image, stones = ffi.new("pave_context **"), ffi.new("pave_image **"), ffi.new("pave_stones **")
assert pave.pave_context_create(ffi.NULL, context) == pave.PAVE_OK
shape = ffi.new("pave_image_params *")
pave.pave_image_params_init(shape, ffi.sizeof("pave_image_params"))
shape.width, shape.height = 96, 64
pixels = bytes(0 if (x // 24 + y // 16) % 2 else 255 for y in range(64) for x in range(96))
assert pave.pave_image_create(context[0], shape, pixels, image) == pave.PAVE_OK
cvd = ffi.new("pave_cvd_params *")
pave.pave_cvd_params_init(cvd, ffi.sizeof("pave_cvd_params"))
assert pave.pave_params_set(context[0], pave.PAVE_PARAMS_CVD, cvd, b"half-side", b"0.1") == pave.PAVE_ERR_ARGUMENT
assert b"half-side" in ffi.string(pave.pave_context_message(context[0]))
assert pave.pave_params_set(context[0], pave.PAVE_PARAMS_CVD, cvd, b"half-side", b"3") == pave.PAVE_OK
params = ffi.new("pave_lay_params *")
pave.pave_lay_params_init(params, ffi.sizeof("pave_lay_params"))
params.cvd = cvd
assert pave.pave_lay(context[0], image[0], params, stones) == pave.PAVE_OK
pave.pave_image_free(image)
pave.pave_context_free(context)
count = pave.pave_stones_count(stones[0])
starts = pave.pave_stones_starts(stones[0])
vertices = ffi.buffer(pave.pave_stones_vertices(stones[0]), starts[count] * 16)
assert 140 < count < 200 and len(vertices) == 16 * starts[count]
pave.pave_stones_free(stones)
assert stones[0] == ffi.NULL
print(f"{count} stones through cffi")
