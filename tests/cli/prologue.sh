# What every test of the command line begins with: the project's root, its build and the program, a folder of its own to
# work in, which goes when the test ends; fail, after which a test goes on (its last line is exit $failed); and skip.
set -eu
root=$(cd "$1" && pwd) build=$(cd "$2" && pwd)
pave=$build/bin/pave
work=$(mktemp -d "${TMPDIR:-/tmp}/pave test.XXXXXX")
trap 'chmod -R u+w "$work"; rm -rf "$work"' EXIT
cd "$work"
failed=0
fail() {
  echo "FAILED: $*" >&2
  failed=1
}
skip() {
  [ $failed -eq 0 ] || exit 1
  echo "skipped: $1"
  exit 77
}
