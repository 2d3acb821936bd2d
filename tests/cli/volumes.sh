#!/bin/sh
# pave solid as its users meet it: formats, measurements, meshes, exit codes; the independent judge's bars where there
# are the shared data.
. "$1/tests/cli/prologue.sh"
[ -e "$build/lib/pave/pave-oiio.so" ] || skip "built without the module that writes TIFF"
/usr/bin/python3 - <<'END'
import random
random.seed(1)
grains = [(random.uniform(0, 64), random.uniform(0, 64), random.uniform(2, 6), random.choice((255, 160))) for _ in range(40)]
with open("sample.pgm", "wb") as f:
    f.write(b"P5 64 64 255\n")
    for y in range(64):
        for x in range(64):
            v = 0
            for cx, cy, r, g in grains:
                if (x - cx) ** 2 + (y - cy) ** 2 < r * r:
                    v = g
            f.write(bytes([v]))
open("tetra.obj", "w").write("v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nv 0 0 1\r\nf 1/1 3/1 2/1\r\nf -4 -3 -1\r\nf 1 4 3\r\nf 2 3 4\r\n")
open("open.obj", "w").write("v 0 0 0\nv 1 0 0\nv 1 1 0\n")
open("points.csv", "w").write("x,y,z,value\n3,4,5,77\n1,1,1,255\n")
open("twice.csv", "w").write("3,4,5,77\n3,4,5,78\n")
open("beyond.csv", "w").write("3,4,5,77\n30,4,5,77\n")
open("nan.csv", "w").write("3,4,5,77\n3,4,nan,77\n")
END
"$pave" solid sample.pgm --size 16,14,12 --measured points.csv -o a.nrrd -o a.nrrd.gz -o a.vti -o a.raw -o a.tif \
  --slices cut --cells-slices cell --cells-volume cells.nrrd --json >report.json
[ "$(find . -name 'a-00*.tif' | wc -l)" -eq 12 ] || fail "no stack of 12 pages"
for file in cut-x.png cut-y.png cut-z.png cell-z.png a.raw.nhdr; do
  [ -s "$file" ] || fail "$file is missing"
done
/usr/bin/python3 - <<'END' || fail "the files differ, or a measurement is lost"
import json, struct, zlib
a = open("a.nrrd", "rb").read().split(b"\n\n", 1)[1]
b = zlib.decompress(open("a.nrrd.gz", "rb").read().split(b"\n\n", 1)[1], 31)
c = open("a.vti", "rb").read()
at = c.index(b"\n_") + 10
assert a == b == open("a.raw", "rb").read() == c[at:at + len(a)] and len(a) == 16 * 14 * 12
assert a[(5 * 14 + 4) * 16 + 3] == 77 and a[(1 * 14 + 1) * 16 + 1] == 255
report = json.load(open("report.json"))
cells = open("cells.nrrd", "rb").read().split(b"\n\n", 1)[1]
assert set(struct.unpack("<%df" % len(a), cells)) == {1, 2}
assert report["constraint_error"] == 0 and 0 < report["use"] <= 1 and report["solid"]["mode"] == "best"
assert report["measured_voxels"] == 2 and report["emd"] < 1
END
# what is half known is kept, the rest is made
"$pave" solid sample.pgm --partial a.nrrd -o b.nrrd -q
cmp -s a.nrrd b.nrrd || fail "a whole volume does not come back as it was"
"$pave" solid sample.pgm --mesh tetra.obj --resolution 16 -o t.nrrd --surface t.ply 2>said
grep -q "parity: closed" said || fail "how inside was told is not said: $(cat said)"
head -c 3 t.ply | grep -q ply || fail "no surface"
"$pave" solid sample.pgm --mesh t.ply --resolution 16 -o u.nrrd -q
cmp -s t.nrrd u.nrrd || fail "the PLY that was written is another mesh"

