#!/bin/sh
# The shared library exports just the functions of the public headers, and they are those of tests/exports.txt.
set -eu
root=$(cd "$1" && pwd) build=$(cd "$2" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
nm -D --defined-only "$build/lib/libpave.so" | awk '$2 ~ /[TDBR]/ {sub(/@.*/, "", $3); print $3}' | LC_ALL=C sort >"$work/exported"
cat "$root"/include/pave/*.h | tr '\n' ' ' | grep -oE 'PAVE_API [^;]*;' | grep -oE 'pave_[a-z0-9_]+ ?\(' | tr -d ' (' |
  LC_ALL=C sort -u >"$work/declared"
diff "$work/declared" "$work/exported" || { echo "headers (<) and library (>) differ" >&2; exit 1; }
diff "$root/tests/exports.txt" "$work/exported" || { echo "exports.txt (<) and library (>) differ" >&2; exit 1; }
readelf -d "$build/lib/libpave.so" | grep -q 'SONAME.*libpave\.so\.0' || { echo "wrong SONAME" >&2; exit 1; }
if readelf -d "$build/lib/libpave.so" | grep NEEDED | grep -E 'OpenImageIO|vulkan|EGL|GLES|stdc'; then
  echo "libpave must not need these" >&2
  exit 1
fi
