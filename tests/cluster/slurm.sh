#!/bin/sh
# examples/cluster/slurm.sh for real, on one machine: munged, slurmctld and slurmd started here, on loopback, in a folder
# of their own; a third of the shards is cancelled while it runs, and the same command submitted again; the merge gives
# the bytes of the whole. Then examples/cluster/parallel.sh.
set -eu
root=$(cd "$1" && pwd) build=$(cd "$2" && pwd)
export PATH="$build/bin:/usr/sbin:$PATH"
for program in slurmctld slurmd munged sbatch parallel; do
  if ! command -v $program >/dev/null; then
    echo "skipped: $program is not installed"
    exit 77
  fi
done
if dpkg-query -W -f '${Status}\n' slurmctld slurmd munge 2>/dev/null | grep -qv ' installed$'; then
  echo "skipped: Slurm is only installed in part"
  exit 77
fi
if [ "$(id -u)" -ne 0 ]; then
  echo "skipped: the daemons need root"
  exit 77
fi
work=$(mktemp -d)
pids=
cleanup() {
  for pid in $pids; do
    kill "$pid" 2>/dev/null || true
  done
  wait
  rm -rf "$work"
}
trap cleanup EXIT
cd "$work"
mkdir munge state spool
chmod 700 munge
head -c 1024 /dev/urandom >munge/key
chmod 600 munge/key
chmod 755 "$work"
munged --foreground --force --key-file="$work/munge/key" --socket="$work/munge.socket" --pid-file="$work/munge.pid" \
  --log-file="$work/munge.log" --seed-file="$work/munge/seed" --num-threads=2 >munged.out 2>&1 &
pids="$pids $!"
host=$(hostname)
cat >slurm.conf <<EOF
ClusterName=pave
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=16817
SlurmdPort=16818
AuthType=auth/munge
AuthInfo=socket=$work/munge.socket
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SchedulerParameters=sched_interval=1,batch_sched_delay=0
MpiDefault=none
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=4000 State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
EOF
export SLURM_CONF="$work/slurm.conf"

status=77 failing="skipped: the daemons do not start here;" # from when they run on, a failure is a failure
wait_for() { # wait_for SECONDS COMMAND...
  left=$1
  shift
  until "$@" >/dev/null 2>&1; do
    left=$((left - 1))
    [ $left -gt 0 ] || { echo "$failing waited in vain for: $*"; tail -n 20 ./*.log munged.out; exit $status; }
    sleep 1
  done
}
wait_for 20 test -S munge.socket
slurmctld -D >ctld.out 2>&1 &
pids="$pids $!"
wait_for 20 scontrol ping
slurmd -D -N "$host" >slurmd.out 2>&1 &
pids="$pids $!"
wait_for 30 sh -c 'sinfo -h -o %t | grep -qx idle'

status=1 failing=
cp "$root/examples/drawings/copacabana.png" drawing.png
options="--mode paper --half-side 2 --iterations 3"
pave lay drawing.png $options --quiet -o whole.svg
submit() { sh "$root/examples/cluster/slurm.sh" "$work/drawing.png" "$work/laid.svg" $options --memory 170M; }
idle() { [ -z "$(squeue -h)" ]; }

submit
shards=$(/usr/bin/python3 -c 'import json; print(len(json.load(open("laid.svg.plan.json"))["windows"]))')
array=$(squeue -h -o %A | sort -n | head -n 1)
shard=0
while [ $shard -lt "$shards" ]; do # every third, waiting or running
  scancel "${array}_$shard"
  shard=$((shard + 3))
done
array_done() { [ -z "$(squeue -h -r -j "$array")" ]; }
wait_for 200 array_done
scancel -u "$(id -un)" # the merge waits for shards that will not come
wait_for 60 idle
there=$(ls laid.svg.plan.json.parts | wc -l)
echo "$shards shards; a third cancelled, $there are there"
[ "$there" -lt "$shards" ] && [ "$there" -gt 0 ] && [ ! -e laid.svg ] || { echo "that is not what was meant" >&2; exit 1; }
submit
wait_for 300 idle
cmp whole.svg laid.svg
echo "submitted again: the bytes of the whole"

sh "$root/examples/cluster/parallel.sh" "$work/drawing.png" "$work/parallel.svg" $options --memory 170M
cmp whole.svg parallel.svg
echo "GNU parallel: the bytes of the whole"
