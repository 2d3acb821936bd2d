#!/bin/sh
# An installed libpave as its users find it: pkg-config (shared and static), CMake, headers alone, FFI, the module.
set -eu
root=$(cd "$1" && pwd) build=$(cd "$2" && pwd)
here=$root/tests/install
work=$(mktemp -d "${TMPDIR:-/tmp}/pave install.XXXXXX")
trap 'rm -rf "$work"' EXIT
cmake --install "$build" --prefix "$work/prefix" >"$work/log"
lib=$(dirname "$(find "$work/prefix" -name libpave.so)")
drawing=$root/examples/drawings/copacabana.png

echo "pkg-config, C11"
cd "$work"
ln -s prefix p # a compiler's flags do not take spaces
export PKG_CONFIG_PATH=$(find p/ -name pkgconfig)
pkg-config --validate pave
flags() { pkg-config --define-variable=prefix=p "$@" pave; }
if cc -std=c11 "$root/examples/lay.c" -o nothing 2>/dev/null; then
  echo "the example builds without pkg-config: the test proves nothing" >&2
  exit 1
fi
cc -std=c11 -Wall -Wextra -Wpedantic -Werror $(flags --cflags) "$root/examples/lay.c" $(flags --libs) -o c11
LD_LIBRARY_PATH=$lib ./c11 "$drawing" c11.svg >c11.out
[ "$(wc -l <c11.out)" -eq 3 ]

echo "pkg-config, static"
cc -std=c11 $(flags --cflags) "$root/examples/lay.c" -o static "$lib/libpave.a" $(pkg-config --static --libs-only-l pave | sed 's/-lpave//')
mkdir -p modules && ln -s "$lib/pave" pave
./static "$drawing" static.svg >static.out
cmp c11.svg static.svg

echo "C++17"
cat >cpp.cpp <<'EOF'
#include <pave/pave.h>
int main()
{
    pave_context_params params;
    pave_context_params_init(&params, sizeof params);
    pave_context *context = nullptr;
    pave_result result = pave_context_create(&params, &context);
    pave_context_free(&context);
    return result;
}
EOF
c++ -std=c++17 -Wall -Wextra -Wpedantic -Werror $(flags --cflags) cpp.cpp $(flags --libs) -o cpp
LD_LIBRARY_PATH=$lib ./cpp

echo "CMake"
mkdir consumer
cat >consumer/CMakeLists.txt <<EOF
cmake_minimum_required(VERSION 3.25)
project(consumer C CXX)
find_package(Pave 0.1 REQUIRED)
add_executable(shared "$root/examples/lay.c")
target_link_libraries(shared PRIVATE Pave::pave)
add_executable(static "$root/examples/lay.c")
target_link_libraries(static PRIVATE Pave::pave_static)
EOF
cmake -S consumer -B consumer/build -DCMAKE_PREFIX_PATH="$work/prefix" >>log
cmake --build consumer/build >>log
consumer/build/shared "$drawing" cmake.svg >cmake.out
cmp c11.svg cmake.svg

echo "the installed program, moved"
mv prefix elsewhere
elsewhere/bin/pave lay "$drawing" --half-side 5 --quiet -o moved.svg
cmp c11.svg moved.svg

echo "FFI: the headers as they stand, through cffi"
/usr/bin/python3 "$here/ffi.py" "$work/elsewhere" "$work"
