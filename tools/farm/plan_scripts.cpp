#include "tools/farm/plan_scripts.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {
namespace {

std::string quoted(const std::string& text) {
    std::string result = "'";
    for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
}

constexpr std::size_t longest_array = 1000;  // tasks; Slurm's own limit is 1001 unless it is told otherwise

}  // namespace

std::string slurm_script(const FarmPlan& plan, const ScriptPaths& paths) {
    std::string script = fmt::format(
        "#!/bin/sh\n"
        "# Submits a plan of {0} tasks to Slurm, and a join after them. Options are passed on to sbatch:\n"
        "#     sh slurm.sh --partition=night --time=2:00:00\n"
        "# Tasks of nodes that go down are queued again. If a task fails its stage ends, and what waits for "
        "it is\n"
        "# cancelled; submitted again, the plan goes on where it was.\n"
        "set -eu\n"
        "program={1}\n"
        "plan={2}\n"
        "mkdir -p \"$plan/logs\"\n"
        "# submit ARRAY_OR_EMPTY AFTER COMMAND [OPTION...]: prints the job's number.\n"
        "submit() {{\n"
        "    array=$1 after=$2 command=$3\n"
        "    shift 3\n"
        "    sbatch --parsable --requeue --open-mode=append --cpus-per-task={3} \\\n"
        "        --job-name=haarfield ${{array:+--array=$array}} \\\n"
        "        ${{after:+--dependency=afterok$after --kill-on-invalid-dep=yes}} \\\n"
        "        --output=\"$plan/logs/%A_%a.log\" \"$@\" --wrap \"$command\" | cut -d ';' -f 1\n"
        "}}\n",
        plan.task_count(), quoted(paths.program), quoted(paths.plan), plan.threads);
    script += "after=\n";
    for (std::size_t stage = 0; stage + 1 < plan.stages.size(); ++stage) {
        const std::size_t begin = plan.stages[stage], end = plan.stages[stage + 1];
        if (begin == end) continue;
        script += fmt::format("# Stage {}: tasks {} to {}.\nthese=\n", stage + 1, begin, end - 1);
        for (std::size_t first = begin; first < end; first += longest_array)
            script += fmt::format(
                "these=$these:$(submit 0-{0} \"$after\" "
                "\"exec '$program' work '$plan' --quiet --threads {1} --task \\$(({2} + "
                "SLURM_ARRAY_TASK_ID))\" \"$@\")\n",
                std::min(longest_array, end - first) - 1, plan.threads, first);
        script += "after=$these\n";
    }
    script += "submit '' \"$after\" \"exec '$program' join '$plan'\" \"$@\"\n";
    return script;
}

std::string parallel_script(const FarmPlan& plan, const ScriptPaths& paths) {
    std::string script = fmt::format(
        "#!/bin/sh\n"
        "# Runs a plan of {0} tasks with GNU parallel, and joins it. Options are passed on to parallel:\n"
        "#     sh parallel.sh --jobs 2\n"
        "#     sh parallel.sh --jobs 2 --sshlogin node1,node2\n"
        "# After failures run it again: what is done is not done anew.\n"
        "set -eu\n"
        "program={1}\n"
        "plan={2}\n"
        "mkdir -p \"$plan/logs\"\n",
        plan.task_count(), quoted(paths.program), quoted(paths.plan));
    for (std::size_t stage = 0; stage + 1 < plan.stages.size(); ++stage) {
        const std::size_t begin = plan.stages[stage], end = plan.stages[stage + 1];
        if (begin == end) continue;
        script += fmt::format(
            "seq {0} {1} | parallel --will-cite --joblog \"$plan/logs/stage_{2}.log\" --resume-failed \"$@\" "
            "\\\n"
            "    \"'$program' work '$plan' --quiet --threads {3} --task {{}}\"\n",
            begin, end - 1, stage + 1, plan.threads);
    }
    script += "exec \"$program\" join \"$plan\"\n";
    return script;
}

}  // namespace haarfield
