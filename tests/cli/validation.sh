#!/bin/sh
# The Vulkan validation layer, with synchronisation validation, has nothing to say about a job, nor about what is done
# when a call to the driver fails.
. "$1/tests/cli/prologue.sh"
backends=$("$pave" info | sed -n 's/^\(vulkan-[a-z]*\) *[^n ].*/\1/p' | sort -u)
[ -n "$backends" ] || skip "no usable Vulkan device"
export VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation
export VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT
VK_LOADER_DEBUG=layer "$pave" info >"$work/loaded" 2>&1
grep -qi 'khronos_validation' "$work/loaded" || skip "the validation layer is not installed"
for backend in $backends; do
  for half_side in 2 4 40; do
    "$pave" lay "$root/examples/drawings/copacabana.png" --backend "$backend" --half-side $half_side --iterations 3 \
      --quiet -o "$work/x.svg" >"$work/said" 2>&1
    if [ -s "$work/said" ]; then
      cat "$work/said" >&2
      exit 1
    fi
  done
done
"$build/bin/test_faults" 'vulkan_raster*' >"$work/said" 2>&1 || { cat "$work/said" >&2; exit 1; }
if grep -iE 'VUID|validation|UNASSIGNED|SYNC-' "$work/said" >&2; then
  exit 1
fi
