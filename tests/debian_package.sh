#!/bin/bash
# Tests a Debian package without installing it: unpacks it into an empty folder, checks its files, checks that each
# library that its programs load directly belongs to a package in Depends, and bakes the README's first scene.
# Usage: debian_package.sh PACKAGE.deb SOURCE     where the packages of Depends are installed
set -euo pipefail
package=$(realpath "$1") source=$(realpath "$2")
root=$(mktemp -d /tmp/haarfield-package-XXXXXX)
trap 'rm -rf "$root"' EXIT
failed=0
fail() { echo "$1" >&2; failed=1; }

dpkg -x "$package" "$root"
for file in bin/haarfield bin/haarfield-reader bin/haarfield-image-reader share/man/man1/haarfield.1 \
    share/bash-completion/completions/haarfield share/doc/haarfield/copyright share/doc/haarfield/CHANGELOG.md share/haarfield/haarfield_addon.zip \
    share/haarfield/scenes/single_chair.toml include/haarfield/bridge/bridge.h; do
    [[ -s $root/usr/$file ]] || fail "found no /usr/$file"
done
for pattern in 'lib/*/libhaarfield_bridge.a' 'lib/*/cmake/haarfield/haarfieldConfig.cmake' \
    'lib/python3/dist-packages/haarfield/_haarfield*.so'; do
    compgen -G "$root/usr/$pattern" >/dev/null || fail "found no /usr/$pattern"
done

depends=" $(dpkg-deb --field "$package" Depends | sed 's/([^)]*)//g; s/[,|]/ /g') "
module=$(compgen -G "$root/usr/lib/python3/dist-packages/haarfield/_haarfield*.so")
for file in "$root/usr/bin/haarfield" "$root/usr/bin/haarfield-reader" \
    "$root/usr/bin/haarfield-image-reader" "$module"; do
    for library in $(objdump -p "$file" | awk '/NEEDED/ { print $2 }'); do
        path=$(ldd "$file" | awk -v name="$library" '$1 == name { print $3 } $1 ~ "/" name "$" { print $1 }')
        [[ $path ]] || { fail "$file: found no $library"; continue; }
        owner=$(dpkg -S "$(realpath "$path")" 2>/dev/null || dpkg -S "$path" 2>/dev/null || dpkg -S "*/${path##*/}")
        owner=${owner%%:*}
        [[ $depends == *" $owner "* ]] || fail "$file: $library belongs to $owner, which is not in Depends:$depends"
    done
done

bake() { # as the README's first scene
    "$root/usr/bin/haarfield" import "$source/scenes/meshes/chair.obj" -o "$root/first" --floor --quiet &&
        "$root/usr/bin/haarfield" bake "$root/first/chair.toml" -o "$root/first" --quiet
}
bake || fail "the README's first scene is not baked"
[[ -s $root/first/baked.png ]] || fail "found no baked.png"
PYTHONPATH=$root/usr/lib/python3/dist-packages /usr/bin/python3 -c "import haarfield" || fail "no Python module"
exit $failed
