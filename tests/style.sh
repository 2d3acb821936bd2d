#!/bin/sh
# The house rules that can be told by reading: which folder may include which, where foreign headers may appear, what
# the library must never call, and how lines look.
set -eu
cd "$1"
failed=0
complain() {
  echo "$1" >&2
  failed=1
}
none() { # none WHAT GREP-ARGUMENTS...: complains about each line found
  what=$1
  shift
  found=$(grep -rnE "$@" || true)
  [ -z "$found" ] || complain "$what:
$found"
}

# util < base < image < backend < field < cvd < stones < { mosaic, tiling, solid, statistics < btf } < maps < io
below_util="util" below_base="$below_util base" below_image="$below_base image" below_backend="$below_image backend"
below_field="$below_backend field" below_cvd="$below_field cvd" below_stones="$below_cvd stones"
below_mosaic="$below_stones mosaic" below_tiling="$below_stones tiling" below_solid="$below_stones solid"
below_statistics="$below_stones statistics" below_btf="$below_statistics btf"
below_maps="$below_btf mosaic tiling solid maps" below_io="$below_maps io"
for folder in lib/*/; do
  layer=$(basename "$folder")
  eval "allowed=\${below_$layer:-}"
  [ -n "$allowed" ] || complain "lib/$layer is in no layer"
  others=$(grep -rhoE '^#include "[a-z]+/' "$folder" | sed 's/#include "//; s,/,,' | sort -u)
  for other in $others; do
    case "$layer/$other" in */shaders) [ "$layer" = backend ] && continue ;; esac
    case " $allowed " in *" $other "*) ;; *) complain "lib/$layer includes from $other" ;; esac
  done
done

none "util must not know the context" '#include [<"](pave/(context|params|image|field|stones|io|pave)|base/)' lib/util
none "Vulkan headers only in lib/backend/vulkan" '#include <vulkan' lib cli examples --include=*.[ch] --exclude-dir=vulkan
none "EGL and GLES headers only in lib/backend/egl" '#include <(EGL|GLES)' lib cli examples --include=*.[ch] --exclude-dir=egl
none "OpenImageIO only in lib/io/oiio.cpp" '#include <OpenImageIO' lib cli examples --exclude=oiio.cpp
none "libpng and libjpeg only in lib/io/png.c and jpeg.c" '#include <(png|jpeglib)' lib cli examples --exclude=png.c --exclude=jpeg.c
none "OpenEXR only in lib/io/exr*" '#include <openexr|#include <OpenEXR' lib cli examples --exclude='exr*.[ch]'
none "cli and examples include <pave/...> only" '#include "(util|base|image|backend|field|cvd|stones|mosaic|tiling|solid|statistics|btf|maps|io)/' cli examples
none "the library never prints, exits or touches the environment, the locale or signals" \
  '(^|[^a-z_])(printf|puts|putchar|perror|abort|exit|_exit|getenv|setenv|putenv|setlocale|signal|sigaction|system) ?\(' \
  lib --include=*.c --include=*.cpp --include=*.h
none "no global that can change" '^(static )?(int|int32_t|double|size_t|char|void \*)[a-z_ *]*(\[[^]]*\])?( = [^(]*)?;$' lib --include=*.c
none "only one C++ file" '' --include=*.cc --include=*.cxx -l lib cli
[ "$(find lib cli -name '*.cpp' | wc -l)" -eq 1 ] || complain "there is one C++ file: lib/io/oiio.cpp"
for file in $(git ls-files 2>/dev/null | grep -v /); do
  case $file in CMakeLists.txt | LICENSE | README.md | .*) ;; *) complain "$file does not belong into the top level" ;; esac
done
none "no tabs" "$(printf '\t')" lib cli include shaders examples tests --include=*.[ch] --include=*.cpp --include=*.glsl --include=*.comp --include=*.vert --include=*.frag --include=*.sh --include=*.txt
none "no space at the end of a line" ' +$' lib cli include shaders examples tests docs --include=*.[ch] --include=*.cpp --include=*.glsl --include=*.comp --include=*.vert --include=*.frag --include=*.sh --include=*.md --include=*.txt
none "no line beyond 120 columns" '^.{121,}$' lib cli include shaders --include=*.[ch] --include=*.cpp --include=*.glsl --include=*.comp --include=*.vert --include=*.frag
for file in lib/*/*.c lib/*/*.h lib/*/*/*.c cli/*.c include/pave/*.h; do
  head -c 2 "$file" | grep -q '^/\*' || complain "$file does not begin with its purpose"
done
exit $failed
