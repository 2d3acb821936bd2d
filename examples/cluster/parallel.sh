#!/bin/sh
# Lays a large pavement with GNU parallel on one machine.
# usage: parallel.sh DRAWING OUT.svg [PAVE LAY OPTION ...]
set -eu
drawing=$1 out=$2
shift 2
shards=$(pave plan "$drawing" -o "$out.plan.json" --memory 1G "$@")
seq 0 $((shards - 1)) | parallel --halt now,fail=1 pave lay --manifest "$out.plan.json" --shard {} --quiet
pave merge --manifest "$out.plan.json" -o "$out"
