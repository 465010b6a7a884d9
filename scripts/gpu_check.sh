#!/usr/bin/env bash
# Everything that a GPU is needed for, in one run of at most nine minutes, from what scripts/gpu_bundle.sh gathered: do all
# kernels load, do frames agree with the CPU's, does compute-sanitizer find anything, and how fast is it. A step that fails or
# takes too long is reported, and the next one runs; what no time is left for is named. Writes OUT/report.md, OUT/steps.csv and OUT/results.tar.gz.
#
#   scripts/gpu_check.sh [--backend cuda|emulated]     emulated: as far as it goes without a GPU, and smaller
#
# OUT: where results go [default: target/gpu/results]. HALFPIXEL_SECONDS: for everything [default: 540].
set -uo pipefail
cd "$(dirname "$0")/.."

backend=cuda
case "${1:-}" in
--backend) backend=${2:?usage: scripts/gpu_check.sh [--backend cuda|emulated]} ;;
"") ;;
*) echo "usage: scripts/gpu_check.sh [--backend cuda|emulated]" >&2 && exit 2 ;;
esac
bundle=$PWD/target/gpu
out=${OUT:-$bundle/results}
seconds=${HALFPIXEL_SECONDS:-540}
# The last of them are for the report, and for a step that does not end when it is told to.
deadline=$((seconds - seconds / 36))
[ -f "$bundle/models.tar.xz" ] || { echo "target/gpu holds no bundle: run scripts/gpu_bundle.sh" >&2; exit 2; }
mkdir -p "$out"
out=$(cd "$out" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/models" "$work/library" "$work/found"
# What `bench evaluate` finds is for the steps after it, not for this user's later frames.
export HALFPIXEL_COMMIT HALFPIXEL_CACHE=$work/cache
HALFPIXEL_COMMIT=$(cat "$bundle/commit")
xz -dc "$bundle/halfpixel.xz" >"$work/halfpixel" && chmod +x "$work/halfpixel"
xz -dc "$bundle/models.tar.xz" | tar -xf - -C "$work/models"
# The library takes a while, and is needed late.
unpacked=
if [ -f "$bundle/library.tar.xz" ]; then
    (xz -dc "$bundle/library.tar.xz" | tar -xf - -C "$work/library") &
    unpacked=$!
fi
cd "$work" || exit 1
program=$work/halfpixel
found=$work/found
echo "step,status,seconds,limit" >"$out/steps.csv"

# left_out NAME WHY
left_out() {
    echo "$1,$2: left out,0,0" | tee -a "$out/steps.csv"
}

# step NAME LIMIT COMMAND...: within LIMIT seconds, and within what is left of all: limits may sum to more than there is.
step() {
    local name=$1 limit=$2 begin=$SECONDS left=$((deadline - SECONDS)) status
    shift 2
    [ "$limit" -le "$left" ] || limit=$left
    if [ "$limit" -lt 5 ]; then
        left_out "$name" "no time"
        return
    fi
    timeout -k 5 "$limit" "$@" >"$found/$name.log" 2>&1
    status=$?
    case $status in
    0) status=done ;;
    124 | 137) status="timed out" ;;
    *) status="failed with $status" ;;
    esac
    echo "$name,$status,$((SECONDS - begin)),$limit" | tee -a "$out/steps.csv"
}

bench() {
    local name=$1 limit=$2
    shift 2
    step "$name" "$limit" "$program" bench "$@" --backend "$backend" -o "$found/$name"
}

# Vulkan's mesh shaders beside the software rasteriser, where the machine has a Vulkan device.
raster() {
    # Not by drivers that draw on the CPU where a GPU's time is dear.
    local unwanted='(cpu, '
    [ "$backend" = cuda ] || unwanted='not available'
    if "$program" devices | grep '^vulkan' | grep -v 'not available' | grep -qvF "$unwanted"; then
        # The oracle on what mesh shaders drew, in memory that both see.
        local size=640x360
        [ "$backend" = cuda ] || size=96x64
        step verify-raster 30 "$program" verify "$1" --backend "$backend" --raster hardware --size "$size" --samples 500 --json
        bench raster 60 raster "$@" --forget
        step tessellation 30 "$program" bench tessellation -o "$found/tessellation"
    else
        left_out verify-raster "no Vulkan device"
        left_out raster "no Vulkan device"
        left_out tessellation "no Vulkan device"
    fi
}

facts() {
    uname -a
    grep -m1 "model name" /proc/cpuinfo
    nproc
    if [ "$backend" = cuda ]; then
        nvidia-smi
        nvidia-smi --query-gpu=name,driver_version,clocks.sm,clocks.mem,clocks.max.sm,power.limit,ecc.mode.current --format=csv
        nvcc --version
    fi
    "$program" devices --json
}
export -f facts
export backend program

