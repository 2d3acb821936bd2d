#!/bin/sh
# Every command that the README and the docs show in a ```sh block runs, in a copy of the project where it may write.
set -eu
root=$(cd "$1" && pwd) build=$(cd "$2" && pwd)
work=$(mktemp -d "${TMPDIR:-/tmp}/pave docs.XXXXXX")
trap 'rm -rf "$work"' EXIT
cp "$root/examples/drawings/copacabana.png" "$work/drawing.png"
cp "$root/examples/drawings/copacabana.png" "$work/photo.png"
"$build/bin/pave" lay "$work/drawing.png" -o "$work/stone.png" --half-side 9 --window 0,0,128,128 --quiet
cp "$root/examples/lay.c" "$work/lay.c"
cp -r "$root/examples" "$work/examples"
cmake --install "$build" --prefix "$work/prefix" >/dev/null
PATH=$work/prefix/bin:$PATH
failed=0
cd "$work"
for page in "$root/README.md" "$root"/docs/*.md; do
  awk '/^```sh$/ {show = 1; next} /^```/ {show = 0} show' "$page" >commands
  while IFS= read -r command; do
    case $command in
      '' | '#'*) continue ;;
      # commands that this test is part of or that install, and set-up of a machine
      'sh examples/quickstart.sh' | 'sh tests/'* | 'cmake '* | 'sudo '* | 'build/'* | '../shared/'* | 'cc '*) continue ;;
    esac
    if ! sh -c "$command" >said 2>&1 </dev/null; then
      echo "$page: $command" >&2
      cat said >&2
      failed=1
    fi
  done <commands
done
exit $failed
