#!/usr/bin/env bash
# Puts glslang, the GLSL compiler, as PyPI packages it, into target/glslang: no root, nothing outside the folder is touched.
#
#   scripts/install_glslang.sh
#
# tests/shaders.rs compiles vk_shaders with it: target/glslang/cmeel.prefix/bin/glslang, with cmeel.prefix/lib in
# LD_LIBRARY_PATH. Pinned, since Debian 12's version declares a capability for mesh shaders that they do not use.
# A second run does nothing. Needs python3 with pip. Versions and hashes: glslang_wheels.txt.
set -euo pipefail
cd "$(dirname "$0")/.."

wheels=scripts/glslang_wheels.txt
folder=target/glslang
stamp=target/glslang.installed
prefix=cmeel.prefix

fail() {
    echo "install_glslang.sh: $*" >&2
    exit 1
}
glslang() { LD_LIBRARY_PATH="$folder/$prefix/lib" "$folder/$prefix/bin/glslang" "$@"; }
cmp -s "$wheels" "$stamp" && [ -x "$folder/$prefix/bin/glslang" ] && exit 0

case "$(uname -s) $(uname -m)" in
"Linux x86_64" | "Linux aarch64") ;;
*) fail "there are no wheels of glslang for $(uname -sm)" ;;
esac
python3 -m pip --version >/dev/null 2>&1 || fail "needs python3 with pip: on Debian, apt-get install python3-pip"

partial=$folder.partial.$$
trap 'rm -rf "$partial" "$partial.log"' EXIT
mkdir -p target
# Binaries only, the exact files of the list: nothing is built and no script of a package runs.
python3 -m pip --disable-pip-version-check install --quiet --no-compile --no-deps --only-binary=:all: --require-hashes \
    --target "$partial" -r "$wheels" 2>"$partial.log" ||
    fail "the wheels could not be installed: $(grep -m1 -i error "$partial.log" || tail -n1 "$partial.log")"
chmod +x "$partial/$prefix"/bin/*
rm -rf "$folder"
mv "$partial" "$folder"
glslang --version >/dev/null || fail "glslang does not run on this machine"
cp "$wheels" "$stamp"
echo "installed $(glslang --version | sed -n 's/^Glslang Version: [0-9]*:/glslang /p') in $folder"
