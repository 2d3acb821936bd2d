#!/bin/sh
# The same drawing, parameters and seed give the same SVG, byte for byte: on every backend, for every number of
# threads, in every locale, and again.
. "$1/tests/cli/prologue.sh"
backends="cpu cpu-portable"
for device in vulkan-compute vulkan-raster gles; do
  if "$pave" info | grep -q "^$device *[^n]"; then
    backends="$backends $device"
  fi
done
echo "backends: $backends"
lay() { "$pave" lay "$root/examples/drawings/copacabana.png" --quiet "$@"; }
lay --seed 7 -o "$work/first.svg"
same() {
  cmp "$work/first.svg" "$work/x.svg" || { echo "differs: $1" >&2; failed=1; }
}
for backend in $backends; do
  for threads in 1 2 7; do
    lay --seed 7 --backend $backend --threads $threads -o "$work/x.svg"
    same "$backend, $threads threads"
  done
done
lay --half-side 6 --relaxation 1.7 --until-still 0.2 -o "$work/still.svg"
mv "$work/first.svg" "$work/twenty.svg"
mv "$work/still.svg" "$work/first.svg"
for backend in $backends; do
  lay --half-side 6 --relaxation 1.7 --until-still 0.2 --backend $backend --threads 3 -o "$work/x.svg"
  same "$backend until still, over-relaxed"
done
mv "$work/twenty.svg" "$work/first.svg"
threads=1
for backend in $backends; do
  lay --seed 7 --mode best --backend $backend --threads $threads -o "$work/$backend-best.svg"
  cmp "$work/cpu-best.svg" "$work/$backend-best.svg" || { echo "differs: best mode, $backend" >&2; failed=1; }
  threads=$((threads % 7 * 2 + 1)) # 1, 3, 7, 1 ...
done
lay --seed 7 --mode best --threads 2 -o "$work/x.svg"
cmp "$work/cpu-best.svg" "$work/x.svg" || { echo "differs: best mode, 2 threads" >&2; failed=1; }
LC_ALL=de_DE.UTF-8 lay --seed 7 -o "$work/x.svg"
same "another locale"
lay --seed 8 -o "$work/x.svg"
! cmp -s "$work/first.svg" "$work/x.svg" || { echo "another seed makes no difference" >&2; failed=1; }
# Small enough for brute force
for h in 3 6; do
  /usr/bin/python3 -c '
import sys
from PIL import Image
Image.open(sys.argv[1]).crop((0, 0, 180, 140)).save(sys.argv[2])' "$root/examples/drawings/copacabana.png" "$work/part.png"
  "$pave" lay "$work/part.png" --half-side $h --backend cpu-reference --quiet -o "$work/first.svg"
  for backend in $backends; do
    "$pave" lay "$work/part.png" --half-side $h --backend $backend --quiet -o "$work/x.svg"
    same "$backend against brute force, h = $h"
  done
done
exit $failed
