#!/bin/sh
# Hostile files: no crash, no hang, little memory, one line or stones, a documented exit code.
. "$1/tests/cli/prologue.sh"
[ -d "${PAVE_SHARED:-}/data/hostile" ] || skip "PAVE_SHARED names no folder with data/hostile"
for file in "$PAVE_SHARED"/data/hostile/*; do
  code=0
  (ulimit -v 4000000; exec timeout 20 "$build/bin/pave" lay "$file" --quiet -o "$work/x.svg") >"$work/out" 2>"$work/err" || code=$?
  lines=$(wc -l <"$work/err")
  case $code in
    0) [ -s "$work/x.svg" ] && [ "$lines" -eq 0 ] || { echo "$file: 0, but no stones or noise"; failed=1; } ;;
    3 | 4) [ "$lines" -eq 1 ] && [ ! -e "$work/x.svg" ] && grep -qF "$(basename "$file")" "$work/err" ||
      { echo "$file: $code, but $(cat "$work/err")"; failed=1; } ;;
    *) echo "$file: ended with $code: $(cat "$work/err")"; failed=1 ;;
  esac
  [ ! -s "$work/out" ] || { echo "$file: wrote to stdout"; failed=1; }
  printf '%s %-28s %s\n' "$code" "$(basename "$file")" "$(cut -c1-120 "$work/err" | sed 's,.*hostile/,,')"
  rm -f "$work/x.svg"
done
exit $failed
