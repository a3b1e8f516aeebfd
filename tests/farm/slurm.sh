#!/bin/bash
# Runs a plan of a small version of the demo's scene on a private Slurm: both daemons and two nodes on this machine, one
# of which fails. The queue is shorter than the plan. Then removes and damages results and submits the plan again.
# Usage: slurm.sh PROGRAM SOURCE. Exit code 77, with the reason, if Slurm cannot run here.
set -euo pipefail
program=$1 source=$2

skip() { echo "skipped: $1"; exit 77; }
((EUID == 0)) || skip "Slurm's daemons want to be root's"
for needed in munged munge slurmctld slurmd sbatch squeue scontrol sinfo; do
    command -v "$needed" >/dev/null || skip "$needed is not installed"
done

folder=$(mktemp -d /tmp/haarfield-slurm-XXXXXX)
declare -A daemon=()
stop() { # ends what was started, and nothing else
    for name in "${!daemon[@]}"; do
        kill -9 -- "-${daemon[$name]}" 2>/dev/null || true
    done
    rm -rf "$folder"
}
trap stop EXIT
start() { # NAME COMMAND...: in a session of its own
    local name=$1
    shift
    setsid "$@" >"$folder/$name.log" 2>&1 &
    daemon[$name]=$!
}
fail() {
    echo "failed: $1"
    tail -n 30 "$folder"/*.log "$folder"/plan/logs/*.log 2>/dev/null || true
    squeue 2>/dev/null || true
    exit 1
}
wait_for() { # SECONDS COMMAND...
    local left=$(($1 * 5))
    shift
    until "$@"; do
        ((left-- > 0)) || return 1
        sleep 0.2
    done
}

# A separate munge.
mkdir -m 0755 "$folder/munge"
(umask 077 && dd if=/dev/urandom of="$folder/munge/key" bs=1024 count=1 2>/dev/null)
chmod 0755 "$folder"
start munged munged --foreground --force --socket="$folder/munge/socket" --key-file="$folder/munge/key" \
    --log-file="$folder/munge/log" --pid-file="$folder/munge/pid" --seed-file="$folder/munge/seed"
wait_for 20 test -S "$folder/munge/socket" || skip "munged does not start: $(tail -n 1 "$folder/munged.log")"

host=$(hostname -s)
memory=$(awk '$1 == "MemTotal:" { print int($2 / 1024 * 0.9) }' /proc/meminfo) # MB
port=$((20000 + $$ % 20000))
# A job of a node that failed may start again when its credential has expired, after 120 s by default.
cat >"$folder/slurm.conf" <<CONF
ClusterName=haarfield
SlurmctldHost=$host(127.0.0.1)
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket,cred_expire=10
CryptoType=crypto/munge
MpiDefault=none
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SwitchType=switch/none
ReturnToService=2
SlurmUser=root
SlurmctldPort=$port
SlurmctldPidFile=$folder/controller.pid
SlurmdPidFile=$folder/%n.pid
SlurmdSpoolDir=$folder/spool-%n
StateSaveLocation=$folder/state
SlurmctldLogFile=$folder/controller_own.log
SlurmdLogFile=$folder/%n_own.log
SchedulerType=sched/builtin
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdTimeout=20
MaxArraySize=4
MaxJobCount=16
MessageTimeout=30
NodeName=n0 NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 1)) CPUs=1 RealMemory=$memory State=UNKNOWN
NodeName=n1 NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 2)) CPUs=1 RealMemory=$memory State=UNKNOWN
PartitionName=farm Nodes=n0,n1 Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$folder/slurm.conf
mkdir "$folder/state" "$folder/spool-n0" "$folder/spool-n1"
start controller slurmctld -D -f "$SLURM_CONF"
for node in n0 n1; do
    start "$node" slurmd -D -f "$SLURM_CONF" -N "$node"
done
both_idle() { [[ $(sinfo --noheader --Node --format '%t' 2>/dev/null | grep -c idle) == 2 ]]; }
wait_for 60 both_idle || fail "the nodes do not come up"

# The demo's scene, with a sky instead of its image, which may not be installed.
cd "$folder"
mkdir scenes
ln -s "$source/scenes/meshes" scenes/meshes
sed -e 's/^ *fine_vertices = .*/fine_vertices = 1500/' -e 's/^ *planar_samples = .*/planar_samples = 600/' \
    -e 's/^ *spherical_samples = .*/spherical_samples = 600/' -e 's/^ *resolution = .*/resolution = [96, 96]/' \
    "$source/scenes/table_and_chairs.toml" >scenes/table_and_chairs.toml
bake=(--error off --face-size 16 --antialiasing 0)
reference=(--lights 16 --antialiasing 0)
"$program" bake scenes/table_and_chairs.toml -o whole --fields whole_fields --threads 1 --quiet "${bake[@]}"
"$program" reference scenes/table_and_chairs.toml -o whole --threads 1 --quiet "${reference[@]}"
"$program" plan scenes/table_and_chairs.toml -o plan --want bake,reference --tasks 3 --threads 1 \
    --bake-options "${bake[*]}" --reference-options "${reference[*]}"

tasks=$("$program" status plan --json | sed -n 's/^ *"tasks": \([0-9]*\),$/\1/p')
((tasks > 16)) || fail "the plan has no more tasks than the queue has places: $tasks"
! sh plan/slurm.sh --partition=missing >refused.txt 2>&1 || fail "a refused submission is no error"
grep -q 'sbatch refused' refused.txt || fail "a refused submission is not reported"

ended() { [[ -z $(squeue --noheader --jobs "$join" 2>/dev/null) ]]; }
done_tasks() { find plan/parts -name '*.part' | wc -l; }
some_done() { (($(done_tasks) >= 3)); }
join=$(sh plan/slurm.sh --at-once=2) || fail "the plan is not submitted"
wait_for 120 some_done || fail "no task gets done"
kill -9 -- "-${daemon[n1]}"
scontrol update NodeName=n1 State=DOWN Reason=test
down_at=$(done_tasks)
wait_for 400 ended || fail "the join does not end"
diff -r whole plan/results/table_and_chairs || fail "the results are not those of the undivided commands"
diff -r whole_fields plan/fields || fail "the fields are not those of the undivided command"
hosts=$(cat plan/parts/*.part | grep -ao '"host":"n[01]"' | sort | uniq -c | tr '\n' ' ')
echo "ran $(done_tasks) tasks, of which $down_at were done when n1 went down: $hosts"
[[ $hosts == *n0* && $hosts == *n1* ]] || fail "one node did nothing"
grep -q 'done in' plan/logs/fields_0.log || fail "there is no log of the first job of fields"

# Removes one result and damages another.
rm -r plan/parts/2.part plan/results
printf X | dd of=plan/parts/5.part bs=1 seek=200 conv=notrunc 2>/dev/null
! "$program" status plan --verify --quiet || fail "the damaged result is not found"
join=$(sh plan/slurm.sh) || fail "the plan is not submitted again"
wait_for 400 ended || fail "the second join does not end"
"$program" status plan --verify --quiet || fail "a result is still damaged"
diff -r whole plan/results/table_and_chairs || fail "the second results are not those of the undivided commands"
