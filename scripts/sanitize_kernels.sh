#!/usr/bin/env bash
# Proves that the sanitizers see what kernels do on the CPU: a missing barrier is a race (ThreadSanitizer), an access beyond
# memory is found (AddressSanitizer), and right kernels pass. Then all launches of recorded frames, under both and under
# UndefinedBehaviorSanitizer: they pass, every buffer is as recorded, and with one line of a kernel changed they do not.
# Prints one line a check; a sanitizer that this compiler does not have is skipped with a line that says so. Exit status 1:
# one of them missed something or complained without reason.
#
#   scripts/sanitize_kernels.sh [FOLDER [RECORDING...]]   builds under FOLDER (default target/sanitize_kernels); CXX is used
#                                                         if set
# `cargo test --test kernels sanitizers` records frames and runs this on them.
set -uo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
folder=${1:-$root/target/sanitize_kernels}
mkdir -p "$folder" || exit 1
folder=$(cd "$folder" && pwd)
recordings=("${@:2}")
cxx=${CXX:-c++}
jobs=$(nproc 2>/dev/null || echo 2)
export TSAN_OPTIONS="halt_on_error=1 exitcode=66 atexit_sleep_ms=0"
export ASAN_OPTIONS="exitcode=67:detect_leaks=0" UBSAN_OPTIONS="halt_on_error=1:exitcode=68"
failed=0

# -fno-threadsafe-statics and so on: as build.rs. The driver is plain C++.
flags=(-std=c++20 -O1 -g1 -I "$root/kernels" -ffp-contract=off -fno-strict-aliasing -fno-exceptions -fno-rtti
    -fno-threadsafe-statics -Wno-unknown-pragmas -pthread "-fmacro-prefix-map=$root/=")

# build NAME SANITIZER [KERNEL FLAG...]: the runtime is told of ThreadSanitizer, not instrumented by it.
build() {
    local name=$1 sanitizer=$2 runtime=(-fsanitize="$2")
    shift 2
    [ "$sanitizer" = thread ] && runtime=(-DHP_TSAN)
    compile "$folder/$name/host" "${runtime[@]}" -- "$root"/kernels/host/*.cpp || return 1
    compile "$folder/$name/kernels" -fsanitize="$sanitizer" "$@" -- "$root"/kernels/host/selftest/{block,sanitize}.cu || return 1
    link "$sanitizer" sanitize "$folder/$name/run" "$folder/$name"/{host,kernels}/*.o
}

# compile FOLDER FLAG... -- SOURCE...: an object for each, in a folder that has no others.
compile() {
    local into=$1 own=()
    shift
    while [ "$1" != -- ]; do
        own+=("$1")
        shift
    done
    shift
    rm -rf "$into" && mkdir -p "$into" || return 1
    (cd "$into" && printf '%s\0' "$@" | xargs -0 -n 2 -P "$jobs" "$cxx" "${flags[@]}" "${own[@]}" -x c++ -c)
}

# link SANITIZER DRIVER PROGRAM OBJECT...
link() {
    local sanitizer=$1 driver=$2 program=$3
    shift 3
    "$cxx" -std=c++20 -O1 -g -pthread -I "$root/kernels" -fsanitize="$sanitizer" \
        "$root/kernels/host/selftest/$driver.cpp" "$@" -o "$program"
}

# frames NAME SANITIZER: all kernels that build.rs compiles, with the runtime of `build NAME`.
frames() {
    compile "$folder/$1/frames" -fsanitize="$2" -- "$root"/kernels/*.cu &&
        link "$2" replay "$folder/$1/replay" "$folder/$1"/{host,frames}/*.o
}

# without NAME SANITIZER KERNEL FILE LINE REPLACEMENT: the same, but in this kernel's build the file has another line.
without() {
    local name=$1 sanitizer=$2 kernel=$3 file=$4 own=$folder/$1/changed
    # All of them: a header is first looked for beside the file that includes it.
    rm -rf "$own" && mkdir -p "$own" && cp "$root"/kernels/*.{cu,cuh,h} "$own" || return 1
    sed "s|$5|$6|" "$root/kernels/$file" >"$own/$file"
    if cmp -s "$root/kernels/$file" "$own/$file"; then
        echo "kernels/$file has no '$5' any more: change scripts/sanitize_kernels.sh"
        return 1
    fi
    compile "$own/object" -fsanitize="$sanitizer" -w -- "$own/$kernel.cu" || return 1
    local objects=() object
    for object in "$folder/$name"/frames/*.o; do
        [ "$(basename "$object")" = "$kernel.o" ] || objects+=("$object")
    done
    # First, since of inline functions the linker takes the first one.
    link "$sanitizer" replay "$folder/$name/replay_changed" "$own/object/$kernel.o" "$folder/$name"/host/*.o "${objects[@]}"
}

supported() {
    echo 'int main() { return 0; }' >"$folder/probe.cpp"
    "$cxx" -fsanitize="$1" "$folder/probe.cpp" -o "$folder/probe" 2>"$folder/probe.log" && "$folder/probe" 2>>"$folder/probe.log"
}

# check SANITIZER BUILD KERNEL WORDS: the report must have the words; none: there must be no report.
check() {
    judge "$1" "$3 ($2)" "$4" "$folder/$2/$3.log" "$folder/$2/run" "$3"
}

# judge SANITIZER WHAT WORDS LOG COMMAND...
judge() {
    local sanitizer=$1 what=$2 words=$3 log=$4
    shift 4
    "$@" >"$log" 2>&1
    local status=$?
    if [ -z "$words" ] && [ $status -eq 0 ]; then
        echo "$sanitizer: $what passes$(sed -n 's/^[0-9]* launches.*/: &/p' "$log")"
    elif [ -n "$words" ] && [ $status -ge 66 ] && grep -q "$words" "$log"; then
        echo "$sanitizer: $what is found: $(grep -m1 -oE '(kernels|changed)/[^ ]*:[0-9]+' "$log")"
    else
        echo "$sanitizer: $what ended with $status, expected ${words:-no report}"
        head -40 "$log"
        failed=1
    fi
}

