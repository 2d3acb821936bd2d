#!/bin/sh
# BTFs on the command line: through every format and back, and as the independent reader finds them.
. "$1/tests/cli/prologue.sh"
"$pave" btf synthesize --class gravel --texels 8 --directions ubo81 --seed 3 -o a.bdi -q
"$pave" btf convert a.bdi -o a.exr -q
"$pave" btf convert a.exr -o folder/ -q
"$pave" btf convert folder -o b.bdi -q
cmp a.bdi b.bdi || fail "through OpenEXR and a folder something was lost"
[ "$(find folder -name '*.exr' | wc -l)" -eq 6561 ] || fail "a folder has not the pictures it should have"
[ -z "$(find . -name '.pave-*')" ] || fail "something was left behind"

rm folder/tv000_pv000/tl075_pl000_tv000_pv000.exr
"$pave" btf info folder --json >info.json 2>said
grep -q '1 of 6561 pairs' said || fail "a missing picture was not told of"
grep -q '"missing": 1,' info.json || fail "a missing picture was not counted"

refuses() { # refuses CODE ARGUMENTS...
  code=$1
  shift
  status=0
  "$pave" btf "$@" 2>said || status=$?
  [ "$status" -eq "$code" ] && [ "$(wc -l <said)" -eq 1 ] || fail "pave btf $*: $status, $(cat said)"
}
head -c 3000 a.bdi >cut.bdi
printf 'PK\3\4nothing' >ptm.btf
mkdir empty
for input in cut.bdi ptm.btf empty nowhere; do
  refuses 3 convert "$input" -o c.bdi -q
done
refuses 2 view a.bdi -q
[ ! -e c.bdi ] || fail "a refused input left an output"

"$pave" btf view a.bdi --side 32 -o view.png -q
"$pave" btf plot a.bdi -o plot.png -q
"$pave" btf sheet a.bdi --tile 8 -o sheet.png -q
ldconfig -p | grep -q libopenblas.so.0 || skip "OpenBLAS is not installed"
"$pave" btf compress a.bdi --components 20,10,10 -o a.btf -q
"$pave" btf compress a.bdi --components 20 --joint -o joint.btf -q
"$pave" btf view a.btf --against a.bdi --side 32 -o difference.png -q
"$pave" btf merge a.btf a.btf --components 30 -o merged.btf -q

[ -f "${PAVE_SHARED:-}/check/check_btf.py" ] || skip "PAVE_SHARED names no folder with check/check_btf.py"
for file in a.btf joint.btf; do
  "$pave" btf measure "$file" a.bdi --json >ours.json
  /usr/bin/python3 "$PAVE_SHARED/check/check_btf.py" "$file" a.bdi --json >theirs.json
  /usr/bin/python3 - <<'END' || fail "the independent reader disagrees about $file"
import json
ours, theirs = json.load(open("ours.json")), json.load(open("theirs.json"))
for key in ("rmse", "rmse_log", "relative"):
    assert abs(ours[key] - theirs[key]) <= 1e-4 * theirs[key], (key, ours[key], theirs[key])
assert theirs["direction_error"] < 1e-4
END
done
echo "the independent reader agrees"
exit $failed
