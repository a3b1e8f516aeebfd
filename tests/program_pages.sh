#!/bin/bash
# Checks the manual page and the bash completion against --help: each option of each command is in both, and the
# completion offers commands, options and the words that an option accepts. Usage: program_pages.sh PROGRAM PAGES
set -euo pipefail
program=$1 pages=$2
failed=0
fail() { echo "$1" >&2; failed=1; }

# The words that the completion offers for the last of the words of a command line.
source "$pages/haarfield"
offered() {
    COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
    _haarfield
    echo "${COMPREPLY[*]}"
}

manual=$(sed 's/\\-/-/g' "$pages/haarfield.1")
commands=$("$program" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]*\) .*/\1/p')
[[ $(wc -w <<<"$commands") -ge 16 ]] || fail "--help lists commands: $commands"
for command in $commands; do
    [[ " $(offered haarfield "") " == *" $command "* ]] || fail "the completion does not offer $command"
    section=$(sed -n "/^\.SS $command\$/,/^\.S[SH] /{/^\\\\fB-/p}" <<<"$manual")
    documented=" $(grep -oE -e '--[a-z-]+' <<<"$section" | tr '\n' ' ')"
    words=" $(offered haarfield "$command" -) "
    options=$("$program" "$command" --help | grep -oE '^ +(-[a-z],)?--[a-z-]+' | grep -oE -e '--[a-z-]+')
    for option in $options; do
        [[ $documented == *" $option "* ]] || fail "haarfield.1: $command lacks $option"
        [[ $words == *" $option "* ]] || fail "the completion of $command lacks $option"
    done
done
[[ $(offered haarfield bake --occ) == "--occlusion --occlusion-error" ]] || fail "bake --occ"
[[ $(offered haarfield bake --occlusion "") == "fields exact auto" ]] || fail "bake --occlusion"
[[ $(offered haarfield bake scenes/) == "" ]] || fail "files are not left to bash"
if command -v groff >/dev/null; then
    warnings=$(groff -man -Tutf8 -ww "$pages/haarfield.1" 2>&1 >/dev/null)
    [[ -z $warnings ]] || fail "$warnings"
fi
exit $failed
