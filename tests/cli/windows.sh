#!/bin/sh
# Windows that share out the plane share out its stones: nothing twice, nothing missing, every polygon the same.
. "$1/tests/cli/prologue.sh"
drawing=$root/examples/drawings/copacabana.png
width=1024 height=640
/usr/bin/python3 -c '
import sys
from PIL import Image
Image.open(sys.argv[1]).crop((0, 200, 1024, 320)).save(sys.argv[2])' "$drawing" "$work/strip.png"

polygons() { grep -h '<polygon' "$@" | LC_ALL=C sort; }

# compare COLUMNS ROWS OPTION...: the windows of a grid against the whole
compare() {
  columns=$1 rows=$2
  shift 2
  rm -f "$work"/part-*
  "$pave" lay "$drawing" --quiet "$@" -o "$work/whole.svg"
  row=0
  while [ $row -lt "$rows" ]; do
    column=0
    while [ $column -lt "$columns" ]; do
      left=$((width * column / columns)) right=$((width * (column + 1) / columns))
      top=$((height * row / rows)) bottom=$((height * (row + 1) / rows))
      "$pave" lay "$drawing" --quiet "$@" --window $left,$top,$((right - left)),$((bottom - top)) \
        -o "$work/part-$column-$row.svg" -o "$work/part-$column-$row.stones"
      column=$((column + 1))
    done
    row=$((row + 1))
  done
  polygons "$work/whole.svg" >"$work/whole"
  polygons "$work"/part-*.svg >"$work/parts"
  if cmp "$work/whole" "$work/parts"; then
    echo "$columns x $rows windows, $*: the same $(wc -l <"$work/whole") stones"
  else
    echo "$columns x $rows windows, $*: differ" >&2
    failed=1
  fi
  "$pave" merge "$work"/part-*.stones --quiet -o "$work/merged.svg" -o "$work/merged.stones"
  "$pave" merge "$work/merged.stones" --quiet -o "$work/again.svg"
  cmp "$work/whole.svg" "$work/merged.svg" && cmp "$work/whole.svg" "$work/again.svg" ||
    { echo "$columns x $rows windows, $*: merged, they differ" >&2; failed=1; }
}

compare 2 2 --half-side 4
compare 5 3 --half-side 2 --iterations 4 --relaxation 1.6
compare 2 2 --mode best --half-side 1.3 --iterations 2 --threads 2
drawing=$work/strip.png height=120
compare 5 3 --mode best --half-side 1.2 --iterations 3 --grout 0.3 --thin widen --thin-width 1.6 --threads 7
drawing=$root/examples/drawings/copacabana.png height=640
compare 3 1 --half-side 1.7 --iterations 3 --passes 0 --grout 0
compare 2 2 --half-side 2.5 --iterations 5 --metric euclid --seed 9 --threads 7 --backend cpu-portable
for backend in vulkan-compute vulkan-raster gles; do
  if "$pave" info | grep "^$backend " | grep -qv 'not usable'; then
    compare 3 1 --half-side 2 --iterations 3 --backend $backend
  fi
done

# A merge knows what does not belong together
spoil() { # spoil STATUS WORDS PART...
  status=$1 words=$2 code=0
  shift 2
  "$pave" merge "$@" -o "$work/x.svg" 2>"$work/err" || code=$?
  [ $code -eq "$status" ] && grep -q "$words" "$work/err" ||
    { echo "merge $*: $code, $(cat "$work/err")" >&2; failed=1; }
  rm -f "$work/x.svg"
}
"$pave" lay "$drawing" --half-side 9 --iterations 1 --quiet --window 0,0,100,640 -o "$work/a.stones"
"$pave" lay "$drawing" --half-side 9 --iterations 1 --quiet --window 50,0,974,640 -o "$work/b.stones"
"$pave" lay "$drawing" --half-side 9 --iterations 2 --quiet --window 100,0,924,640 -o "$work/c.stones"
head -c 9000 "$work/a.stones" >"$work/cut.stones"
spoil 3 "comes twice" "$work/a.stones" "$work/b.stones"
spoil 3 "belongs to another pavement" "$work/a.stones" "$work/c.stones"
spoil 3 "size is wrong" "$work/cut.stones"
spoil 3 "is not a file of stones" "$drawing"
spoil 3 "No such file" "$work/missing.stones"
"$pave" lay "$drawing" --half-side 9 --iterations 1 --quiet --window 200,0,100,640 -o "$work/d.stones"
spoil 0 "some are missing" "$work/a.stones" "$work/d.stones"

refuse() {
  code=0
  "$pave" lay "$drawing" --window "$1" -o "$work/x.svg" 2>"$work/err" || code=$?
  [ $code -eq 2 ] && grep -q window "$work/err" && [ ! -e "$work/x.svg" ] ||
    { echo "--window $1: $code, $(cat "$work/err")" >&2; failed=1; }
}
for window in 0,0,2000,10 -1,0,5,5 5,5,0,5 1,2,3 1,2,3,4,5 a,b,c,d 0,0,99999999999,1; do
  refuse "$window"
done
exit $failed
