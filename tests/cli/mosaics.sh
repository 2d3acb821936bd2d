#!/bin/sh
# Every photo in 2000 tiles against its bars, without joints and with; maps of sizes; the independent judge agrees.
. "$1/tests/cli/prologue.sh"
[ -f "${PAVE_SHARED:-}/check/check_mosaic.py" ] || skip "PAVE_SHARED names no folder with check/check_mosaic.py"
photos=$PAVE_SHARED/data/photos
judge() {
  /usr/bin/python3 "$PAVE_SHARED/check/check_mosaic.py" "$@"
}
for photo in "$photos"/*; do
  name=$(basename "$photo")
  "$pave" mosaic "$photo" --joint 0 --quiet -o mosaic.json
  /usr/bin/python3 "$root/tests/cli/mosaics.py" "$name, no joints" 0.99 mosaic.json || failed=1
  "$pave" mosaic "$photo" --joint 0.05 --quiet -o mosaic.json -o mosaic.svg
  tiles=$(sed -n 's/^  "tiles": \([0-9]*\),/\1/p' mosaic.json) # chips come after them
  awk -v tiles="$tiles" '!/<polygon/ || seen++ < tiles' mosaic.svg >tiles.svg
  judge "$photo" mosaic.svg --json >judge.json
  cmp -s mosaic.svg tiles.svg && cp judge.json tiles.json || judge "$photo" tiles.svg --json >tiles.json
  /usr/bin/python3 "$root/tests/cli/mosaics.py" "$name" 0.89 mosaic.json judge.json tiles.json || failed=1
done
for name in astronaut.png munch-the-scream.jpg; do
  "$pave" mosaic "$photos/$name" --size-from detail --quiet -o mosaic.json
  /usr/bin/python3 "$root/tests/cli/mosaics.py" "$name, sizes by detail" 0.89 mosaic.json || failed=1
done
exit $failed
