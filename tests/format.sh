#!/bin/sh
# Checks that clang-format would change no source, and that no line with a comment, which it does not wrap, is longer
# than 110 columns. Usage: tests/format.sh CLANG_FORMAT, in the project's folder.
sources() {
    find fields shading scenes bridge tools tests -name data -prune -o '(' -name '*.h' -o -name '*.cpp' ')' -print0
}
sources | xargs -0 "$1" --dry-run --Werror || exit 1
! sources | LC_ALL=C.UTF-8 xargs -0 grep -nE '^.{111,}$' | grep -E ':[0-9]+:.*//[/ ]'
