# Slurm's accounting for a cluster of cluster.sh: a MariaDB and a slurmdbd of the tests' own, in the cluster's folder, on
# ports of their own, ended by stop_cluster. Sourced after cluster.sh.
#   start_cluster_with_accounting FOLDER [LINE...]   as start_cluster, and sacct answers
# What is missing for it: missing_accounting prints a reason, or nothing.

missing_accounting() {
  local program
  for program in slurmdbd sacctmgr sacct mariadbd mariadb-install-db; do
    PATH=$PATH:/usr/sbin command -v "$program" >/dev/null ||
      { echo "there is no $program (Debian: slurmdbd, mariadb-server-core)"; return; }
  done
}

start_cluster_with_accounting() {
  cluster=$1; shift
  PATH=$PATH:/usr/sbin
  start_munge
  local database_port dbd_port
  database_port=$(free_port) dbd_port=$(free_port)
  # Its own options only: the machine's configuration names the machine's folders.
  mariadb-install-db --no-defaults --datadir="$cluster/database" --auth-root-authentication-method=normal --skip-test-db \
    --skip-name-resolve >"$cluster/database.out" 2>&1
  cat >"$cluster/database.sql" <<'SQL'
CREATE DATABASE slurm;
CREATE USER 'slurm'@'127.0.0.1' IDENTIFIED BY 'slurm';
GRANT ALL ON slurm.* TO 'slurm'@'127.0.0.1';
SQL
  # No syncing: what it holds is gone with the test.
  mariadbd --no-defaults --datadir="$cluster/database" --socket="$cluster/database.socket" --user=root \
    --bind-address=127.0.0.1 --port="$database_port" --pid-file="$cluster/database.pid" --skip-name-resolve \
    --init-file="$cluster/database.sql" --innodb-buffer-pool-size=32M --innodb-flush-log-at-trx-commit=0 \
    >>"$cluster/database.out" 2>&1 &
  cluster_pids+=($!)
  cat >"$cluster/slurmdbd.conf" <<CONF
DbdHost=localhost
DbdAddr=127.0.0.1
DbdPort=$dbd_port
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$cluster/munge/socket
StorageType=accounting_storage/mysql
StorageHost=127.0.0.1
StoragePort=$database_port
StorageUser=slurm
StoragePass=slurm
StorageLoc=slurm
LogFile=$cluster/slurmdbd.log
PidFile=$cluster/slurmdbd.pid
CONF
  chmod 600 "$cluster/slurmdbd.conf"
  write_slurm_conf AccountingStorageType=accounting_storage/slurmdbd AccountingStorageHost=127.0.0.1 \
    AccountingStoragePort="$dbd_port" AccountingStoragePass="$cluster/munge/socket" "$@"
  wait_for "MariaDB to listen" is_open "$database_port"
  slurmdbd -D >"$cluster/slurmdbd.out" 2>&1 &
  cluster_pids+=($!)
  wait_for "slurmdbd to know the cluster" sacctmgr -i add cluster subpixel >"$cluster/sacctmgr.out" 2>&1
  start_daemons
}

is_open() { (exec 3<>"/dev/tcp/127.0.0.1/$1") 2>/dev/null; }
