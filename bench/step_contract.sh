#!/bin/sh
# The accuracy contract on real STEP files, every pixel: 7 views x zoom 1, 8, 64, in perspective and orthographic.
# Writes bench/results/step-contract-*.{md,csv}; 3 minutes. Needs a release build and the models that
# tests/support/mod.rs names ($HALFPIXEL_MODELS or ../shared/models).
set -eu
cd "$(dirname "$0")/.."
models=${HALFPIXEL_MODELS:-../shared/models}
program=${HALFPIXEL:-target/release/halfpixel}
contract() {
    "$program" bench contract --bounds screen --frames 1 --samples 307200 --size 640x480 "$@"
}
for projection in perspective orthographic; do
    contract --projections $projection -o "bench/results/step-contract-$projection" "$models"/*.stp "$models"/*.step
done
