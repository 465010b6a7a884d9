#!/usr/bin/env bash
# Brings a Vulkan device with mesh shaders to a machine without a GPU: Mesa's lavapipe, with Vulkan's loader and its
# validation layers.
#
#   scripts/install_lavapipe.sh
#
# Lavapipe has mesh shaders from Mesa 24.1 on. Debian 12 has that in bookworm-backports: a list of this suite is added
# where no list names it, and the drivers and what they need are taken from there. Needs Debian 12 or newer, and root or
# sudo. Where everything is there already, it does nothing.
set -euo pipefail

MESA=24.1
layer=/usr/share/vulkan/explicit_layer.d/VkLayer_khronos_validation.json
list=/etc/apt/sources.list.d/bookworm-backports.list
keyring=/usr/share/keyrings/debian-archive-keyring.gpg

fail() {
    echo "install_lavapipe.sh: $*" >&2
    exit 1
}
# The version of Mesa's Vulkan drivers, or nothing.
mesa() { dpkg-query -W -f '${db:Status-Status} ${Version}\n' mesa-vulkan-drivers 2>/dev/null | sed -n '/^installed /{s///p;q}'; }
missing() {
    dpkg --compare-versions "$(mesa)" ge $MESA || echo "Mesa $MESA's Vulkan drivers"
    compgen -G "/usr/share/vulkan/icd.d/lvp_icd*.json" >/dev/null || echo "lavapipe"
    grep -q 'libvulkan\.so\.1 ' <<<"$(/sbin/ldconfig -p)" || echo "libvulkan.so.1"
    [ -f $layer ] || echo "Khronos' validation layer"
}

by_hand="install Mesa $MESA or newer with lavapipe, libvulkan and Khronos' validation layers by hand"
for tool in apt-get dpkg-query; do
    command -v $tool >/dev/null || fail "there is no $tool here: $by_hand"
done
[ -n "$(missing)" ] || exit 0

. /etc/os-release
# Debian's testing and unstable have no number.
version=${VERSION_ID:-unstable}
[ "${ID:-}" = debian ] || fail "this is ${PRETTY_NAME:-no Debian}: $by_hand"
[ "$version" = unstable ] || [ "$version" -ge 12 ] || fail "Debian $version is too old: $by_hand"

as_root=()
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || fail "needs root or sudo"
    as_root=(sudo)
fi
install() { "${as_root[@]}" apt-get install -y --no-install-recommends "$@"; }

suite=()
if [ "$version" = 12 ]; then
    suite=(-t bookworm-backports)
    grep -rqs '^[^#]*bookworm-backports' /etc/apt/sources.list /etc/apt/sources.list.d ||
        echo "deb [signed-by=$keyring] http://deb.debian.org/debian bookworm-backports main" |
        "${as_root[@]}" tee $list >/dev/null
fi
# A list of someone else that can't be read does no harm here.
"${as_root[@]}" apt-get update || echo "install_lavapipe.sh: apt-get update failed, going on with what is known" >&2
install "${suite[@]}" mesa-vulkan-drivers || fail "mesa-vulkan-drivers could not be installed"
install libvulkan1 vulkan-validationlayers || fail "Vulkan's loader and layers could not be installed"
left=$(missing)
[ -z "$left" ] || fail "still missing: ${left//$'\n'/, }"
echo "installed Mesa $(mesa) with lavapipe"
