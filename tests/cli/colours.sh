#!/bin/sh
# Drawings of more than two colours: palettes found and given, and the same bytes whole, in windows, in shards, from
# every backend and any number of threads.
. "$1/tests/cli/prologue.sh"
drawing=$root/examples/drawings/map.png
options="--mode paper --colours 4 --half-side 2 --iterations 1 --quiet"
/usr/bin/python3 -c '
import sys
from PIL import Image
Image.open(sys.argv[1]).resize((800, 525), Image.BICUBIC).save("drawing.png")' "$drawing"
drawing=drawing.png

"$pave" lay "$drawing" $options -o whole.svg -o whole.json -o whole.png -o whole.stones
/usr/bin/python3 - <<'PY' || fail "the palette, or how stones carry it"
import json, re
from PIL import Image
true = ["#1f4e79", "#b22222", "#3c7842", "#ece2c6"]  # dark ones first
r = json.load(open("whole.json"))
assert r["parameters"]["palette"] == {"colours": 4, "palette": " ".join(true)}, r["parameters"]["palette"]
assert list(r["colours"]) == true and sum(r["colours"].values()) == r["stones"] and min(r["colours"].values()) > 100
svg = open("whole.svg").read()
assert re.findall(r'<g id="(.*?)" fill="(.*?)">', svg) == [(f"colour{i}", c) for i, c in enumerate(true)]
assert {(60, 120, 66), (178, 34, 34), (236, 226, 198)} <= set(Image.open("whole.png").getdata())
PY
"$pave" measure "$drawing" whole.stones --json >a.json # in the stones' own colours
"$pave" measure "$drawing" whole.svg --colours 4 --json >b.json
/usr/bin/python3 - <<'PY' || fail "measures of a drawing in colours"
import json
a, b = json.load(open("a.json")), json.load(open("b.json"))
assert a["mismatch"] == b["mismatch"] < 0.02 and a["straddlers"] == b["straddlers"] < 0.1 and a["edge_mean"] < 0.6, (a, b)
PY

same() { # same FILE HOW
  cmp whole.svg "$1" || fail "other stones $2"
}
"$pave" lay "$drawing" $options --palette "#b22222,#1f4e79 #ece2c6 #3c7842" -o other.svg
cmp -s whole.svg other.svg && fail "the order of a palette given is kept"
printf '#1f4e79 #b22222\n#3c7842\n#ece2c6\n' >palette.txt
"$pave" lay "$drawing" $options --palette palette.txt -o given.svg
same given.svg "from a palette in a file"
"$pave" lay "$drawing" $options --threads 3 --backend cpu-portable -o threads.svg
same threads.svg "with three threads"
"$pave" lay "$drawing" $options --window 0,0,301,525 -o left.stones
"$pave" lay "$drawing" $options --window 301,0,499,525 -o right.stones
"$pave" merge left.stones right.stones -o merged.svg
same merged.svg "in windows"
windows=$("$pave" plan "$drawing" $options --memory 167M -o plan.json)
[ "$windows" -gt 1 ] || fail "the plan has one window"
grep -q '"palette": "#1f4e79 #b22222 #3c7842 #ece2c6"' plan.json || fail "the plan does not know the palette"
k=0
while [ $k -lt "$windows" ]; do
  "$pave" lay --manifest plan.json --shard $k -q
  k=$((k + 1))
done
"$pave" merge plan.json.parts/*.stones -q -o shards.svg
same shards.svg "in $windows shards"
"$pave" lay "$drawing" $options --memory 167M -o stream.svg
same stream.svg "window by window"
"$pave" lay "$drawing" --colours 5 --half-side 2 --iterations 1 -q --window 301,0,499,525 -o other.stones
"$pave" merge left.stones other.stones -o x.svg 2>err && fail "windows of other palettes are merged"
grep -q "another pavement" err || fail "$(cat err)"

refuse() { # refuse STATUS WORDS OPTION...
  status=$1 words=$2
  shift 2
  code=0
  "$pave" lay "$drawing" -o x.svg "$@" 2>err || code=$?
  [ $code -eq "$status" ] && grep -q -- "$words" err || fail "$*: $code, $(cat err)"
}
refuse 2 "colours is 300, but must be" --colours 300
refuse 2 "colours like #rrggbb" --palette "#12"
refuse 3 "neither colours" --palette missing.txt
echo red >palette.txt
refuse 3 "colours like #rrggbb" --palette palette.txt
[ ! -e x.svg ] || fail "a refused job wrote x.svg"
echo "$windows windows, the same bytes"
exit $failed
