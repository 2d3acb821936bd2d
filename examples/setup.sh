# Sourced by quickstart.sh and tests/run.sh: installs the Debian packages that are missing.

pave_build_packages="libopenblas0 cmake make gcc g++ libc6-dev libopenexr-dev libopenimageio-dev zlib1g-dev libpng-dev libjpeg-dev libcjson-dev libkissfft-dev libvulkan-dev glslang-tools
  mesa-vulkan-drivers libegl-dev libgles-dev libegl1 libgles2 libegl-mesa0 libgl1-mesa-dri"
pave_test_packages="libcmocka-dev pkg-config python3 python3-numpy python3-pil python3-shapely python3-cffi
  vulkan-validationlayers parallel"
pave_cluster_packages="slurmctld slurmd slurm-client munge"

# need_packages PACKAGE...
need_packages() {
  missing=
  for package in "$@"; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing="$missing $package"
  done
  [ -n "$missing" ] || return 0
  as_root=
  if [ "$(id -u)" -ne 0 ]; then
    if ! sudo -n true 2>/dev/null; then
      echo "missing packages; as root, run: apt-get install$missing" >&2
      return 1
    fi
    as_root="sudo -n"
  fi
  echo "installing:$missing"
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq update >/dev/null
  # shellcheck disable=SC2086
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq -y --no-install-recommends install $missing >/dev/null
}

# build_pave SOURCE BUILD [CMAKE OPTION...]: quiet unless it fails.
build_pave() {
  pave_source=$1 pave_build=$2
  shift 2
  mkdir -p "$pave_build"
  if ! { cmake -S "$pave_source" -B "$pave_build" "$@" && cmake --build "$pave_build" -j "$(nproc)"; } \
      >"$pave_build/log" 2>&1; then
    tail -n 40 "$pave_build/log" >&2
    echo "the build failed; the whole log is $pave_build/log" >&2
    return 1
  fi
}