refused() { # refused STATUS WORDS ARGUMENTS...
  status=0 wanted=$1 words=$2
  shift 2
  "$pave" solid "$@" >said 2>&1 || status=$?
  [ "$status" -eq "$wanted" ] || fail "pave solid $*: status $status, not $wanted: $(cat said)"
  grep -q "$words" said || fail "pave solid $*: $(cat said)"
  [ ! -e x.nrrd ] || fail "pave solid $*: left an output"
}
refused 2 "where to" sample.pgm
refused 2 "a volume is written as" sample.pgm -o x.png
refused 2 "must be X,Y,Z" sample.pgm -o x.nrrd --size 3,4
refused 2 "must be odd\|window" sample.pgm -o x.nrrd --window 2
refused 2 "needs a --mesh" sample.pgm -o x.nrrd --surface x.ply
refused 3 "fewer than\|no triangles" sample.pgm -o x.nrrd --mesh open.obj
refused 3 "cannot be read" sample.pgm -o x.nrrd --mesh none.obj
refused 3 "measurement 2 gives voxel 3,4,5" sample.pgm -o x.nrrd --measured twice.csv --size 9,9,9
refused 3 "measurement 2 at 30,4,5" sample.pgm -o x.nrrd --measured beyond.csv --size 9,9,9
refused 3 "line 2" sample.pgm -o x.nrrd --measured nan.csv --size 9,9,9
refused 4 "16384 x 16384 x 16384" sample.pgm -o x.nrrd --size 16384,16384,16384

if [ ! -f "${PAVE_SHARED:-}/check/check_volume.py" ]; then
  echo "the judge is not there: its bars are not checked"
  exit $failed
fi
shared=$PAVE_SHARED
/usr/bin/python3 - "$shared" <<'END'
import sys
from PIL import Image
for name, path in (("granite", "textures/granite-aggregate.jpg"), ("electrode", "volumes/battery-electrode-slice-128.png"),
                   ("concrete", "volumes/ti-concrete.png")):
    image = Image.open(sys.argv[1] + "/data/" + path).convert("L")
    x, y = (image.width - 128) // 2, (image.height - 128) // 2
    image.crop((x, y, x + 128, y + 128)).save(name + ".png")
END
"$pave" solid granite.png --size 48,48,48 -o granite.nrrd -q
/usr/bin/python3 "$shared/check/check_volume.py" granite.png granite.nrrd --max-emd 0.05 --max-phase 0.002 --max-s2_rmse 0.015 \
  --max-isotropy 0.015 --max-cov_error 0.03 --min-sharpness 0.85 --max-sharpness 1.15 --max-speckle 0.011 --max-slice_swd 3 >said || fail "granite: $(cat said)"
"$pave" solid electrode.png --size 32,32,32 -o electrode.nrrd -q
/usr/bin/python3 "$shared/check/check_volume.py" electrode.png electrode.nrrd --max-emd 0.05 --max-phase 0.002 \
  --min-sharpness 0.85 --max-sharpness 1.15 --max-slice_swd 9 --max-speckle 0.003 >said || fail "electrode: $(cat said)"
"$pave" solid concrete.png --size 64,64,64 -o concrete.nrrd -q
/usr/bin/python3 "$shared/check/check_volume.py" concrete.png concrete.nrrd --max-emd 0.05 --max-s2_rmse 0.025 \
  --max-cov_error 0.07 --min-sharpness 0.85 --max-sharpness 1.15 --max-slice_swd 9 >said || fail "concrete: $(cat said)"
/usr/bin/python3 "$root/tests/cli/true_volumes.py" "$pave" "$shared" . >said || fail "$(cat said)"
# the same measures as the judge's
"$pave" solid granite.png --size 24,24,24 -o g.nrrd --json -q >report.json
/usr/bin/python3 "$shared/check/check_volume.py" granite.png g.nrrd --json >judged.json
/usr/bin/python3 - <<'END' || fail "the judge measures otherwise"
import json
a, b = json.load(open("report.json")), json.load(open("judged.json"))
for mine, its in (("emd", "emd"), ("phase", "phase"), ("s2_rmse", "s2_rmse"), ("cov_error", "cov_error"), ("isotropy", "isotropy"),
                  ("correlation_x", "corr_x"), ("correlation_z", "corr_z"), ("sharpness", "sharpness"), ("speckle", "speckle")):
    assert abs(a[mine] - b[its]) < 1e-3, (mine, a[mine], b[its])
assert abs(a["slice_distance"] - b["slice_swd"]) < 0.5
END
for mesh in "$shared"/data/meshes/*; do
  "$pave" solid sample.pgm --mesh "$mesh" --resolution 12 --mode paper --window 3 -o m.nrrd -q || fail "$mesh"
done
for mesh in "$shared"/data/hostile/*.obj "$shared"/data/hostile/*.ply "$shared"/data/hostile/*.stl; do
  status=0
  "$pave" solid sample.pgm --mesh "$mesh" --resolution 12 --mode paper --window 3 -o m.nrrd -q 2>said || status=$?
  [ "$status" -eq 0 ] || [ "$status" -eq 3 ] || fail "$mesh: $status $(cat said)"
done
exit $failed
