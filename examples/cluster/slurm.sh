#!/bin/sh
# Lays a large pavement as a Slurm job array, and merges when all shards are there. Shards may fail or be requeued:
# submit again, and only what is missing is laid.
# usage: slurm.sh DRAWING OUT.svg [PAVE LAY OPTION ...]      (DRAWING and OUT on a file system that all nodes share)
set -eu
drawing=$1 out=$2
shift 2
shards=$(pave plan "$drawing" -o "$out.plan.json" --memory 1G "$@")
array=$(sbatch --parsable --requeue --cpus-per-task=2 --mem=1200M --array="0-$((shards - 1))" \
  --wrap "pave lay --manifest '$out.plan.json' --shard \$SLURM_ARRAY_TASK_ID --threads 2 --quiet")
sbatch --dependency="afterok:$array" --mem=500M --wrap "pave merge --manifest '$out.plan.json' -o '$out'"
