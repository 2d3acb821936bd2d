#!/bin/sh
# pave measure: its outputs and mistakes, and agreement with the independent judge on the paper's mode.
. "$1/tests/cli/prologue.sh"
drawing=$root/examples/drawings/copacabana.png

"$pave" lay "$drawing" --half-side 8 -q -o a.svg -o a.stones
"$pave" measure "$drawing" a.svg -o a.json >said || fail "measure"
[ ! -s said ] || fail "measure -o wrote to stdout"
"$pave" measure "$drawing" a.stones --json >b.json
"$pave" measure "$drawing" a.svg >text
grep -q '^quads  *9[0-9.]* %  of them have four corners$' text || fail "text: $(cat text)"
grep -q '^ *[0-9]*  stones of 4 corners$' text || fail "corners: $(cat text)"
/usr/bin/python3 - <<'PY' || fail "a.svg and a.stones measure differently"
import json
a, b = json.load(open("a.json")), json.load(open("b.json"))
assert b["half_side"] == 8 and abs(a["half_side"] - 8) < 0.2
near = {"half_side", "small", "thin", "axis_bias", "far_stones", "near_mean", "near_p90", "near_stones", "jointed"}
near |= {k for k in a if k.startswith("joint_")}
for k in a:  # sums depend on the stones' order in their last digits
    assert k in near or a[k] == b[k] or abs(a[k] - b[k]) < 1e-9 * b[k], (k, a[k], b[k])
assert a["overlap"] < 1e-3 and a["invalid"] == 0 and 0.5 < a["joint_mean"] < 1.5 and a["near_mean"] < 20
PY
expect() { # expect STATUS WORDS COMMAND...
  status=$1 words=$2
  shift 2
  code=0
  "$@" >out 2>err || code=$?
  [ "$code" -eq "$status" ] && grep -qF -- "$words" err || fail "'$*' ended with $code: $(cat err)"
}
expect 2 "which file?" "$pave" measure "$drawing"
expect 3 "missing.svg: cannot be read" "$pave" measure "$drawing" missing.svg
expect 3 "is not SVG" "$pave" measure "$drawing" "$drawing"
expect 2 "not within the drawing's" "$pave" measure "$root/tests/data/rgb.ppm" a.svg
expect 4 "more stones than the limit" "$pave" measure "$drawing" a.svg --max-stones 100
expect 5 "cannot" "$pave" measure "$drawing" a.svg -o nowhere/x.json

[ -f "${PAVE_SHARED:-}/check/check_stones.py" ] || skip "PAVE_SHARED names no folder with check/check_stones.py"
cat >evil.svg <<'SVG'
<svg viewBox="0 0 1024 640"><polygon points="0,0 9,0 9,9 0,9"/><polygon points="5,5 5,20 20,20 20,5"/>
<polygon points="30,0 40,9 40,0 30,9"/><polygon fill="#fff" points="50,0 60,0 60,9 55,1 50,9"/>
<path d="M70 0h300v1h-300z"/><polygon points="80,5 90,5"/><polygon points="-5,100 30.25,100.125 -5,300"/></svg>
SVG
list() { # list DRAWING STONES: judged by both, later
  "$pave" measure "$1" "$2" -q -o "$2.json"
  echo "$1|$2" >>pairs
}
list "$drawing" evil.svg
list "$drawing" a.svg
for name in waves text; do
  image=$PAVE_SHARED/data/reference-drawings/$name.png
  "$pave" lay "$image" --mode paper --half-side 9 --grout 0 -q -o "$name.svg"
  list "$image" "$name.svg"
done
for name in celtic-triskell eye-chart; do
  image=$PAVE_SHARED/data/drawings/$name.png
  "$pave" lay "$image" --mode paper --half-side 12 --grout 1 -q -o "$name.svg"
  list "$image" "$name.svg"
done
/usr/bin/python3 - "$PAVE_SHARED/check" <<'PY' || fail "the judges differ"
import json, sys
sys.path.insert(0, sys.argv[1])
sys.dont_write_bytecode = True
import check_stones
for line in open("pairs"):
    drawing, stones = line.strip().split("|")
    ours, theirs = json.load(open(stones + ".json")), check_stones.judge(drawing, stones)
    for key, value in theirs.items():
        # pixels whose centre is on a side go as the other judge rounds
        loose = 30 / theirs["width"] / theirs["height"] if key in ("mismatch", "uncovered") else 1e-9
        same = ours[key] == value if isinstance(value, (int, dict)) else abs(ours[key] - value) <= loose
        assert same, (line, key, ours[key], value)
    print(stones, "the same", len(theirs), "figures")
PY
exit $failed
