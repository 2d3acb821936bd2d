#!/bin/sh
# Measures libpave against what else there is: pairs in turn, the least time of each, and their ratio.
#
# usage: sh tests/bench/run.sh [--quick] [--long] [--json FILE] [--build DIR]
#
# Installs what is missing (Debian 12; d3-delaunay through npm, if that works), builds a release, prints a table in
# Markdown. --quick: small cases, with what is installed, in seconds; --long: memory of 64 Mpx, too; --build: measure this build.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
here=$root/tests/bench
. "$root/examples/setup.sh"

quick='' long='' json='' build=''
while [ $# -gt 0 ]; do
  case $1 in
    --quick) quick=$1 ;;
    --long) long=$1 ;;
    --json) json=$2 && shift ;;
    --build) build=$2 && shift ;;
    *) echo "usage: sh tests/bench/run.sh [--quick] [--long] [--json FILE] [--build DIR]" >&2 && exit 2 ;;
  esac
  shift
done

if [ -z "$quick" ]; then
  need_packages $pave_build_packages python3 python3-numpy python3-pil python3-cffi \
    python3-opencv python3-scipy libcgal-dev gegl time
  command -v npm >/dev/null || need_packages nodejs npm
fi
if [ -z "$build" ]; then
  build=$root/build/release
  build_pave "$root" "$build" -DCMAKE_BUILD_TYPE=Release -DPAVE_TESTS=OFF -DPAVE_BENCH=ON
fi

# The rivals that are programs of their own.
mkdir -p "$build/bench"
cp "$here/delaunay.mjs" "$build/bench"
if [ -z "$quick" ]; then
  c++ -O3 -DNDEBUG -march=native "$here/delaunay.cpp" -o "$build/bench/delaunay" -lgmp -lmpfr
  (cd "$build/bench" && npm install --silent --no-audit --no-fund d3-delaunay@6) >/dev/null 2>&1 ||
    echo "npm cannot install d3-delaunay" >&2
fi

# Drivers keep their caches here; lavapipe has two threads.
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export LP_NUM_THREADS=2 MESA_SHADER_CACHE_DIR="$scratch" XDG_RUNTIME_DIR="$scratch" OMP_NUM_THREADS=2
echo "| what | pave | against | its time | ratio |"
echo "|---|---|---|---|---|"
for comparison in field lloyd job engines growth solid tiling; do
  /usr/bin/python3 "$here/$comparison.py" "$build" "$scratch" $quick $long
done

[ -z "$json" ] || /usr/bin/python3 - "$scratch/results" "$json" <<'END'
import json, pathlib, sys
parts = sorted(pathlib.Path(sys.argv[1]).glob("*.json"))
pathlib.Path(sys.argv[2]).write_text(json.dumps({part.stem: json.loads(part.read_text()) for part in parts}, indent=1))
END
