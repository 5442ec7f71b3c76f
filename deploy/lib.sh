# Sourced by run and test: where the project is, messages, and what must be installed.

top=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { printf '\n== %s\n' "$*"; }

fail() {
  printf '%s: %s\n' "deploy/$(basename "$0")" "$*" >&2
  exit 1
}

# missing_packages [SECTION...]: of these sections of deploy/packages, or of all.
missing_packages() {
  comm -23 <(awk -v wanted=" $* " '/^# [A-Z][a-z]*$/ { on = wanted == "  " || index(wanted, " " $2 " ") }
      on { sub(/#.*/, ""); gsub(/ /, ""); if ($0 != "") print }' "$top/deploy/packages" | sort -u) \
    <(dpkg-query -W -f '${db:Status-Abbrev}${Package}\n' | sed -n 's/^ii *//p' | sort -u)
}

# install_missing [SECTION...]: touches the network only when a package is missing.
install_missing() {
  command -v dpkg-query >/dev/null || fail "this script installs Debian 12 packages; install those of deploy/packages by hand and build with CMake"
  local missing
  mapfile -t missing < <(missing_packages "$@")
  [ ${#missing[@]} -eq 0 ] || install_packages "${missing[@]}"
}

# install_packages PACKAGE...: fetches the package lists only when they do not know one.
install_packages() {
  local missing=("$@") as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || fail "as root, run: apt-get install --no-install-recommends ${missing[*]}"
    as_root=(sudo)
  fi
  say "Installing ${#missing[@]} packages: ${missing[*]}"
  local install=(apt-get install -y -qq --no-install-recommends -o Dpkg::Use-Pty=0)
  export DEBIAN_FRONTEND=noninteractive
  "${install[@]}" --simulate "${missing[@]}" >/dev/null 2>&1 || "${as_root[@]}" apt-get update -qq
  "${as_root[@]}" "${install[@]}" "${missing[@]}" >/dev/null ||
    { "${as_root[@]}" apt-get update -qq && "${as_root[@]}" "${install[@]}" "${missing[@]}" >/dev/null; } ||
    fail "could not install ${missing[*]}; see the messages above"
}

# protobufjs and @mcap/core, which Debian 12 does not have, into build/node, in the versions and with the hashes of
# tests/e2e/package-lock.json. Without them EndToEnd.Stranger and a test of EndToEnd.SessionData are skipped.
install_node_modules() {
  local folder=$top/build/node
  cmp -s "$top/tests/e2e/package-lock.json" "$folder/node_modules/fetched-by" && return
  say "Fetching protobufjs and @mcap/core"
  { command -v npm >/dev/null || (install_packages npm); } && mkdir -p "$folder" &&
    cp "$top"/tests/e2e/package{,-lock}.json "$folder" &&
    timeout 120 npm ci --prefix "$folder" --silent --ignore-scripts --no-audit --no-fund &&
    cp "$folder/package-lock.json" "$folder/node_modules/fetched-by" ||
    echo "deploy/$(basename "$0"): protobufjs and @mcap/core could not be fetched; EndToEnd.Stranger will be skipped" >&2
}

# build_preset PRESET [TARGET...]: configures and builds below build/PRESET; without tests where their packages are missing.
build_preset() {
  local preset=$1 targets=() tests=ON
  shift
  [ -z "$(missing_packages Test)" ] || tests=OFF
  [ $# -eq 0 ] || targets=(--target "$@")
  say "Building $preset"
  (cd "$top" && cmake --preset "$preset" "-DHAPTICS_TESTS=$tests" --log-level=NOTICE >/dev/null &&
    NINJA_STATUS='[%f/%t, %es] ' cmake --build --preset "$preset" "${targets[@]}")
}
