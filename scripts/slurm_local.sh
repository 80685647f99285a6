#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A Slurm of one node for tests and first steps: munged, slurmctld and slurmd from Debian, all files in DIR, no systemd.
#   scripts/slurm_local.sh start DIR    prints how to use it:  export SLURM_CONF=DIR/slurm.conf
#   scripts/slurm_local.sh stop DIR
# As root (slurmd must be); for a container or a virtual machine, not for a shared host. GRTX_SLURM_PORT: first of two
# ports (default 16817). Exit code 77: cannot run here (packages missing, not root, no cgroups).
set -euo pipefail

usage() { echo "usage: slurm_local.sh start|stop DIR" >&2; exit 2; }
[ $# -eq 2 ] || usage
action=$1
mkdir -p "$2"
dir=$(cd "$2" && pwd)
PATH=$PATH:/usr/sbin:/sbin

stop_daemon() {  # NAME: by the id it wrote
  local file="$dir/run/$1.pid" id
  [ -s "$file" ] || return 0
  id=$(cat "$file")
  [ "$(cat "/proc/$id/comm" 2>/dev/null)" = "$1" ] || return 0
  kill "$id" 2>/dev/null || return 0
  for _ in $(seq 50); do kill -0 "$id" 2>/dev/null || return 0; sleep 0.1; done
  kill -9 "$id" 2>/dev/null || true
}

stop() {
  if [ -f "$dir/slurm.conf" ] && [ -s "$dir/run/slurmctld.pid" ]; then
    SLURM_CONF="$dir/slurm.conf" timeout 10 scancel --full --user=root 2>/dev/null || true
  fi
  stop_daemon slurmd
  stop_daemon slurmctld
  stop_daemon munged
}

start() {
  for program in munged slurmctld slurmd sbatch squeue; do
    command -v $program >/dev/null || { echo "slurm_local.sh: $program is missing (Debian: slurmctld slurmd slurm-client munge)" >&2; exit 77; }
  done
  [ "$(id -u)" -eq 0 ] || { echo "slurm_local.sh: slurmd needs root" >&2; exit 77; }
  local port=${GRTX_SLURM_PORT:-16817} host memory
  host=$(hostname -s)
  memory=$(awk '/MemTotal/ {print int($2 / 1024)}' /proc/meminfo)
  mkdir -p "$dir/run" "$dir/log" "$dir/state" "$dir/spool"
  chmod 755 "$dir" "$dir/run"
  [ -s "$dir/munge.key" ] || (umask 077 && head -c 1024 /dev/urandom >"$dir/munge.key")
  cat >"$dir/slurm.conf" <<CONF
ClusterName=grtx_local
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$dir/run/munge.socket
CredType=cred/munge
SlurmctldPort=$port
SlurmdPort=$((port + 1))
SlurmctldPidFile=$dir/run/slurmctld.pid
SlurmdPidFile=$dir/run/slurmd.pid
SlurmctldLogFile=$dir/log/slurmctld.log
SlurmdLogFile=$dir/log/slurmd.log
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
SwitchType=switch/none
ReturnToService=2
SchedulerType=sched/backfill
SchedulerParameters=defer,sched_interval=2,batch_sched_delay=0
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
MaxArraySize=100001
MaxJobCount=100000
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=$memory State=UNKNOWN
PartitionName=local Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
  # Nothing here limits jobs; from 24.05 on Slurm can do without cgroups, which containers often lack.
  rm -f "$dir/cgroup.conf"
  local version
  version=$(slurmd -V | sed -n 's/^slurm[^ ]* \([0-9]*\.[0-9]*\).*/\1/p')
  if [ "$(printf '%s\n' 24.05 "$version" | sort -V | head -1)" = 24.05 ]; then echo CgroupPlugin=disabled >"$dir/cgroup.conf"; fi
  export SLURM_CONF="$dir/slurm.conf"
  # --force: folders above DIR may be writable by others, as the temporary folder is.
  rm -f "$dir"/log/slurm*.log
  munged --force --socket="$dir/run/munge.socket" --key-file="$dir/munge.key" --log-file="$dir/log/munged.log" \
         --pid-file="$dir/run/munged.pid" --seed-file="$dir/run/munge.seed"
  local alive=yes
  slurmctld -c || alive=no
  slurmd || alive=no
  for _ in $(seq 150); do
    # Daemons may go into the background before they know whether they can run: without cgroups, or on a port in use.
    grep -qE "slurmd initialization failed|fatal:" "$dir"/log/slurm*.log 2>/dev/null && alive=no
    [ $alive = yes ] || break
    case "$(sinfo -h -o %T 2>/dev/null)" in  # a star behind the state: the node does not respond
      idle|mixed|allocated) echo "export SLURM_CONF=$SLURM_CONF"; return 0 ;;
      down*|drained*) scontrol update nodename="$host" state=resume 2>/dev/null || true ;;
    esac
    sleep 0.2
  done
  echo "slurm_local.sh: the node did not come up: $(grep -hE "error:|fatal:" "$dir"/log/slurm*.log 2>/dev/null | tail -2 | tr '\n' ' ')" >&2
  stop
  exit 77
}

case $action in
  start) stop; start ;;
  stop) stop ;;
  *) usage ;;
esac
