#!/bin/sh
# A plan and its shards: any order, again, a part of them killed, two at once; merged, the bytes of the whole.
set -eu
root=$(cd "$1" && pwd) build=$(cd "$2" && pwd)
pave=$build/bin/pave
work=$(mktemp -d "${TMPDIR:-/tmp}/pave shards.XXXXXX")
trap 'rm -rf "$work"' EXIT
cd "$work"
cp "$root/examples/drawings/copacabana.png" drawing.png
failed=0
fail() {
  echo "FAILED: $1" >&2
  failed=1
}
options="--half-side 2 --iterations 3 --seed 3"

"$pave" lay drawing.png $options --quiet -o whole.svg
shards=$("$pave" plan drawing.png $options --memory 168M -o plan.json)
/usr/bin/python3 -c '
import json, sys
p = json.load(open("plan.json"))
w = [tuple(map(int, t.split(","))) for t in p["windows"]]
assert len(w) == int(sys.argv[1]) == p["columns"] * p["rows"] > 4
assert sum(a[2] * a[3] for a in w) == 1024 * 640 and p["parameters"]["cvd"]["seed"] == 3' "$shards" || fail "the plan"
echo "$shards shards"

shard=$shards
while [ $shard -gt 0 ]; do # backwards, every third killed on its first try
  shard=$((shard - 1))
  if [ $((shard % 3)) -eq 0 ]; then
    timeout -s KILL 0.2 "$pave" lay --manifest plan.json --shard $shard --quiet 2>err || true
  fi
  "$pave" lay --manifest plan.json --shard $shard --quiet
done
"$pave" lay --manifest plan.json --shard 0 --quiet &
job=$!
"$pave" lay --manifest plan.json --shard 0 --quiet # there already, and twice at once
wait $job
"$pave" merge plan.json.parts/*.stones --quiet -o merged.svg
cmp whole.svg merged.svg || fail "the shards, merged, differ from the whole"

refuse() {
  status=$1 words=$2 code=0
  shift 2
  "$pave" "$@" 2>err || code=$?
  [ $code -eq "$status" ] && grep -q -- "$words" err || fail "$*: $code, $(cat err)"
}
refuse 2 "but the plan has shards 0 .. $((shards - 1))" lay --manifest plan.json --shard "$shards"
refuse 2 "needs --shard" lay --manifest plan.json
refuse 2 "needs --shard" lay --manifest plan.json --shard one
refuse 3 "No such file" lay --manifest missing.json --shard 0
echo '{"pave": "0.1.0"' >cut.json
refuse 3 "is not a plan" lay --manifest cut.json --shard 0
sed 's/"pave": "[^"]*"/"pave": "0.0.1"/' plan.json >old.json
refuse 3 "was planned by pave 0.0.1" lay --manifest old.json --shard 0
sed 's/"columns": [0-9]*/"columns": 1000000000/' plan.json >billion.json
refuse 3 "damaged plan" lay --manifest billion.json --shard 0
sed 's/"half_side": [0-9.]*/"half_side": 0.1/' plan.json >bad.json
refuse 2 "half_side" lay --manifest bad.json --shard 0
"$pave" field drawing.png --quiet -o other.exr
mv drawing.png kept.png
refuse 3 "No such file" lay --manifest plan.json --shard 0 -o x.stones
/usr/bin/python3 -c 'from PIL import Image, ImageOps; ImageOps.invert(Image.open("kept.png")).save("drawing.png")'
refuse 3 "is not the drawing" lay --manifest plan.json --shard 0 -o x.stones
[ ! -e x.stones ] || fail "a refused shard left an output"
exit $failed
