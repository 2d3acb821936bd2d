#!/bin/sh
# Drawings are read from their files part by part: TIFF in tiles, in strips and in one strip, OpenEXR in tiles and in
# lines, PNG. All name the same drawing and give the same windows, none is ever held as a whole, and where even its bits
# are too many they are kept in a file that leaves nothing behind.
. "$1/tests/cli/prologue.sh"
mkdir large small
/usr/bin/python3 "$root/tests/cli/large.py" 3072 large
/usr/bin/python3 "$root/tests/cli/large.py" 256 small
cat >measure.py <<'EOF'
import json, os, subprocess, sys

pave = sys.argv[1]
names = ["rows.png", "tiles.tif", "strips.tif", "one.tif", "tiles.exr", "lines.exr"]
options = ["--mode", "paper", "--half-side", "2", "--iterations", "3", "--quiet"]


def run(*arguments):
    """Peak resident bytes."""
    child = subprocess.Popen([pave, *arguments], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    assert status == 0, (arguments, status)
    return usage.ru_maxrss * 1024


def plan(name, memory):
    peak = run("plan", name, *options, "--memory", memory, "-o", "plan.json")
    return json.load(open("plan.json")), peak


hashes = set()
for name in names:
    _, small = plan("small/" + name, "1G")
    for memory in ["168M", "1G"][:1 + (name == "tiles.tif")]:  # with 168M the bits of the drawing are kept in a file
        made, peak = plan("large/" + name, memory)
        size = os.path.getsize("large/" + name)
        hashes.add(made["hash"])
        print("%-10s %4s: a file of %3d MB, %3d MB resident" % (name, memory, size / 1e6, peak / 1e6))
        assert peak < small + 25e6, "held as a whole"
assert len(hashes) == 1, hashes

stones = set()
for name in names:
    run("lay", "small/" + name, *options, "--memory", "165M", "-o", "out.stones")
    run("lay", "small/" + name, *options, "-o", "whole.svg")
    run("merge", "out.stones", "--quiet", "-o", "out.svg")
    stones.add(open("out.svg").read())
    stones.add(open("whole.svg").read())
assert len(stones) == 1, "the stones differ"
EOF
/usr/bin/python3 measure.py "$build/bin/pave"
strays=$(find . -name '.pave-*')
[ -z "$strays" ] || { echo "left behind: $strays" >&2; exit 1; }

# Where a picture can only be decoded at once, that is held against the memory
/usr/bin/python3 -c '
from PIL import Image, TiffImagePlugin
TiffImagePlugin.STRIP_SIZE = 1 << 30
image = Image.open("large/rows.png").convert("RGB")
image.save("large.ppm")
image.save("large.tif", compression="tiff_lzw")'
for name in large.ppm large.tif; do
  code=0
  "$build/bin/pave" plan $name --mode paper --memory 180M --quiet -o plan.json 2>err || code=$?
  [ $code -eq 4 ] && grep -q "is decoded with .* bytes at once" err || { echo "$name: $code, $(cat err)" >&2; exit 1; }
done

# Written to while it is read, and cut short while it is read
for what in "ab" "r+b"; do
  cp large/strips.tif changing.tif
  "$build/bin/pave" plan changing.tif --memory 1G --quiet -o changed.json 2>err &
  job=$!
  /usr/bin/python3 -c '
import os, sys, time
time.sleep(0.25)
with open("changing.tif", sys.argv[1]) as file:
    file.write(b"?") if sys.argv[1] == "ab" else file.truncate(1 << 20)' "$what"
  code=0
  wait $job || code=$?
  if [ $code -eq 0 ]; then
    echo "it was done before" # on a fast machine
  else
    [ $code -eq 3 ] && grep -qE "was written to while|became shorter meanwhile" err || { cat err >&2; exit 1; }
  fi
done
