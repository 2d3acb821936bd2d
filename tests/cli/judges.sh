#!/bin/sh
# The independent judge's bars for both modes on the four reference drawings, the effect of the random stretch
# (Fig. 12), and every other drawing without complaint.
. "$1/tests/cli/prologue.sh"
[ -f "${PAVE_SHARED:-}/check/check_stones.py" ] || skip "PAVE_SHARED names no folder with check/check_stones.py"
drawings=$PAVE_SHARED/data/reference-drawings
judge() { # judge NAME QUADS MISMATCH STRADDLERS (of 16384)
  "$pave" lay "$drawings/$1.png" --mode paper --half-side 4 --grout 0 --quiet -o "$work/$1.svg" -o "$work/paper-$1.json"
  /usr/bin/python3 "$PAVE_SHARED/check/check_stones.py" "$drawings/$1.png" "$work/$1.svg" --min-quads "$2" --max-mismatch "$3" \
    --max-straddlers "$(awk "BEGIN {print $4 / 16384}")" --max-uncovered 0.03 --max-invalid 0 --max-clockwise 0 \
    >"$work/said" || failed=1
  echo "$1: $(tail -n 1 "$work/said")"
}
judge waves 0.98 0.0015 100
judge flower 0.98 0.0040 320
judge checker 0.985 0.0010 120
judge text 0.98 0.0110 850

best() { # best NAME QUADS MISMATCH STRADDLERS (of 16384): without joints and with
  "$pave" lay "$drawings/$1.png" --mode best --half-side 4 --grout 0 --quiet -o "$work/$1.svg" -o "$work/best-$1.json"
  /usr/bin/python3 "$PAVE_SHARED/check/check_stones.py" "$drawings/$1.png" "$work/$1.svg" --min-quads "$2" --max-mismatch "$3" \
    --max-straddlers "$(awk "BEGIN {print $4 / 16384}")" --max-uncovered 0.003 --max-overlap 0 --max-invalid 0 --max-clockwise 0 \
    >"$work/said" || failed=1
  echo "$1, best mode: $(tail -n 1 "$work/said")"
  "$pave" lay "$drawings/$1.png" --mode best --half-side 4 --grout 1 --quiet -o "$work/$1.svg"
  /usr/bin/python3 "$PAVE_SHARED/check/check_stones.py" "$drawings/$1.png" "$work/$1.svg" --max-overlap 0 --max-invalid 0 \
    --max-clockwise 0 >"$work/said" || failed=1
  echo "$1, best mode with joints: $(tail -n 1 "$work/said")"
}
best waves 0.99 0.0005 10
best flower 0.985 0.0007 40
best checker 0.995 0.00005 0
best text 0.93 0.0025 300

cv() { sed -n 's/.*"area_cv": \([0-9.]*\).*/\1/p' "$1"; }
for mode in paper best; do
  "$pave" lay "$drawings/waves.png" --mode $mode --half-side 4 --grout 0 --scale-min 1 --scale-max 1 --quiet -o "$work/fixed.json"
  random=$(cv "$work/$mode-waves.json") fixed=$(cv "$work/fixed.json")
  echo "area CV, $mode mode: $random with random s_x, $fixed with s_x = 1"
  awk "BEGIN {exit !($random >= 1.3 * $fixed)}" || failed=1
done

count=0
for drawing in "$PAVE_SHARED"/data/drawings/*.png; do
  "$pave" lay "$drawing" --mode best --grout 0 -o "$work/x.svg" 2>"$work/err" && [ ! -s "$work/err" ] ||
    { echo "$drawing: $(cat "$work/err")"; failed=1; }
  "$pave" measure "$drawing" "$work/x.svg" --quiet --json >"$work/m.json"
  /usr/bin/python3 -c '
import json, sys
m = json.load(open(sys.argv[1]))
assert m["overlapping"] == 0 and m["overlap"] == 0 and m["invalid"] == 0 and m["clockwise"] == 0, m
assert m["mismatch"] <= 0.003 and m["straddlers"] <= 0.02, m' "$work/m.json" || { echo "$drawing"; failed=1; }
  count=$((count + 1))
done
echo "$count drawings laid"
exit $failed
