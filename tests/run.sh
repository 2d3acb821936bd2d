#!/bin/sh
# Installs what is missing (Debian 12), builds libpave and runs every test through ctest: a release build with all
# tests, then the unit tests again under the address, undefined-behaviour and thread sanitizers.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/examples/setup.sh"
need_packages $pave_build_packages $pave_test_packages
# Slurm's daemons cannot be set up everywhere, as where other users may not enter the root; its test then skips.
need_packages $pave_cluster_packages || echo "Slurm cannot be installed" >&2

# Drawings and judges that are too large for the project; tests that need them say so and skip without.
if [ -z "${PAVE_SHARED:-}" ] && [ -d "$root/../shared/data" ]; then
  PAVE_SHARED=$(cd "$root/../shared" && pwd)
fi
export PAVE_SHARED="${PAVE_SHARED:-}"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export MESA_SHADER_CACHE_DIR="$scratch" XDG_RUNTIME_DIR="$scratch"

# run_tests BUILD CTEST-OPTION...
run_tests() {
  tested=$1
  shift
  (cd "$tested" && ctest --output-on-failure --no-tests=error -j "$(nproc)" "$@")
}

for sanitizer in address,undefined thread; do
  build="$root/build/$(echo $sanitizer | tr , -)"
  echo "== unit tests with -fsanitize=$sanitizer"
  build_pave "$root" "$build" -DCMAKE_BUILD_TYPE=RelWithDebInfo -DPAVE_SANITIZE=$sanitizer -DPAVE_WERROR=ON \
    -DPAVE_BENCH=OFF
  run_tests "$build" -L "sanitize|${sanitizer%%,*}"
done

echo "== all tests"
build_pave "$root" "$root/build/test" -DCMAKE_BUILD_TYPE=Release -DPAVE_WERROR=ON
run_tests "$root/build/test"

# Drivers are installed above, so the tests of the devices have no excuse.
for device in Vulkan GLES; do
  if ! grep "the $device backend ran:" "$root/build/test/Testing/Temporary/LastTest.log"; then
    echo "the $device tests did not run" >&2
    exit 1
  fi
done
