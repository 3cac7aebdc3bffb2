# A Slurm of the tests' own: munged, slurmctld and three slurmd of one machine, all in one folder, all ended again. Sourced.
# Nodes n1 and n2 are partition main, n3 is partition slow, each with one processor.
#   start_cluster FOLDER [LINE...]     lines are added to slurm.conf; exports SLURM_CONF
#   stop_cluster                       ends what start_cluster and start_node started, by its process ids
#   start_node NAME, kill_node NAME    a node's slurmd; its death takes the node's jobs with it
# What is missing for it: missing_slurm prints a reason, or nothing.

missing_slurm() {
  local program
  for program in munged mungekey slurmctld slurmd sbatch squeue scontrol sinfo scancel; do
    PATH=$PATH:/usr/sbin command -v "$program" >/dev/null || { echo "there is no $program (Debian: slurm-wlm, munge)"; return; }
  done
  [ "$(id -u)" = 0 ] || echo "only root can run slurmd's steps here"
}

free_port() { python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'; }

start_cluster() {
  cluster=$1; shift
  PATH=$PATH:/usr/sbin
  start_munge
  write_slurm_conf AccountingStorageType=accounting_storage/none "$@"
  start_daemons
}

start_munge() {
  mkdir -p "$cluster"/{state,munge}
  chmod 755 "$cluster" "$cluster/munge"
  mungekey --create --keyfile "$cluster/munge/key"
  munged --force --foreground --key-file "$cluster/munge/key" --socket "$cluster/munge/socket" \
    --pid-file "$cluster/munge/pid" --log-file "$cluster/munge/log" --seed-file "$cluster/munge/seed" \
    >"$cluster/munge/out" 2>&1 &
  cluster_pids=($!)
  wait_for "munged to listen" test -S "$cluster/munge/socket"
}

write_slurm_conf() {
  local host; host=$(hostname -s)
  cat >"$cluster/slurm.conf" <<CONF
ClusterName=subpixel
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$(free_port)
AuthType=auth/munge
AuthInfo=socket=$cluster/munge/socket
CryptoType=crypto/munge
SlurmUser=root
SlurmdUser=root
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=batch_sched_delay=0,sched_interval=2,bf_interval=2,sched_min_interval=0
JobCompType=jobcomp/none
JobAcctGatherType=jobacct_gather/none
ReturnToService=2
SlurmdTimeout=5
SlurmctldTimeout=5
BatchStartTimeout=5
MessageTimeout=5
KillWait=2
MinJobAge=300
StateSaveLocation=$cluster/state
SlurmctldPidFile=$cluster/slurmctld.pid
SlurmctldLogFile=$cluster/slurmctld.log
SlurmdSpoolDir=$cluster/%n/spool
SlurmdPidFile=$cluster/%n/pid
SlurmdLogFile=$cluster/%n/log
NodeName=n1 NodeHostname=$host NodeAddr=127.0.0.1 Port=$(free_port) CPUs=1 RealMemory=500
NodeName=n2 NodeHostname=$host NodeAddr=127.0.0.1 Port=$(free_port) CPUs=1 RealMemory=500
NodeName=n3 NodeHostname=$host NodeAddr=127.0.0.1 Port=$(free_port) CPUs=1 RealMemory=500
PartitionName=main Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
PartitionName=slow Nodes=n3 MaxTime=INFINITE State=UP
$(printf '%s\n' "$@")
CONF
  export SLURM_CONF=$cluster/slurm.conf
}

start_daemons() {
  slurmctld -D -f "$SLURM_CONF" >"$cluster/slurmctld.out" 2>&1 &
  cluster_pids+=($!)
  start_node n1
  start_node n2
  start_node n3
  wait_for "the nodes to be idle" nodes_idle 2
}

nodes_idle() { [ "$(sinfo -h -N -p main -o %T 2>/dev/null | grep -c '^idle$')" = "$1" ]; }

# wait_for WHAT COMMAND...: up to 30 s
wait_for() {
  local what=$1 i; shift
  for ((i = 0; i < 300; ++i)); do "$@" && return; sleep 0.1; done
  echo "waited 30 s for $what" >&2
  return 1
}

start_node() {
  mkdir -p "$cluster/$1/spool"
  slurmd -D -N "$1" -f "$SLURM_CONF" >"$cluster/$1/out" 2>&1 &
  cluster_pids+=($!)
  echo $! >"$cluster/$1/daemon"
}

# The daemon, its step daemons and what they started.
kill_node() {
  local pid step
  pid=$(cat "$cluster/$1/daemon")
  kill -9 "$pid"
  for step in $(step_daemons "$1"); do kill_tree "$step"; done
}
# A step daemon writes its node's log, and so is told apart from those of other nodes and other clusters.
step_daemons() {
  local pid
  for pid in $(pgrep slurmstepd); do
    case "$(ls -l "/proc/$pid/fd" 2>/dev/null) " in *"-> $cluster/$1/log"[[:space:]]*) echo "$pid" ;; esac
  done
}
kill_tree() {
  local child
  kill -STOP "$1" 2>/dev/null || true
  for child in $(pgrep -P "$1"); do kill_tree "$child"; done
  kill -9 "$1" 2>/dev/null || true
}

# A daemon that is asked to end waits for its steps, and those for a controller: nodes are killed first.
stop_cluster() {
  local pid node
  for node in n1 n2 n3; do
    pid=$(cat "$cluster/$node/daemon" 2>/dev/null || true)
    if [ -n "$pid" ]; then kill -9 "$pid" 2>/dev/null || true; fi
    for pid in $(step_daemons "$node"); do kill_tree "$pid"; done
  done
  for pid in "${cluster_pids[@]}"; do kill -9 "$pid" 2>/dev/null || true; done
  for pid in "${cluster_pids[@]}"; do wait "$pid" 2>/dev/null || true; done
}
