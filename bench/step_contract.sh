#!/bin/sh
# The accuracy contract on real STEP files: 7 views x zoom 1, 8, 64 in perspective, and in orthographic projection for
# three of them. Writes bench/results/step-contract*.{md,csv}. Needs a release build and the models that
# tests/support/mod.rs names ($HALFPIXEL_MODELS or ../shared/models).
set -eu
cd "$(dirname "$0")/.."
models=${HALFPIXEL_MODELS:-../shared/models}
program=${HALFPIXEL:-target/release/halfpixel}
contract() {
    "$program" bench contract --bounds screen --frames 1 --samples 3000 --size 640x480 "$@"
}
contract --projections perspective -o bench/results/step-contract "$models"/*.stp "$models"/*.step
contract --projections orthographic -o bench/results/step-contract-orthographic \
    "$models/NIST_MBE_PMI_2.stp" "$models/as1-oc-214.stp" "$models/screw.step"
