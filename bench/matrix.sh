#!/usr/bin/env bash
# The full matrix of models, bounds, precisions, shapes of a frame and views on a backend: bench/results/matrix.md and .csv.
# Without a GPU: a quarter of an hour. Tests draw the pairwise part of it (tests/matrix.rs).
#
#   bench/matrix.sh [--backend emulated|cuda]
#
# HALFPIXEL_MODELS: real models [default: ../shared/models]; without them the built-in ones alone.
set -euo pipefail
cd "$(dirname "$0")/.."

backend=emulated
case "${1:-}" in
--backend) backend=${2:?usage: bench/matrix.sh [--backend emulated|cuda]} ;;
"") ;;
*) echo "usage: bench/matrix.sh [--backend emulated|cuda]" >&2 && exit 2 ;;
esac
models=(builtin:teapot builtin:sphere builtin:torus builtin:drum builtin:stress)
models+=(builtin:trimmed:plate builtin:trimmed:drilled builtin:trimmed:ball builtin:trimmed:degree22)
real=${HALFPIXEL_MODELS:-../shared/models}
for name in killeroo.bpt screw.step gmsh_submarine.stp so100_Wrist_Roll_08c.step; do
    if [ -f "$real/$name" ]; then models+=("$real/$name"); else echo "skipped: there is no $real/$name" >&2; fi
done
program=${CARGO_TARGET_DIR:-target}/release/halfpixel
cargo build --release
"$program" bench matrix "${models[@]}" --backend "$backend" --size 160x120 -o target/matrix
mkdir -p bench/results
cp target/matrix.md target/matrix.csv bench/results/
