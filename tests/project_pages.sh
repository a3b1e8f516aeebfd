#!/bin/bash
# Checks the pages at the top of the project: the files that CONTRIBUTING.md and SECURITY.md name exist.
# Usage: project_pages.sh SOURCE
set -euo pipefail
cd "$1"
failed=0
fail() { echo "$1" >&2; failed=1; }

for page in CONTRIBUTING.md SECURITY.md; do
    while read -r file; do
        [[ -e $file ]] || fail "$page: found no $file"
    done < <(grep -oE '[(`](fields|shading|scenes|bridge|tools|tests)/[a-z0-9_/.-]+[)`]' "$page" | tr -d '()`' | sort -u |
        grep -v '/test_name\.cpp$')
done
exit $failed
