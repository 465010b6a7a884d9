#!/usr/bin/env bash
# Puts NVIDIA's CUDA compiler, as PyPI packages it, into target/nvcc: no root, nothing outside the folder is touched.
#
#   scripts/install_nvcc.sh
#
# build.rs looks there after the usual places. About 100 MB are downloaded and 330 MB unpacked; a second run does
# nothing. Needs python3 with pip, and g++ once kernels are compiled. Versions and hashes: nvcc_wheels.txt.
set -euo pipefail
cd "$(dirname "$0")/.."

wheels=scripts/nvcc_wheels.txt
folder=target/nvcc
# Cargo watches this file: writing it makes the next build look for nvcc again.
stamp=target/nvcc.installed
nvcc=$folder/nvidia/cu13/bin/nvcc

fail() {
    echo "install_nvcc.sh: $*" >&2
    exit 1
}
cmp -s "$wheels" "$stamp" && [ -x "$nvcc" ] && exit 0

case "$(uname -s) $(uname -m)" in
"Linux x86_64" | "Linux aarch64") ;;
*) fail "NVIDIA has no wheels of nvcc for $(uname -sm): install the CUDA toolkit and set CUDA_HOME" ;;
esac
python3 -m pip --version >/dev/null 2>&1 || fail "needs python3 with pip: on Debian, apt-get install python3-pip"

partial=$folder.partial.$$
trap 'rm -rf "$partial" "$partial.log"' EXIT
mkdir -p target
# Binaries only, the exact files of the list: nothing is built and no script of a package runs.
python3 -m pip --disable-pip-version-check install --quiet --no-compile --no-deps --only-binary=:all: --require-hashes \
    --target "$partial" -r "$wheels" 2>"$partial.log" ||
    fail "the wheels could not be installed: $(grep -m1 -i error "$partial.log" || tail -n1 "$partial.log")"
chmod +x "$partial"/nvidia/cu13/bin/* "$partial/nvidia/cu13/nvvm/bin/cicc"
rm -rf "$folder"
mv "$partial" "$folder"
"$nvcc" --version >/dev/null || fail "$nvcc does not run on this machine"
cp "$wheels" "$stamp"
echo "installed $("$nvcc" --version | sed -n 's/.*release \([^,]*\), V\(.*\)/nvcc \2/p') in $folder"
