#include "tools/farm/plan_scripts.h"

#include <fmt/format.h>

#include <string_view>

namespace haarfield {
namespace {

std::string quoted(const std::string& text) {
    std::string result = "'";
    for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
}

/// Escapes a path for the file patterns of sbatch, in which % is special.
std::string without_patterns(const std::string& path) {
    std::string result;
    for (const char c : path) result += c == '%' ? std::string("%%") : std::string(1, c);
    return result;
}

/// Returns the beginning that all scripts share.
std::string script_start(const FarmPlan& plan, const ScriptPaths& paths, std::string_view description) {
    return fmt::format("#!/bin/sh\n{}set -eu\nprogram={}\nplan={}\nthreads={}\n", description,
                       quoted(paths.program), quoted(paths.plan), plan.threads);
}

constexpr std::string_view slurm_description =
    R"sh(# Submits the tasks of this plan to Slurm, and a join after them. Prints the job number of the join.
# Run it again after failures: it submits only tasks without a good result.
# Usage: sh slurm.sh [--tasks-per-job=N] [--at-once=N] [--most-jobs=N] [OPTION OF SBATCH...]
#   --tasks-per-job  tasks of each job, which start and prepare the scene once; more if the queue is too short
#   --at-once        array elements that run at the same time, of each array
#   --most-jobs      jobs to submit at most, for queues with a limit per user
# Options of sbatch override the limits below: --partition=night --time=2:00:00 --mem=4G
# Time and memory are limited to four times and twice the estimate, or what finished tasks needed.
# Tasks of nodes that fail are queued again. If a task fails, the jobs that wait for its stage are cancelled.
)sh";

constexpr std::string_view slurm_body = R"sh(tasks_per_job=1 at_once= most_jobs=
for option do
    shift
    case $option in
        --tasks-per-job=*) tasks_per_job=${option#*=} ;;
        --at-once=*) at_once=${option#*=} ;;
        --most-jobs=*) most_jobs=${option#*=} ;;
        *) set -- "$@" "$option" ;;
    esac
done
submitted=
fail() {
    echo "slurm.sh: $1" >&2
    if [ -n "$submitted" ]; then
        scancel $submitted || true
        echo "slurm.sh: cancelled the jobs that were submitted: $submitted" >&2
    fi
    exit 1
}
# The value of a limit in Slurm's configuration, or the default.
limit() {
    value=$(scontrol show config 2>/dev/null | sed -n "s/^$1 *= *\([0-9][0-9]*\).*/\1/p")
    echo "${value:-$2}"
}
array=$(limit MaxArraySize 1001)
[ "$array" -gt 0 ] || fail "this Slurm has no job arrays (MaxArraySize is 0)"
# A tenth of the free places in the queue stays free, and one for the join.
queued=$(squeue --noheader --array --format=%i 2>/dev/null | wc -l)
jobs=$((($(limit MaxJobCount 10000) - queued) * 9 / 10 - 1))
[ -z "$most_jobs" ] || [ "$most_jobs" -gt "$jobs" ] || jobs=$((most_jobs - 1))
[ "$jobs" -gt 0 ] || fail "the queue is full: $queued jobs"
mkdir -p "$plan/logs" "$plan/submitted"
batches=$plan/submitted/$(date +%Y%m%d-%H%M%S)-$$.txt
"$program" status "$plan" --verify --quiet --batches "$jobs" --batch-tasks "$tasks_per_job" >"$batches"

# submit NAME LOG ARRAY_OR_EMPTY MINUTES MEGABYTES [OPTION OF SBATCH...] job.sh ARGUMENT...: sets `id`.
submit() {
    name=$1 log=$2 indices=$3 minutes=$4 megabytes=$5
    shift 5
    id=$(sbatch --parsable --requeue --open-mode=append --cpus-per-task="$threads" --job-name="haarfield_$name" \
        --time="$minutes" --mem="${megabytes}M" --output="$logs/$log.log" ${indices:+--array="$indices"} \
        ${after:+--dependency="afterok$after" --kill-on-invalid-dep=yes} "$@") || fail "sbatch refused the job $name"
    id=${id%%;*}
    case $id in
        '' | *[!0-9]*) fail "sbatch printed no job number: $id" ;;
    esac
    submitted="$submitted $id"
}
# The largest value of a column in the lines of a stage.
largest() { awk -v stage="$1" -v column="$2" '$1 == stage && $column > most { most = $column } END { print most + 0 }' "$batches"; }

