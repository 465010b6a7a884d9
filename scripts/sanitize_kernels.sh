#!/usr/bin/env bash
# Proves that the sanitizers see what kernels do on the CPU: a missing barrier is a race (ThreadSanitizer), an access beyond
# memory is found (AddressSanitizer), and right kernels pass. Prints one line a check; a sanitizer that this compiler does
# not have is skipped with a line that says so. Exit status 1: one of them missed something or complained without reason.
#
#   scripts/sanitize_kernels.sh [FOLDER]     builds under FOLDER (default target/sanitize_kernels); CXX is used if set
set -uo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
folder=${1:-$root/target/sanitize_kernels}
cxx=${CXX:-c++}
failed=0
mkdir -p "$folder" || exit 1

# -fno-threadsafe-statics and so on: as build.rs. The driver is plain C++.
flags=(-std=c++20 -O1 -g -I "$root/kernels" -ffp-contract=off -fno-strict-aliasing -fno-exceptions -fno-rtti
    -fno-threadsafe-statics -Wno-unknown-pragmas -pthread "-fmacro-prefix-map=$root/=")

# build NAME SANITIZER [KERNEL FLAG...]: the runtime is told of ThreadSanitizer, not instrumented by it.
build() {
    local name=$1 sanitizer=$2 object=$folder/$1 runtime=(-fsanitize="$2")
    shift 2
    [ "$sanitizer" = thread ] && runtime=(-DHP_TSAN)
    mkdir -p "$object"
    local file list=()
    for file in "$root"/kernels/host/*.cpp; do
        list+=("$object/$(basename "$file").o")
        "$cxx" "${flags[@]}" "${runtime[@]}" -c "$file" -o "${list[-1]}" || return 1
    done
    for file in block sanitize; do
        list+=("$object/$file.cu.o")
        "$cxx" "${flags[@]}" -fsanitize="$sanitizer" "$@" -x c++ -c "$root/kernels/host/selftest/$file.cu" \
            -o "${list[-1]}" || return 1
    done
    "$cxx" -std=c++20 -O1 -g -pthread -I "$root/kernels" -fsanitize="$sanitizer" \
        "$root/kernels/host/selftest/sanitize.cpp" "${list[@]}" -o "$folder/$name/run"
}

supported() {
    echo 'int main() { return 0; }' >"$folder/probe.cpp"
    "$cxx" -fsanitize="$1" "$folder/probe.cpp" -o "$folder/probe" 2>"$folder/probe.log" && "$folder/probe" 2>>"$folder/probe.log"
}

# check SANITIZER BUILD KERNEL WORDS: the report must have the words; none: there must be no report.
check() {
    local log=$folder/$2/$3.log
    TSAN_OPTIONS="halt_on_error=1 exitcode=66" ASAN_OPTIONS="exitcode=67:detect_leaks=0" \
        "$folder/$2/run" "$3" >"$log" 2>&1
    local status=$?
    if [ -z "$4" ] && [ $status -eq 0 ]; then
        echo "$1: $3 ($2) passes"
    elif [ -n "$4" ] && [ $status -ge 66 ] && grep -q "$4" "$log"; then
        echo "$1: $3 ($2) is found: $(grep -m1 -oE 'kernels/[^ ]*:[0-9]+' "$log")"
    else
        echo "$1: $3 ($2) ended with $status, expected ${4:-no report}"
        head -40 "$log"
        failed=1
    fi
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
else
    failed=1
fi
exit $failed
