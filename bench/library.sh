#!/usr/bin/env bash
# A whole library of CAD models as one scene: Debian's package kicad-packages3d (6,227 STEP files, 4.4 GB of text),
# unpacked and never installed. Writes bench/results/library.md, .json and .png. About a quarter of an hour and 7 GB of
# memory; a run that was cut off goes on where it was.
#
#   bench/library.sh            all of it (needs 5 GB of disk)
#   bench/library.sh sample     the 60 files of bench/library_sample.txt; results go to target/
#
# HALFPIXEL_LIBRARY is where the files are or will be [default: target/library].
set -euo pipefail
cd "$(dirname "$0")/.."

library=${HALFPIXEL_LIBRARY:-target/library}
case "${1:-all}" in
all)
    if [ ! -e "$library/.complete" ]; then
        scripts/fetch_library.sh "$library"
    fi
    cargo build --release
    exec python3 bench/library.py report "$library" bench/results/library
    ;;
sample)
    scripts/fetch_library.sh "$library" bench/library_sample.txt
    cargo build --release
    exec python3 bench/library.py report "$library" target/library_sample bench/library_sample.txt
    ;;
*)
    echo "usage: bench/library.sh [all|sample]" >&2
    exit 2
    ;;
esac
