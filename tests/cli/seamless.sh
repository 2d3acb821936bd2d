#!/bin/sh
# Periodic pavements: no seam, and the same bytes whole, in windows that lie anywhere, in shards, on every backend.
. "$1/tests/cli/prologue.sh"
same() { # same FILE FILE WHAT
  cmp "$1" "$2" || fail "$3"
}
/usr/bin/python3 -c '
import numpy as np
def write(name, width, height, waves):
    y, x = np.mgrid[:height, :width]
    v = np.sin(2 * np.pi * waves * y / height + 1.5 * np.sin(2 * np.pi * x / width)) > 0.2
    open(name, "wb").write(b"P5 %d %d 255\n" % (width, height) + (255 * v).astype(np.uint8).tobytes())
write("waves.pgm", 256, 192, 2)
write("middle.pgm", 300, 250, 3)
write("large.pgm", 900, 700, 7)
write("small.pgm", 64, 48, 1)'

# No seam
tessellation="--mode paper --grout 0 --small-edge 0 --drop-angle 180 --passes 0"
"$pave" lay waves.pgm --periodic --mode paper --quiet -o wrapped.svg -o wrapped.png -o wrapped.json
"$pave" lay waves.pgm --periodic --mode paper --border cut --quiet -o cut.svg -o cut.png -o cut.json -o cut.stones
"$pave" lay waves.pgm --periodic $tessellation --quiet -o tessellation.svg
"$pave" lay waves.pgm $tessellation --quiet -o open.svg
/usr/bin/python3 "$root/tests/cli/seams.py" wrapped.svg cut.svg tessellation.svg wrapped.png open.svg || fail "a seam"
/usr/bin/python3 -c '
import json
import numpy as np
from PIL import Image
w, c = (json.load(open(name)) for name in ("wrapped.json", "cut.json"))
for r in (w, c):
    assert r["parameters"]["field"]["periodic"] is True and r["stones"] + r["lost"] == r["sites"] == 32 * 24
    assert r["stones"] == sum(r["corners_after"].values()) and 0.7 < r["coverage"] < 0.95
    del r["seconds"], r["parameters"]
assert w == c
w, c = (np.asarray(Image.open(name).convert("RGB")).astype(int) for name in ("wrapped.png", "cut.png"))
assert np.abs(w - c).max() <= 2' || fail "the reports or the pictures"
"$pave" merge cut.stones --quiet -o again.svg
same cut.svg again.svg "parts of stones through a file"

# Best mode: stones and their copies around them cover everything once, whichever period is looked at
"$pave" lay waves.pgm --periodic --mode best --grout 0 --quiet -o best.svg
"$pave" lay waves.pgm --periodic --mode best --grout 0 --border cut --quiet -o best-cut.svg
"$pave" lay waves.pgm --periodic --mode best --grout 0 --quiet --window 100,150,256,192 -o elsewhere.stones
"$pave" merge elsewhere.stones --quiet -o elsewhere.svg
same best.svg elsewhere.svg "the border elsewhere, best mode"
/usr/bin/python3 "$root/tests/cli/tiled.py" "$pave" waves.pgm best.svg best-cut.svg || fail "best mode at the border"
for h in 2 4; do
  options="--periodic --mode best --half-side $h --iterations 3 --border cut --quiet"
  "$pave" lay middle.pgm $options -o best.svg
  for window in 250,200,150,125 100,200,150,125 250,75,150,125 100,75,150,125; do
    "$pave" lay middle.pgm $options --window $window -o best-$window.stones
  done
  "$pave" merge best-*.stones --quiet -o merged.svg
  same best.svg merged.svg "windows in best mode, h = $h"
done

# The same from windows that lie across the borders, by one period or on their own
options="--periodic --mode paper --half-side 2 --iterations 2 --window-margin 32 --quiet"
"$pave" lay large.pgm $options --border cut -o whole.svg
for x in 0 300 600; do
  for y in 0 350; do
    left=$(((x + 820) % 900)) top=$(((y + 650) % 700))
    "$pave" lay large.pgm $options --border cut --window $left,$top,300,350 -o part-$x-$y.stones
  done
done
"$pave" merge part-*.stones --quiet -o merged.svg -o merged.stones
same whole.svg merged.svg "windows"
"$pave" merge merged.stones --quiet -o again.svg
same whole.svg again.svg "windows through a file"
"$pave" lay waves.pgm --periodic --mode paper --quiet --window 100,150,256,192 -o elsewhere.stones
"$pave" merge elsewhere.stones --quiet -o elsewhere.svg
same wrapped.svg elsewhere.svg "the border elsewhere"
"$pave" lay large.pgm $options --border cut --memory 173M -o stream.svg
same whole.svg stream.svg "window by window"
shards=$("$pave" plan large.pgm $options --border cut --memory 173M -o plan.json)
[ "$shards" -gt 3 ] || fail "only $shards shards"
shard=0
while [ $shard -lt "$shards" ]; do
  "$pave" lay --manifest plan.json --shard $shard --quiet
  shard=$((shard + 1))
done
"$pave" merge plan.json.parts/*.stones --quiet -o shards.svg
same whole.svg shards.svg "$shards shards"
echo "$shards shards"

# A pattern smaller than its margin, down to a stone that meets itself, everywhere alike
"$pave" lay small.pgm --periodic --mode paper --half-side 10 --border cut --quiet -o big.svg
[ "$(grep -c polygon big.svg)" -gt 6 ] || fail "a few large stones"
"$pave" lay small.pgm --periodic --mode paper --stones 1 --border cut --quiet -o one.svg -o one.json
/usr/bin/python3 -c 'import json; r = json.load(open("one.json")); assert r["stones"] == 1, r' || fail "one stone"
"$pave" lay small.pgm --periodic --mode best --half-side 5 --border cut --quiet -o big.svg
[ "$(grep -c polygon big.svg)" -gt 25 ] || fail "a few large stones in best mode"
"$pave" lay small.pgm --periodic --mode best --half-side 5 --border cut --quiet --window 50,40,64,48 -o big.stones
"$pave" merge big.stones --quiet -o again.svg
same big.svg again.svg "a few large stones in best mode, the border elsewhere"

backends="cpu-portable vulkan-compute vulkan-raster gles"
threads=1
for backend in $backends; do
  if [ $backend = cpu-portable ] || "$pave" info | grep "^$backend " | grep -qv 'not usable'; then
    threads=$((8 - threads))
    "$pave" lay waves.pgm --periodic --mode paper --backend $backend --threads $threads --quiet -o other.svg
    same wrapped.svg other.svg "$backend, $threads threads"
    echo "$backend agrees"
  fi
done

refuse() {
  code=0
  "$pave" lay waves.pgm --periodic "$@" 2>err -o x.svg || code=$?
  [ $code -eq 2 ] && grep -q "$words" err && [ ! -e x.svg ] || fail "$*: $code, $(cat err)"
}
words=window
refuse --window 256,0,10,10
refuse --window 0,0,257,10
words=border
refuse --border torn
exit $failed
