#!/usr/bin/env bash
# Unpacks STEP files of Debian's package kicad-packages3d into a folder; installs nothing.
#
#   scripts/fetch_library.sh FOLDER [LIST]
#
# LIST names the files that are wanted (one a line, relative to FOLDER), as bench/library_sample.txt does; without it all
# are unpacked (4.4 GB) and FOLDER/.complete marks that they are there. The package (379 MB) is kept in
# FOLDER/package if it is to be unpacked whole, and removed again after a LIST. Exit 3: the package can't be had here.
set -euo pipefail

PACKAGE=kicad-packages3d
INSIDE=./usr/share/kicad/3dmodels
[ $# -ge 1 ] && [ $# -le 2 ] || {
    echo "usage: scripts/fetch_library.sh FOLDER [LIST]" >&2
    exit 2
}
folder=$1
list=${2:-}

if [ -n "$list" ]; then
    missing=0
    while read -r name; do [ -f "$folder/$name" ] || missing=1; done <"$list"
    [ $missing = 1 ] || exit 0
elif [ -e "$folder/.complete" ]; then
    exit 0
fi

for tool in apt-get dpkg-deb tar; do
    command -v $tool >/dev/null || {
        echo "$PACKAGE is a Debian package, and there is no $tool here" >&2
        exit 3
    }
done
mkdir -p "$folder/package"
folder=$(cd "$folder" && pwd)
[ -z "$list" ] || list=$(realpath "$list")
cd "$folder/package"
deb() { ls "$PACKAGE"_*.deb 2>/dev/null | tail -1; }
if [ -z "$(deb)" ]; then
    fetch() { apt-get -o APT::Sandbox::User=root download "$PACKAGE" >&2; }
    # A machine that never asked for package lists knows no package.
    fetch || { { [ "$(id -u)" -ne 0 ] || apt-get update >&2; } && fetch; } || {
        echo "$PACKAGE can't be downloaded here" >&2
        rm -rf "$folder/package"
        exit 3
    }
fi

strip=$(tr -cd / <<<"$INSIDE/" | wc -c)
extract() { dpkg-deb --fsys-tarfile "$(deb)" | tar -x -C "$folder" --strip-components="$strip" "$@"; }
if [ -n "$list" ]; then
    extract -T <(sed "s|^|$INSIDE/|" "$list")
    rm -rf "$folder/package"
else
    extract --wildcards "*.step"
    touch "$folder/.complete"
fi
