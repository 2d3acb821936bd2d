#!/bin/sh
# pave statistics as its users meet it: textures in and out, the report, what is refused.
. "$1/tests/cli/prologue.sh"
"$pave" lay "$root/examples/drawings/copacabana.png" -o stones.png --half-side 4 --window 0,0,64,48 --quiet

# the same bytes for any number of threads, others for another seed; a report of every group
"$pave" statistics stones.png -o a.png -o a.exr --json --scales 3 --iterations 12 --threads 1 --quiet >a.json
"$pave" statistics stones.png -o b.png --scales 3 --iterations 12 --threads 3 --quiet
"$pave" statistics stones.png -o c.png --scales 3 --iterations 12 --seed 2 --quiet
cmp a.png b.png || fail "threads change a texture"
cmp -s a.png c.png && fail "another seed makes the same texture"
[ -s a.exr ] || fail "no second output"
for key in distance pixels shape low_shape low_correlation high magnitude magnitude_correlation orientations scales phase; do
  grep -q "\"$key\": [0-9]" a.json || fail "the report lacks $key"
done
for parameter in scales neighbourhood size seed iterations; do
  grep -q "\"$parameter\": " a.json || fail "the report lacks the parameter $parameter"
done

# another size, which does not divide
"$pave" statistics stones.png -o d.png --size 131x67 --scales 2 --iterations 2 --quiet
od -An -tx1 -j16 -N8 d.png | grep -q '00 00 00 83 00 00 00 43' || fail "not 131 x 67 px"

# what is refused: status and sentence; nothing is written
refuse() { # refuse STATUS WORDS ARGUMENTS...
  status=$1 words=$2
  shift 2
  got=0
  "$pave" statistics "$@" --quiet 2>said || got=$?
  [ "$got" = "$status" ] || fail "pave statistics $*: status $got, not $status"
  grep -q "$words" said || fail "pave statistics $*: said $(cat said)"
}
"$pave" lay "$root/examples/drawings/copacabana.png" -o small.png --half-side 4 --window 0,0,40,9 --quiet
refuse 2 "too small for 4 scales, which need sides of 64 px; it allows 1" small.png -o no.png
refuse 2 "too few for statistics" stones.png -o no.png --scales 3 --size 16x16
refuse 2 "odd neighbourhood" stones.png -o no.png --scales 3 --neighbourhood 6
refuse 2 "where to" stones.png
refuse 2 "scales" stones.png -o no.png --scales 0
refuse 3 "nothing.png" nothing.png -o no.png
refuse 4 "limit" stones.png -o no.png --scales 3 --size 90000x90000
refuse 5 "nowhere" stones.png --scales 3 --iterations 1 -o nowhere/no.png
[ ! -e no.png ] || fail "something was written"
exit $failed
