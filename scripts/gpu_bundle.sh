#!/usr/bin/env bash
# Gathers what scripts/gpu_check.sh needs on a machine with a GPU, where there is no cargo and no network, into target/gpu:
# the program (with its kernels inside), models, and a slice of the kicad library with as many surfaces as ETER's Lego.
#
#   scripts/gpu_bundle.sh                 the program needs nvcc: scripts/install_nvcc.sh
#   scripts/gpu_bundle.sh --emulated      without CUDA kernels, to try gpu_check.sh --backend emulated
#
# HALFPIXEL_MODELS: where the models are [default: ../shared/models]. HALFPIXEL_LIBRARY: where the library is, or nothing to go
# without [default: target/library; bench/library.sh fetches it]. HALFPIXEL_FACES: faces of the slice [default: 300000].
set -euo pipefail
cd "$(dirname "$0")/.."

models=${HALFPIXEL_MODELS:-../shared/models}
library=${HALFPIXEL_LIBRARY-target/library}
faces=${HALFPIXEL_FACES:-300000}
out=target/gpu
# What travels to the GPU's machine at once, the repository with it.
limit=$((64 * 1024 * 1024))
# Polynomial and rational, free-form and trimmed, one part and assemblies.
chosen=(teapot.bpt killeroo.bpt sphere.bv twg2.bv 11752.stp NIST_MBE_PMI_2.stp as1-oc-214.stp gmsh_submarine.stp screw.step
    ublox_ANN-MB-00_SMA.stp)

nice cargo build --release
program=${CARGO_TARGET_DIR:-target}/release/halfpixel
if [ "${1:-}" != --emulated ] && "$program" devices --json | grep -q '"nvcc": null'; then
    echo "this program has no CUDA kernels: run scripts/install_nvcc.sh, and unset NVCC" >&2
    exit 1
fi

mkdir -p "$out"
rm -f "$out"/*.tar.xz
strip -o "$out/halfpixel" "$program"
xz -T0 -9 -f "$out/halfpixel"
git describe --always --dirty --abbrev=12 --exclude='*' >"$out/commit"

for name in "${chosen[@]}"; do
    [ -f "$models/$name" ] || { echo "$models has no $name: set HALFPIXEL_MODELS" >&2; exit 1; }
done
# The same files give the same archive: no dates, no owners.
pack() {
    tar --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner -cf - "$@" | nice xz -T0 --lzma2=preset=6,dict=128MiB
}
pack -C "$models" "${chosen[@]}" >"$out/models.tar.xz"

# Minutes of packing: kept while the list stays the same.
if [ -n "$library" ]; then
    list=$(python3 bench/library.py slice "$library" "$faces")
    packed=target/gpu-slice-$(sha256sum <<<"$list" | cut -c1-16).tar.xz
    if [ ! -f "$packed" ]; then
        pack -C "$library" -T - <<<"$list" >"$packed.partial"
        mv "$packed.partial" "$packed"
    fi
    cp "$packed" "$out/library.tar.xz"
fi

bytes=$(($(du -cb "$out"/* | tail -1 | cut -f1) + $(git ls-files -z | du -cb --files0-from=- | tail -1 | cut -f1)))
du -ch "$out"/*
if [ "$bytes" -gt "$limit" ]; then
    echo "with the repository this is $bytes bytes, more than $limit: set a smaller HALFPIXEL_FACES" >&2
    exit 1
fi
