#!/bin/sh
# Window by window within a memory: the same bytes as at once; a job that was killed begins where it was.
. "$1/tests/cli/prologue.sh"
drawing=$root/examples/drawings/copacabana.png
options="--mode paper --half-side 2 --iterations 3 --quiet"

"$pave" lay "$drawing" $options -o whole.svg -o whole.stones
"$pave" lay "$drawing" $options --memory 168M -o parts.svg -o parts.stones -o parts.json
cmp whole.svg parts.svg || fail "the SVG differs from the one at once"
cmp whole.svg parts.svg && [ ! -e parts.svg.parts ] || fail "the folder of windows is still there"
/usr/bin/python3 -c '
import json
r = json.load(open("parts.json"))
assert r["stones"] == sum(r["corners_after"].values()) and r["window"]["width"] == 1024, r' || fail "the report"

# Killed at some moment, and again, until it is done
tries=0
code=1
while [ $code -ne 0 ] && [ $tries -lt 8 ]; do
  tries=$((tries + 1))
  code=0
  timeout -s KILL 1 "$pave" lay "$drawing" $options --memory 168M -o killed.svg 2>err || code=$?
  [ $code -eq 0 ] || [ ! -e killed.svg ] || cmp whole.svg killed.svg || fail "a killed job left half an output"
done
if [ $code -ne 0 ]; then # on a slow machine
  "$pave" lay "$drawing" $options --memory 168M -o killed.svg
fi
cmp whole.svg killed.svg || fail "after $tries starts the SVG differs"
echo "finished after $tries starts"

# Windows of other parameters, another drawing or a damaged file are laid anew, not taken
mkdir kept.svg.parts
echo rubbish >kept.svg.parts/000000.stones
"$pave" lay "$drawing" $options --seed 5 --memory 168M -o kept.svg
"$pave" lay "$drawing" $options --seed 5 -o seed5.svg
cmp kept.svg seed5.svg || fail "rubbish among the windows"

# Best mode needs more around a window, and more for each pixel
/usr/bin/python3 -c '
import sys
from PIL import Image
strip = Image.new("L", (2048, 160))
for x in (0, 1024):
    strip.paste(Image.open(sys.argv[1]).crop((0, 200, 1024, 360)), (x, 0))
strip.save("strip.png")' "$drawing"
best="--mode best --half-side 1 --iterations 2 --thin widen --thin-width 3 --quiet"
"$pave" lay strip.png $best -o best.svg
"$pave" lay strip.png $best --memory 173M -o parts.svg
cmp best.svg parts.svg || fail "window by window best mode differs"
"$pave" plan strip.png $best --memory 173M -o plan.json
/usr/bin/python3 -c '
import json
assert len(json.load(open("plan.json"))["windows"]) > 3' || fail "the plan for best mode has too few windows"

refuse() {
  status=$1 words=$2
  shift 2
  code=0
  "$pave" lay "$drawing" "$@" 2>err || code=$?
  [ $code -eq "$status" ] && grep -q -- "$words" err || fail "$*: $code, $(cat err)"
}
refuse 4 "memory is" $options --memory 1M -o x.svg
refuse 2 "memory" $options --memory lots -o x.svg
refuse 2 "window by window" $options --memory 1G -o x.png
refuse 2 "not both" $options --memory 1G --window 0,0,100,100 -o x.svg
refuse 5 "cannot be made" $options --memory 1G -o nowhere/x.svg
[ ! -e x.svg ] || fail "a refused job left an output"

# A plan of millions of windows: a megapixel of each, a million wide
/usr/bin/python3 -c '
import struct
width, height, size = 1 << 20, 1 << 20, 1 << 37 # a sparse file of one bit a pixel
tags = [(256, 4, 1, width), (257, 4, 1, height), (258, 3, 1, 1), (259, 3, 1, 1), (262, 3, 1, 1), (273, 16, 1, 4096),
        (277, 3, 1, 1), (278, 4, 1, height), (279, 16, 1, size)]
with open("vast.tif", "wb") as file:
    file.write(b"II+\0" + struct.pack("<HHQQ", 8, 0, 16, len(tags)))
    for tag in tags:
        file.write(struct.pack("<HHQQ", *tag))
    file.write(struct.pack("<Q", 0))
    file.truncate(4096 + size)'
refuse_plan() {
  code=0
  "$pave" plan vast.tif "$@" -o x.json 2>err || code=$?
  [ $code -eq 4 ] && [ "$(wc -l <err)" -eq 1 ] || fail "plan $*: $code, $(cat err)"
}
refuse_plan --quiet --max-pixels 1000000000
grep -q "beyond the limit" err || fail "a vast plan: $(cat err)"
exit $failed
