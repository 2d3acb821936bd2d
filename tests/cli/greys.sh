#!/bin/sh
# Smooth drawings, whose greys tell where edges are: the same stones at once, in windows, within a memory, in shards and
# on planes that repeat.
. "$1/tests/cli/prologue.sh"
# The left half of strip.png has no greys: they are met late
/usr/bin/python3 -c '
import sys
from PIL import Image, ImageFilter
drawing = Image.open(sys.argv[1]).convert("L").crop((0, 200, 1024, 360))
smooth = drawing.filter(ImageFilter.GaussianBlur(0.8))
strip = Image.new("L", (2048, 160))
strip.paste(drawing, (0, 0))
strip.paste(smooth, (1024, 0))
strip.save("strip.png")
strip.rotate(90, expand=True).save("upright.png")
strip.point(lambda v: 255 * (v > 127)).save("hard.png")
import math
tile = Image.new("L", (96, 64))
tile.putdata([int(127.5 + 127.5 * max(-1, min(1, 4 * math.sin(2 * math.pi * (x / 96 + y / 64)) +
              4 * math.cos(2 * math.pi * (2 * x / 96 - y / 64))))) for y in range(64) for x in range(96)])
tile.save("tile.png")
large = Image.new("L", (480, 384))
for x in range(0, 480, 96):
    for y in range(0, 384, 64):
        large.paste(tile, (x, y))
large.save("large.png")' "$root/examples/drawings/copacabana.png"

best="--mode best --half-side 1 --iterations 1 --supersample 1 --quiet"
"$pave" lay hard.png $best -o hard.svg
compare() { # DRAWING OPTION...: within a memory, and at once
  "$pave" lay "$@" -o whole.svg
  ! cmp -s whole.svg hard.svg || fail "$*: greys do not tell"
  "$pave" lay "$@" --memory 168M -o parts.svg
  cmp whole.svg parts.svg || fail "$*: window by window it differs"
}
compare upright.png $best --thin widen --thin-width 3
compare strip.png $best
windows=$("$pave" plan strip.png $best --memory 168M -o plan.json)
[ "$windows" -gt 2 ] || fail "the plan has $windows windows"
for x in 0 1000; do
  "$pave" lay strip.png $best --window $x,0,$((1000 + x * 48 / 1000)),160 --threads 3 -o part-$x.stones
done
"$pave" merge part-*.stones --quiet -o merged.svg
cmp whole.svg merged.svg || fail "in two windows it differs"

# Windows and shards name the drawing alike, and of another threshold it is another
"$pave" lay --manifest plan.json --shard 0 --quiet
rest=$(/usr/bin/python3 -c '
import json
right = int(json.load(open("plan.json"))["windows"][0].split(",")[2])
print("%d,0,%d,160" % (right, 2048 - right))')
"$pave" lay strip.png $best --window $rest -o rest.stones
"$pave" merge plan.json.parts/000000.stones rest.stones --quiet -o merged.svg
cmp whole.svg merged.svg || fail "a shard and a window differ from the whole"
"$pave" lay strip.png $best --threshold 0.45 --window $rest -o other.stones
"$pave" merge plan.json.parts/000000.stones other.stones --quiet -o other.svg 2>err &&
  fail "windows of two thresholds are merged"

# A plane that repeats: windows across its border, and within a memory
best="--mode best --half-side 2 --iterations 2 --supersample 1 --periodic --border cut --quiet"
"$pave" lay large.png $best -o whole.svg
for x in 0 240; do
  "$pave" lay large.png $best --window $(((x + 400) % 480)),300,240,384 -o around-$x.stones
done
"$pave" merge around-*.stones --quiet -o merged.svg
cmp whole.svg merged.svg || fail "windows across the border of a plane that repeats"
"$pave" lay large.png $best --memory 1G -o parts.svg
cmp whole.svg parts.svg || fail "a plane that repeats, from a file"
exit $failed
