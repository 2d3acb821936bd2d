#!/bin/sh
# pave tile as its users meet it: files in and out, companions, what is refused; and, where there is an independent
# judge and its textures, the bars for mode best.
. "$1/tests/cli/prologue.sh"
"$pave" lay "$root/examples/drawings/copacabana.png" -o stones.png --half-side 9 --window 0,0,160,160 --quiet

# the same bytes for any number of threads and way of searching; a report with all measures
"$pave" tile stones.png -o a.png -o a.json --rounds 10 --quiet --threads 1
"$pave" tile stones.png -o b.png --rounds 10 --quiet --threads 3 --search fft
cmp a.png b.png || fail "threads or search change a tiling"
for key in seam_x coherence completeness entropy histogram seam_energy repeat; do
  grep -q "\"$key\": [-0-9]" a.json || fail "the report lacks $key"
done

# companions are laid alike; sources are written; several exemplars
"$pave" tile stones.png --apply stones.png=c.png --sources s.exr --rounds 10 --quiet
cmp a.png c.png || fail "a companion equal to the exemplar is laid otherwise"
"$pave" tile stones.png --normals stones.png=d.png --normals-down stones.png=e.png --turns --rounds 10 --quiet
[ -s d.png ] && [ -s e.png ] && ! cmp -s d.png e.png || fail "normals are not turned by where y points"
[ -s s.exr ] || fail "no sources"
"$pave" tile stones.png stones.png -o two.png --rounds 3 --quiet
"$pave" tile stones.png --keep -o kept.png --rounds 10 --quiet
"$pave" tile stones.png --wang 2 --size 256x256 -o wang.png --json --rounds 3 --quiet >wang.json
[ "$(grep -c '"north"' wang.json)" = 16 ] || fail "a set of two colours has 16 tiles"

# what is refused: status and sentence
refuse() { # refuse STATUS WORDS ARGUMENTS...
  status=$1 words=$2
  shift 2
  got=0
  "$pave" tile "$@" -o x.png --quiet 2>said || got=$?
  [ "$got" = "$status" ] || fail "pave tile $*: status $got, not $status"
  grep -q "$words" said || fail "pave tile $*: says $(cat said)"
  [ ! -e x.png ] || fail "pave tile $*: leaves a file"
  rm -f x.png
}
refuse 2 "no room for a fraction" stones.png --fraction 500
refuse 2 "leaves nothing" stones.png --fraction 20 --overlap 20
refuse 4 "beyond the limit" stones.png --size 1048576x1048576
refuse 2 "WIDTHxHEIGHT" stones.png --size 100
refuse 2 "needs mode best" stones.png --keep --mode fast
refuse 2 "does not fit" stones.png --rounds 1 --size 64x64 --apply "$root/examples/drawings/copacabana.png=y.png"
refuse 2 "IN=OUT" stones.png --apply y.png
refuse 3 "cannot be read" none.png

if [ -f "${PAVE_SHARED:-}/check/check_tiling.py" ]; then
  /usr/bin/python3 "$root/tests/cli/tiling_bars.py" "$pave" "$PAVE_SHARED" "$work" || failed=1
else
  echo "skipped the bars: PAVE_SHARED names no folder with check/check_tiling.py"
fi
exit $failed
