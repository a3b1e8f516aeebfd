#!/bin/bash
# Checks the lists of packages: each line has the expected form, included lists exist, the demo stays small, and `tests`
# has the packages of all lists. Usage: packages.sh SOURCE
set -euo pipefail
cd "$1/tools/packages"
failed=0
fail() { echo "tools/packages/$1" >&2; failed=1; }

for list in *.txt; do
    number=0
    while IFS= read -r line; do
        number=$((number + 1))
        if [[ $line =~ ^include\ ([a-z_]+)$ ]]; then
            [[ -r ${BASH_REMATCH[1]}.txt ]] || fail "$list:$number: found no list ${BASH_REMATCH[1]}"
        elif [[ ! $line =~ ^(#\ .*|[a-z0-9][a-z0-9+.-]+)?$ ]]; then
            fail "$list:$number: found \"$line\"; expected a package, include LIST, a comment or nothing"
        fi
    done <"$list"
    [[ -z $(grep -v '^\(#.*\)\?$' "$list" | sort | uniq -d) ]] || fail "$list: found a line twice"
    ((failed)) || ./install --print "${list%.txt}" >/dev/null || fail "$list: cannot be read by tools/packages/install"
done
((failed == 0)) || exit 1

# Packages that take minutes to install are in separate lists.
for package in $(./install --print demo); do
    case $package in
        blender | chromium* | slurm* | munge | *selenium | pybind11* | libgtest*)
            fail "demo.txt: found $package, which the demo does not need" ;;
    esac
done
[[ $(./install --print tests) == $(./install --print $(basename -s .txt *.txt | grep -vx checks)) ]] ||
    fail "tests.txt: lacks packages of other lists"

# Unknown lists are errors, and the lists in the usage are those that exist.
! ./install --print nothing_of_the_kind 2>/dev/null || fail "install: accepted an unknown list"
for list in *.txt; do
    grep -q "^# LIST .*\b${list%.txt}\b" install || fail "install: the usage does not name ${list%.txt}"
done
exit $failed
