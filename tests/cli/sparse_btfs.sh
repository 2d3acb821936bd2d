#!/bin/sh
# Sparse BTFs on the command line: a model of a folder, plans, reconstructions, and what is refused.
. "$1/tests/cli/prologue.sh"
# A folder with the pictures of a BTF that a plan wants, and a name for each
photograph() {
  "$pave" btf convert "$1" -o all/ -q
  mkdir "$3"
  tail -n +2 "$2" | /usr/bin/python3 -c '
import pathlib, shutil, sys
whole = sorted(pathlib.Path("all").rglob("*.exr"))
import re
def key(tl, pl, tv, pv): return round(float(tl)) % 360, round(float(pl)) % 360, round(float(tv)) % 360, round(float(pv)) % 360
by = {key(*re.findall(r"t[lv](-?[0-9.]+)_p[lv](-?[0-9.]+)", p.stem)[0], *re.findall(r"t[lv](-?[0-9.]+)_p[lv](-?[0-9.]+)", p.stem)[1]): p for p in whole}
for line in sys.stdin:
    n, v, l, tv, pv, tl, pl, _ = line.split(",")
    shutil.copy(by[key(tl, pl, tv, pv)], sys.argv[1])
' "$3"
  rm -r all
}
ldconfig -p | grep -q libopenblas.so.0 || skip "OpenBLAS is not installed"
mkdir class
for seed in 1 2 3; do
  "$pave" btf synthesize --class tile --texels 6 --seed $seed --bounces 0 -o class/$seed.bdi -q
done
"$pave" btf synthesize --class tile --texels 6 --seed 4 --bounces 0 -o whole.bdi -q
small="--components 60 --abrdfs 40 --material 20 --stride 1 -q"
"$pave" btf model class $small -o tile.model --json >model.json
"$pave" btf model class/1.bdi class/2.bdi class/3.bdi $small --threads 1 -o again.model
cmp tile.model again.model || fail "files by name and threads make another model"
grep -q '"materials": 3,' model.json && grep -q '"copies": 4,' model.json || fail "the model's report"
"$pave" btf info tile.model | grep -q eigen-ABTFs || fail "info does not tell of a model"

"$pave" btf plan tile.model --samples 120 -o plan.csv -q
[ "$(wc -l <plan.csv)" -eq 121 ] && grep -q '^number,view,light,view_theta' plan.csv || fail "a plan has not its lines"
"$pave" btf plan tile.model --samples 120 -o - -q | cmp - plan.csv || fail "a plan on standard output"
"$pave" btf plan tile.model --samples 450 --method parabolic -o map.csv -q
[ "$(wc -l <map.csv)" -eq 442 ] || fail "21 x 21 directions of a map of 5 x 5 cells"
"$pave" btf plan tile.model --samples 60 --method swap --steps 10 -o swap.csv 2>said
grep -q 'condition number' said || fail "swap does not tell its condition number"
"$pave" btf plan tile.model --samples 60 --dome -o dome.csv -q

"$pave" btf reconstruct tile.model whole.bdi --plan plan.csv -o best.bdi --errors errors.exr -q
"$pave" btf reconstruct tile.model whole.bdi --plan plan.csv --mode paper -o paper.exr -q
"$pave" btf reconstruct tile.model whole.bdi --mode project -o least.bdi -q
for file in best.bdi paper.exr least.bdi; do
  "$pave" btf measure $file whole.bdi --epsilon 0.00032 --texels 0 --json >$file.json
done
[ -s errors.exr ] || fail "no picture of errors"
/usr/bin/python3 - <<'END' || fail "errors are not in their order"
import json
least, best, paper = (json.load(open(f + ".json")) for f in ("least.bdi", "best.bdi", "paper.exr"))
assert best["centred"] < 0.6 and abs(best["relative"] * best["whole"] - best["centred"] * best["variation"]) < 1e-3
assert best["relative"] < paper["relative"] and least["relative"] < 1.5 * best["relative"]
END

# What a laboratory brings home: a folder with the planned pictures only, and a name for each.
photograph whole.bdi plan.csv sparse
"$pave" btf reconstruct tile.model sparse -o lab.bdi -q
"$pave" btf measure lab.bdi best.bdi --json >lab.json
/usr/bin/python3 -c 'import json; assert json.load(open("lab.json"))["rmse"] < 2e-3' || fail "pictures give another BTF"

mkdir mixed
for class in polished grooved; do
  for seed in 1 2; do
    "$pave" btf synthesize --class $class --texels 6 --seed $seed --bounces 0 -o mixed/$class-$seed.bdi -q
  done
