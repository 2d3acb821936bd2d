#!/bin/sh
# Windows that share out the plane share out its stones: nothing twice, nothing missing, every polygon the same.
set -eu
root=$(cd "$1" && pwd) build=$(cd "$2" && pwd)
pave=$build/bin/pave
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0
drawing=$root/examples/drawings/copacabana.png
width=1024 height=640

polygons() { grep -h '<polygon' "$@" | LC_ALL=C sort; }

# compare COLUMNS ROWS OPTION...: the windows of a grid against the whole
compare() {
  columns=$1 rows=$2
  shift 2
  rm -f "$work"/part-*.svg
  "$pave" lay "$drawing" --quiet "$@" -o "$work/whole.svg"
  row=0
  while [ $row -lt "$rows" ]; do
    column=0
    while [ $column -lt "$columns" ]; do
      left=$((width * column / columns)) right=$((width * (column + 1) / columns))
      top=$((height * row / rows)) bottom=$((height * (row + 1) / rows))
      "$pave" lay "$drawing" --quiet "$@" --window $left,$top,$((right - left)),$((bottom - top)) \
        -o "$work/part-$column-$row.svg"
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
}

compare 2 2 --half-side 4
compare 5 3 --half-side 2 --iterations 4
compare 3 1 --half-side 1.7 --iterations 3 --passes 0 --grout 0
compare 2 2 --half-side 2.5 --iterations 5 --metric euclid --seed 9 --threads 7 --backend cpu-portable
if "$pave" info | grep -q '^vulkan-compute *[^n]'; then
  compare 3 2 --half-side 2 --iterations 4 --backend vulkan-compute
fi

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
