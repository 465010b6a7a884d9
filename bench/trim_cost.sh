#!/bin/sh
# What trimming costs: the whole frame with trims and with `--trim off`, by turns in one run a model, four views at zoom 1,
# 4 and 16. Writes bench/results/trim-cost.csv and .md; a minute on a quiet machine. Needs a release build and the models that
# tests/support/mod.rs names ($HALFPIXEL_MODELS or ../shared/models).
set -eu
cd "$(dirname "$0")/.."
models=${HALFPIXEL_MODELS:-../shared/models}
program=${HALFPIXEL:-target/release/halfpixel}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for model in NIST_MBE_PMI_2.stp 11752.stp ublox_ANN-MB-00_SMA.stp kicad_Molex_SlimStack_54722-0804_2x40.step; do
    "$program" compare --trims on,off --bounds screen --grids adaptive --tolerances 0.5 --views iso,front,top,left \
        --zooms 1,4,16 --size 1920x1080 --frames 15 --samples 1000 -o "$work/$model" "$models/$model" > /dev/null
done
python3 bench/trim_cost.py "$work"/*.csv
