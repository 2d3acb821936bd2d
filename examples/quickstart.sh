#!/bin/sh
# Installs what is missing (Debian 12), builds a release of libpave, and lays the Copacabana sidewalk.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/examples/setup.sh"

need_packages $pave_build_packages
build_pave "$root" "$root/build/release" -DCMAKE_BUILD_TYPE=Release -DPAVE_TESTS=OFF -DPAVE_BENCH=OFF

out="$root/build/quickstart"
mkdir -p "$out"
"$root/build/release/bin/pave" lay "$root/examples/drawings/copacabana.png" --quiet \
  -o "$out/copacabana.svg" -o "$out/copacabana.png"

echo "built the program:       $root/build/release/bin/pave"
echo "laid $(grep -c '<polygon' "$out/copacabana.svg") stones:        $out/copacabana.svg"
echo "and a picture of them:   $out/copacabana.png"