# replay SANITIZER NAME: every recorded frame passes.
replay() {
    local recording
    for recording in "${recordings[@]}"; do
        judge "$1" "$(basename "$recording")" "" "$recording.log" "$folder/$2/replay" "$recording"
    done
}

# Some recorded frame shows that a line was changed: changed SANITIZER NAME WORDS KERNEL FILE LINE REPLACEMENT.
changed() {
    local sanitizer=$1 name=$2 words=$3 recording log=$folder/changed.log
    without "$name" "$sanitizer" "${@:4}" || { failed=1; return; }
    for recording in "${recordings[@]}"; do
        "$folder/$name/replay_changed" "$recording" >/dev/null 2>&1 && continue
        break
    done
    judge "$sanitizer" "$4 with '$7' for '$6' in $5 ($(basename "$recording"))" "$words" "$log" "$folder/$name/replay_changed" "$recording"
}

if ! supported thread; then
    echo "thread: skipped, $cxx can't build or run with -fsanitize=thread: $(head -1 "$folder/probe.log")"
elif build right thread && build wrong thread -DSELFTEST_NO_BARRIER; then
    for kernel in selftest_block sanitize_warp sanitize_shuffle sanitize_blocks sanitize_fence selftest_poison; do
        check thread right $kernel ""
    done
    for kernel in selftest_block sanitize_warp sanitize_shuffle sanitize_blocks sanitize_fence; do
        check thread wrong $kernel "data race"
    done
    if [ ${#recordings[@]} -eq 0 ]; then
        echo "thread: no frame was recorded"
    elif frames right thread; then
        replay thread right
        changed thread right "data race" rasterize outlines.cuh '__syncwarp(mask);' ''
        changed thread right "data race" scan scan.cu '__syncthreads();' ''
        changed thread right "data race" split team.cuh '__syncwarp();' ''
    else
        failed=1
    fi
else
    failed=1
fi

if ! supported address; then
    echo "address: skipped, $cxx can't build or run with -fsanitize=address: $(head -1 "$folder/probe.log")"
elif build memory address; then
    for kernel in selftest_block sanitize_within sanitize_warp selftest_poison; do
        check address memory $kernel ""
    done
    check address memory sanitize_beyond_buffer heap-buffer-overflow
    check address memory sanitize_beyond_shared use-after-poison
    if [ ${#recordings[@]} -eq 0 ]; then
        echo "address: no frame was recorded"
    elif frames memory address; then
        replay address memory
        changed address memory stack-buffer-overflow shade patch_point.cuh '? sum<4>' '? sum<2>'
    else
        failed=1
    fi
else
    failed=1
fi

if ! supported undefined; then
    echo "undefined: skipped, $cxx can't build or run with -fsanitize=undefined: $(head -1 "$folder/probe.log")"
elif [ ${#recordings[@]} -eq 0 ]; then
    echo "undefined: no frame was recorded"
elif build defined undefined && frames defined undefined; then
    replay undefined defined
    changed undefined defined "shift exponent" rasterize topology.cuh 'Word(__float_as_uint(depth)) << 32' \
        '__float_as_uint(depth) << 32'
else
    failed=1
fi
exit $failed