# A frame with trims, strokes and refinement, under a tool of compute-sanitizer.
sanitize() {
    local tool=$1 compute
    compute=$(command -v compute-sanitizer || ls /usr/local/cuda*/bin/compute-sanitizer 2>/dev/null | head -1)
    if [ -z "$compute" ]; then
        left_out "$tool" "no compute-sanitizer"
        return
    fi
    step "$tool" 50 "$compute" --tool "$tool" --error-exitcode 9 --print-limit 20 \
        "$program" render builtin:trimmed:drilled --backend cuda --size 96x64 -o "$work/$tool.png"
}

# The library's faces, as many surfaces as ETER's Lego: the large scenes. LIMIT and that of copies of it, 0: none.
library() {
    local limit=$1 copies=$2
    shift 2
    if [ -z "$unpacked" ] || ! wait "$unpacked"; then
        left_out library "not in the bundle"
        return
    fi
    find library -type f | sort >files.txt
    # The emulator takes the smallest few.
    [ "$backend" = cuda ] || { find library -type f -printf '%s %p\n' | sort -n | head -3 | cut -d' ' -f2- >files.txt; }
    bench library "$limit" frame @files.txt --patches 1 --layout grid "$@"
    [ "$copies" -eq 0 ] || bench library-copies "$copies" frame @files.txt --frames 3 --layout grid "$@"
}

# What matters most comes first: where the time ends, the rest is left out, and said so.
step facts 20 bash -c facts
if [ "$backend" = cuda ]; then
    step load 30 "$program" devices --load
    bench backends 60 backends models/* --size 640x360
    bench matrix 45 matrix models/teapot.bpt models/killeroo.bpt models/NIST_MBE_PMI_2.stp --pairwise --size 320x240
    step verify 30 "$program" verify models/teapot.bpt --backend cuda --size 640x360 --samples 2000 --json
    bench evaluate 60 evaluate
    raster models/teapot.bpt models/killeroo.bpt models/NIST_MBE_PMI_2.stp --samples 300 --size 1920x1080
    # The large scene that targets are set for.
    bench rings 90 frame builtin:rings --frames 3 --samples 100 --size 3840x2160 --zoom 3
    bench frame 60 frame models/killeroo.bpt --samples 300 --size 1920x1080
    library 60 90 --samples 100 --size 1920x1080
    sanitize memcheck
    sanitize racecheck
    bench precision 60 precision
    bench frame-trimmed 40 frame models/NIST_MBE_PMI_2.stp --samples 300 --size 1920x1080
    bench frame-720p 40 frame models/killeroo.bpt --samples 0 --size 1280x720
else
    bench backends 120 backends models/teapot.bpt models/screw.step --size 96x64
    bench matrix 60 matrix models/teapot.bpt --pairwise --size 96x64
    step verify 60 "$program" verify models/teapot.bpt --backend emulated --size 96x64 --samples 200 --json
    bench evaluate 120 evaluate --patches 4
    bench rings 120 frame builtin:rings --patches 1 --frames 1 --samples 20 --size 96x54 --zoom 3
    bench precision 120 precision --patches 2
    raster models/teapot.bpt --frames 1 --samples 50 --size 96x64
    bench frame 120 frame models/teapot.bpt --patches 128 --frames 1 --samples 50 --size 96x64
    library 120 0 --frames 1 --samples 0 --size 96x64
fi

{
    echo "# What a run with --backend $backend found"
    echo
    echo "Commit $HALFPIXEL_COMMIT, $(date -u +%F), $SECONDS seconds of $seconds."
    echo
    echo "| step | status | seconds | limit |"
    echo "| --- | --- | ---: | ---: |"
    tail -n +2 "$out/steps.csv" | sed 's/,/ | /g; s/^/| /; s/$/ |/'
    for log in facts load verify memcheck racecheck; do
        [ -f "$found/$log.log" ] && printf '\n## %s\n\n```\n%s\n```\n' "$log" "$(head -c 6000 "$found/$log.log")"
    done
    for table in "$found"/*.md; do
        [ -f "$table" ] && printf '\n' && sed 's/^#/##/' "$table"
    done
    # What went wrong, in its own words.
    grep -v ",done," "$out/steps.csv" | tail -n +2 | cut -d, -f1 | while read -r name; do
        [ -f "$found/$name.log" ] && printf '\n## %s, its last words\n\n```\n%s\n```\n' "$name" "$(tail -c 2000 "$found/$name.log")"
    done
} >"$out/report.md"
tar -czf "$out/results.tar.gz" -C "$found" .
echo "$out/report.md"
missed=$(grep ",no time: left out," "$out/steps.csv" | cut -d, -f1 | paste -sd ' ')
[ -z "$missed" ] || echo "no time was left for: $missed"
[ -z "$missed" ] && ! grep -qv -e ",done," -e "^step," -e ": left out," "$out/steps.csv"