done
"$pave" btf model mixed --clusters 2 $small --patch 1 -o found --json >classes.json
[ -s found/1.model ] && [ -s found/2.model ] || fail "not a model for each class"
/usr/bin/python3 - <<'END' || fail "classes are not those of the materials"
import json
found = {m["path"]: m["class"] for m in json.load(open("classes.json"))["materials"]}
assert sorted(found.values()) == [1, 1, 2, 2]
assert found["mixed/polished-1.bdi"] == found["mixed/polished-2.bdi"] != found["mixed/grooved-1.bdi"]
END

refuses() { # refuses CODE WORDS ARGUMENTS...
  code=$1 words=$2
  shift 2
  status=0
  "$pave" btf "$@" 2>said || status=$?
  [ "$status" -eq "$code" ] && [ "$(wc -l <said)" -eq 1 ] && grep -q "$words" said ||
    fail "pave btf $*: $status, $(cat said)"
}
"$pave" btf synthesize --class tile --texels 4 --directions dome151 --bounces 0 -o dome.bdi -q
head -c 20000 tile.model >cut.model
printf 'view,light\n0,99\n' >wrong.csv
mkdir empty
refuses 2 'at least 7' reconstruct tile.model whole.bdi --plan plan.csv --mode paper --samples 6 -o x.bdi -q
refuses 2 'other directions' reconstruct tile.model dome.bdi -o x.bdi -q
refuses 3 'cut short' reconstruct cut.model whole.bdi -o x.bdi -q
cp whole.bdi lies.model
refuses 3 'not a model' plan lies.model -o x.csv -q
refuses 3 'cannot be read' plan none.bdi -o x.csv -q
refuses 3 'line 2' reconstruct tile.model whole.bdi --plan wrong.csv -o x.bdi -q
refuses 3 'no BTF' model empty -o x.model -q
refuses 2 'directions' model class/1.bdi dome.bdi -o x.model -q
refuses 2 'odd' model class --patch 2 -o x.model -q
refuses 2 '6561 pairs' plan tile.model --samples 7000 -o x.csv -q
refuses 2 'complete' reconstruct tile.model sparse --mode project -o x.bdi -q
[ ! -e x.bdi ] && [ ! -e x.csv ] && [ ! -e x.model ] || fail "a refused job left an output"
[ -z "$(find . -name '.pave-*')" ] || fail "something was left behind"

# A large piece from a small region and photographs of all of it
"$pave" btf synthesize --class tile --texels 40 --seed 5 --bounces 0 --window 8,8,24,24 -o sample.bdi -q
"$pave" btf synthesize --class tile --texels 40 --seed 5 --bounces 0 -o large.bdi -q
"$pave" btf plan sample.bdi --samples 4 -o shots.csv -q
[ "$(wc -l <shots.csv)" -eq 5 ] || fail "a plan by a sample"
photograph large.bdi shots.csv photographs
few="--components 16 --x 8 --y 8"
"$pave" btf enlarge sample.bdi --constraints photographs $few -o error.btf --json >error.json
"$pave" btf enlarge sample.bdi --constraints photographs $few --threads 1 -o again.btf -q
cmp error.btf again.btf || fail "threads enlarge otherwise"
"$pave" btf enlarge sample.bdi --constraints photographs $few --aim look -o look.btf --json >look.json
"$pave" btf enlarge sample.bdi --constraints photographs $few --mode paper --stage 1 -o text.btf | grep -q rounds ||
  fail "no report in words"
for file in error.btf text.btf; do
  "$pave" btf measure $file large.bdi --epsilon 0.0032 --texels 0 --json >$file.json
done
/usr/bin/python3 - <<'END' || fail "enlargements are not as they should be"
import json
error, look = json.load(open("error.json")), json.load(open("look.json"))
assert error["photographs"] == 4 and 0.2 < error["explained"] < 1
assert look["sharpness"] > error["sharpness"]
best, text = (json.load(open(f"{f}.btf.json"))["centred"] for f in ("error", "text"))
assert best < text < 2, (best, text)
END
refuses 2 'not one photograph' enlarge sample.bdi -o x.btf -q
refuses 2 'does not lie in a whole of 40 x 40' enlarge sample.bdi --constraints photographs --x 30 --y 8 -o x.btf -q
refuses 2 'too few' enlarge dome.bdi --constraints photographs -o x.btf -q
refuses 3 'cannot be read' enlarge sample.bdi --constraints none -o x.btf -q
exit $failed
