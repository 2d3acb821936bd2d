#!/bin/sh
# pave maps as its users meet it: folders and models in and out, judged by other means; the same from all threads and
# windows; and what is refused.
. "$1/tests/cli/prologue.sh"
judge() {
  /usr/bin/python3 "$root/tests/cli/maps.py" "$@" || fail "maps.py $*"
}
drawing=$root/examples/drawings/copacabana.png
"$pave" lay "$drawing" -o s.stones -o s.svg --half-side 6 --window 20,10,80,60 --quiet
"$pave" lay "$drawing" -o rock.png --half-side 9 --window 0,0,64,64 --quiet
"$pave" lay "$root/examples/drawings/flowers.png" --periodic --half-side 12 --border cut -o cut.stones -o cut.svg --quiet
"$pave" lay "$root/examples/drawings/flowers.png" --periodic --half-side 8 -o tile.stones --quiet
"$pave" solid rock.png --size 24,24,24 --mode fast -o stone.nrrd --quiet
stones=$(grep -c '<polygon' s.svg)

# numbers, coverage, normals and occlusion are what other means find; as PNG there are the same maps
"$pave" maps s.stones -o exr/ --format exr --scale 3 --texture rock.png --quiet
judge maps s.svg exr
"$pave" maps cut.stones -o parts --format exr --scale 1.5 --normal down --quiet
judge maps cut.svg parts
"$pave" maps s.stones -o png/ -o again/ -o model.glb --scale 3 --texture rock.png --quiet --threads 1
"$pave" maps s.stones -o png/ -o model3.glb --scale 3 --texture rock.png --quiet --threads 3
for map in colour height normal roughness occlusion mask; do
  cmp png/$map.png again/$map.png || fail "threads change $map.png"
done
cmp png/id.exr again/id.exr && cmp model.glb model3.glb || fail "threads change files"
[ "$(ls png | tr '\n' ' ')" = "colour.png height.png id.exr maps.json mask.png normal.png occlusion.png roughness.png " ] ||
  fail "the folder holds $(ls png)"

# what lies in a folder already stays, and no other is left over
echo mine >png/notes.txt
"$pave" maps s.svg -o png --scale 1 --quiet
[ "$(cat png/notes.txt)" = mine ] && [ -z "$(find . -name '.pave*')" ] || fail "a folder is not left as it should"

# a window is the crop of the whole, and a plane that repeats does so to the byte
"$pave" maps s.stones -o part --scale 3 --window 41,22,17,30 --texture rock.png --quiet
judge crop again part
"$pave" maps tile.stones -o whole --scale 2 --volume stone.nrrd --joint-texture rock.png --quiet
"$pave" maps tile.stones -o shifted --scale 2 --volume stone.nrrd --joint-texture rock.png --window 100,70,60,80 --quiet
judge wraps whole shifted

# models: closed stones, right numbers, pictures that can be read
judge model model.glb "$stones"
"$pave" maps s.stones -o volume.glb --volume stone.nrrd --scale 2 --segments 4 --tilt 8 --lift 0.5 --quiet
judge model volume.glb "$stones"
"$pave" maps s.stones -o plain.glb --skin vertices --segments 0 --ground no --texture rock.png --texture rock.png --quiet
judge model plain.glb "$stones"
"$pave" maps tile.stones -o tile.glb --scale 1 --pixels-per-metre 3 --bevel 2 --quiet
judge model tile.glb

# what is refused: status and sentence
refuse() { # refuse STATUS WORDS ARGUMENTS...
  status=$1 words=$2
  shift 2
  got=0
  "$pave" maps "$@" --quiet 2>said || got=$?
  [ "$got" = "$status" ] || fail "pave maps $*: status $got, not $status"
  grep -q "$words" said || fail "pave maps $*: says $(cat said)"
  [ ! -e x ] && [ ! -e x.glb ] && [ -z "$(find . -name '.pave*')" ] || fail "pave maps $*: leaves a file"
  rm -rf x x.glb
}
printf '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"></svg>' >none.svg
printf '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><polygon fill="#fff" points="1,1 8,8 8,1 1,8"/></svg>' >crossed.svg
printf 'NRRD0004\ntype: float\ndimension: 3\nsizes: 1 1 2\nendian: little\nencoding: raw\n\n\000\000\200\077\000\000\300\177' >nan.nrrd
refuse 3 "no stones" none.svg -o x
refuse 3 "crosses itself" crossed.svg -o x.glb
refuse 3 "3 textures, but stones of 2 colours" s.stones -o x --texture rock.png --texture rock.png --texture rock.png
refuse 3 "not from both" s.stones -o x --texture rock.png --volume stone.nrrd
refuse 3 "has no value" s.stones -o x --volume nan.nrrd
refuse 3 "cannot be read" s.stones -o x --volume missing.nrrd
refuse 3 "cannot be read" missing.stones -o x
refuse 3 "must be whole" tile.stones -o x --scale 1.23
refuse 2 "0.015625 .. 64" s.stones -o x --scale 1000
refuse 4 "beyond the limit" s.stones -o x --scale 64 --max-pixels 1000000
refuse 4 "beyond the limit" s.stones -o x.glb --scale 64 --max-pixels 1000000
refuse 2 "where to" s.stones
refuse 2 "neither a folder" s.stones -o x.png
refuse 2 "no area" s.stones -o x --window 0,0,0,5
refuse 5 "Not a directory\|cannot be written" s.stones -o rock.png/
exit $failed
