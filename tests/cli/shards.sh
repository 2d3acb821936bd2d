#!/bin/sh
# A plan and its shards: any order, again, a part of them killed, two at once; merged, the bytes of the whole.
. "$1/tests/cli/prologue.sh"
cp "$root/examples/drawings/copacabana.png" drawing.png
options="--mode paper --half-side 2 --iterations 3 --seed 3"

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
"$pave" merge --manifest plan.json --quiet -o planned.svg -o planned.json
cmp whole.svg planned.svg || fail "the plan, merged, differs from the whole"

# A real race: four at once on one shard that is not there, each of them well and the file whole
rm plan.json.parts/000001.stones
race=
for k in 1 2 3 4; do
  "$pave" lay --manifest plan.json --shard 1 --quiet &
  race="$race $!"
done
for job in $race; do
  wait "$job" || fail "a shard that raced"
done
[ "$(ls plan.json.parts | wc -l)" -eq "$shards" ] || fail "a race left a stray"
"$pave" merge --manifest plan.json --quiet -o raced.svg
cmp whole.svg raced.svg || fail "a race changed the stones"

# Killed while it merges: no output, all parts still there
for wait in 0.01 0.03 0.05 0.1; do
  timeout -s KILL $wait "$pave" merge --manifest plan.json --quiet -o killed.svg 2>err || true
  [ ! -e killed.svg ] || cmp whole.svg killed.svg || fail "a killed merge left half an output"
done
[ "$(ls -A plan.json.parts | wc -l)" -eq "$shards" ] || fail "a killed merge took parts away"

# Best mode
/usr/bin/python3 -c '
import sys
from PIL import Image
strip = Image.new("L", (2048, 160))
for x in (0, 1024):
    strip.paste(Image.open(sys.argv[1]).crop((0, 200, 1024, 360)), (x, 0))
strip.save("strip.png")' drawing.png
"$pave" lay strip.png --mode best --half-side 1 --iterations 1 --quiet -o best.svg
shard=$("$pave" plan strip.png --mode best --half-side 1 --iterations 1 --memory 173M -o best.json)
[ "$shard" -gt 3 ] || fail "best mode has only $shard shards"
while [ "$shard" -gt 0 ]; do
  shard=$((shard - 1))
  "$pave" lay --manifest best.json --shard $shard --quiet
done
"$pave" merge --manifest best.json --quiet -o merged.svg
cmp best.svg merged.svg || fail "the shards of best mode differ from the whole"

refuse() {
  status=$1 words=$2 code=0
  shift 2
  "$pave" "$@" 2>err || code=$?
  [ $code -eq "$status" ] && grep -q -- "$words" err || fail "$*: $code, $(cat err)"
}
# A full disk: one sentence, no output, and the parts are as they were
ln -s /dev/full full.svg
refuse 5 "No space left" merge --manifest plan.json -o full.svg
(trap '' XFSZ; ulimit -f 8; "$pave" merge --manifest plan.json --quiet -o large.svg 2>err) && fail "a file too large"
grep -q "File too large" err && [ ! -e large.svg ] || fail "a file too large: $(cat err)"
(trap '' XFSZ; ulimit -f 1; "$pave" lay --manifest plan.json --shard 2 --quiet -o large.stones 2>err) && fail "a shard too large"
[ ! -e large.stones ] || fail "half a shard"

# Parts that are missing, twice there, of another plan or damaged
refuse 3 "comes twice" merge plan.json.parts/*.stones plan.json.parts/000000.stones -o x.svg
"$pave" plan drawing.png $options --seed 4 --memory 168M -o other.json >/dev/null
"$pave" lay --manifest other.json --shard 0 --quiet
refuse 3 "another pavement" merge plan.json.parts/000001.stones other.json.parts/000000.stones -o x.svg
mv plan.json.parts/000002.stones kept.stones
refuse 3 "lay shard 2 first" merge --manifest plan.json -o x.svg
cp other.json.parts/000000.stones plan.json.parts/000002.stones
refuse 3 "another pavement" merge --manifest plan.json -o x.svg
head -c 20000 kept.stones >plan.json.parts/000002.stones
refuse 3 "its size is wrong" merge --manifest plan.json -o x.svg
for at in 32 36 40 44 56; do # the window's place and size, the number of stones
  cp kept.stones plan.json.parts/000002.stones
  printf '\377\377\377\177' | dd of=plan.json.parts/000002.stones bs=1 seek=$at conv=notrunc 2>/dev/null
  refuse 3 "contradicts itself" merge --manifest plan.json -o x.svg
done
cp kept.stones plan.json.parts/000002.stones
printf '\377\377\377\177' | dd of=plan.json.parts/000002.stones bs=1 seek=8192 conv=notrunc 2>/dev/null
refuse 3 "damaged file of stones" merge --manifest plan.json -o x.svg
"$pave" lay --manifest plan.json --shard 2 --quiet # it is there, and right as far as can be told
mv kept.stones plan.json.parts/000002.stones
[ ! -e x.svg ] || fail "a refused merge left an output"

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
# Edited by hand: each change is met with a sentence
edit() { # edit WORDS PYTHON, which changes the plan p
  /usr/bin/python3 -c "import json
p = json.load(open('plan.json'))
$2
json.dump(p, open('edited.json', 'w'))"
  refuse 3 "$1" lay --manifest edited.json --shard 0
}
edit "damaged plan" 'p["columns"] = -1'
edit "damaged plan" 'p["columns"] = 2.5'
edit "damaged plan" 'p["rows"] = "3"'
edit "damaged plan" 'p["rows"] = 4294967297'
edit "damaged plan" 'p["columns"] = p["width"]; p["rows"] = p["height"]'
edit "damaged plan" 'p["width"] = 1e300'
edit "damaged plan" 'p["height"] = None'
edit "damaged plan" 'p["margin"] = 0'
edit "damaged plan" 'p["hash"] = p["hash"][1:]'
edit "damaged plan" 'p["hash"] = 17'
edit "its windows are not those" 'p["height"] *= 2'
edit "its windows are not those" 'p["windows"][0] = "-5,0,5,5"'
edit "its windows are not those" 'p["windows"][1] = p["windows"][0]'
edit "its windows are not those" 'p["windows"].pop()'
edit "its windows are not those" 'p["windows"] = 7'
edit "its windows are not those" 'p["windows"][0] = 9'
edit "No such file" 'p["drawing"] = "nowhere.png"'
edit "is not a plan" 'p["parameters"] = []'
edit "has no cvd parameters" 'del p["parameters"]["cvd"]'
edit "of a strange kind" 'p["parameters"]["cvd"]["seed"] = None'
edit "is not the drawing" 'p["parameters"]["threshold"]["invert"] = True'
/usr/bin/python3 -c 'print("[" * 100000)' >deep.json
refuse 3 "is not a plan" lay --manifest deep.json --shard 0
: >empty.json
refuse 3 "is empty" lay --manifest empty.json --shard 0
sed 's/"half_side": [0-9.]*/"half_side": 0.1/' plan.json >bad.json
refuse 2 "half_side" lay --manifest bad.json --shard 0
mv drawing.png kept.png
refuse 3 "No such file" lay --manifest plan.json --shard 0 -o x.stones
/usr/bin/python3 -c 'from PIL import Image, ImageOps; ImageOps.invert(Image.open("kept.png")).save("drawing.png")'
refuse 3 "is not the drawing" lay --manifest plan.json --shard 0 -o x.stones
[ ! -e x.stones ] || fail "a refused shard left an output"
exit $failed