after= line=1
for stage in 1 2 3; do
    case $stage in
        1) name=fields ;;
        2) name=shading ;;
        3) name=indirect ;;
    esac
    count=$(awk -v stage="$stage" '$1 == stage' "$batches" | wc -l)
    these= first=0
    while [ "$first" -lt "$count" ]; do
        elements=$((count - first))
        [ "$elements" -le "$array" ] || elements=$array
        log=${name}_%a
        [ "$first" -eq 0 ] || log=${name}_$first+%a
        submit "$name" "$log" "0-$((elements - 1))${at_once:+%$at_once}" "$(largest "$stage" 2)" \
            "$(largest "$stage" 3)" "$@" "$plan/job.sh" batch "$batches" "$((line + first))"
        these=$these:$id
        first=$((first + elements))
    done
    line=$((line + count))
    [ -z "$these" ] || after=$these
done
submit join join "" "$(largest join 2)" "$(largest join 3)" "$@" "$plan/job.sh" join
echo "$id"
)sh";

constexpr std::string_view parallel_description =
    R"sh(# Runs the tasks of this plan with GNU parallel, and joins them.
# Run it again after failures: it runs only tasks without a good result.
# Usage: sh parallel.sh [--tasks-per-job=N] [OPTION OF PARALLEL...]
#   --tasks-per-job  tasks of each job, which start and prepare the scene once
#     sh parallel.sh --jobs 2
#     sh parallel.sh --jobs 2 --sshlogin node1,node2
)sh";

constexpr std::string_view parallel_body = R"sh(tasks_per_job=1
for option do
    shift
    case $option in
        --tasks-per-job=*) tasks_per_job=${option#*=} ;;
        *) set -- "$@" "$option" ;;
    esac
done
mkdir -p "$plan/logs" "$plan/submitted"
batches=$plan/submitted/$(date +%Y%m%d-%H%M%S)-$$.txt
for stage in 1 2 3; do
    "$program" status "$plan" --verify --quiet --batches 1000000 --batch-tasks "$tasks_per_job" >"$batches"
    sed -n "s/^$stage [0-9]* [0-9]* //p" "$batches" >"$batches.stage_$stage"
    [ -s "$batches.stage_$stage" ] || continue
    parallel --will-cite --joblog "$plan/logs/stage_$stage.log" "$@" --quote --arg-file "$batches.stage_$stage" \
        sh "$plan/job.sh" tasks {}
done
exec sh "$plan/job.sh" join
)sh";

constexpr std::string_view job_description = R"sh(# A job of slurm.sh or parallel.sh, on its node.
# Usage: sh job.sh tasks LIST | batch FILE FIRST_LINE | join
)sh";

constexpr std::string_view job_body = R"sh(
case $1 in
    tasks) set -- work "$plan" --threads "$threads" --tasks "$2" ;;
    batch)
        tasks=$(sed -n "$(($3 + SLURM_ARRAY_TASK_ID))p" "$2" | cut -d ' ' -f 4)
        set -- work "$plan" --threads "$threads" --tasks "$tasks"
        ;;
    join) set -- join "$plan" --threads "$threads" ;;
esac
exec $run "$program" "$@")sh";

}  // namespace

std::string job_script(const FarmPlan& plan, const ScriptPaths& paths, const std::string& hook,
                       bool unsandboxed) {
    return script_start(plan, paths, job_description) +
           "# The hook: loads modules, or sets `run` to a command that runs the program, such as\n"
           "# run='apptainer exec haarfield.sif'\n"
           "run=\n" +
           hook + (hook.empty() ? "" : "\n") + std::string(job_body.substr(1)) +
           (unsandboxed ? " --unsandboxed\n" : "\n");
}

std::string slurm_script(const FarmPlan& plan, const ScriptPaths& paths) {
    return script_start(plan, paths, slurm_description) +
           "logs=" + quoted(without_patterns(paths.plan + "/logs")) + "\n" + std::string(slurm_body);
}

std::string parallel_script(const FarmPlan& plan, const ScriptPaths& paths) {
    return script_start(plan, paths, parallel_description) + std::string(parallel_body);
}

}  // namespace haarfield
