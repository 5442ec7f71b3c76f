# Sourced by the scripts of this folder: where the project is, messages, and what must be installed.

top=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { printf '\n== %s\n' "$*"; }

# fail MESSAGE [STATUS]
fail() {
  printf '%s: %s\n' "$(realpath -s --relative-to="$top" "$0")" "$1" >&2
  exit "${2:-1}"
}

# What was installed or built until Ctrl-C stays.
trap 'fail "interrupted; the same command goes on from here" 130' INT

os_release=/etc/os-release
# of_release KEY: what this system says of itself.
of_release() { (. "$os_release" 2>/dev/null || true; echo "${!1:-}"); }

# check_release: Debian 12 or 13; what is made from Debian may do.
check_release() {
  local name
  name=$(of_release PRETTY_NAME)
  case "$(of_release ID) $(of_release VERSION_ID) $(of_release ID_LIKE)" in
    "debian 12 "* | "debian 13 "*) ;;
    debian\ [0-9]*) fail "$name is not supported; Debian 12 and 13 are" ;;
    *debian*) echo "deploy/$(basename "$0"): tested on Debian 12 and 13, not on $name; going on" >&2 ;;
    *) fail "${name:-this system} is not supported; Debian 12 and 13 are; elsewhere install what deploy/packages lists and build with CMake" ;;
  esac
}

# named_packages [SECTION...]: of these sections of deploy/packages, or of all; without those that only another release has.
named_packages() {
  awk -v wanted=" $* " -v release="$(of_release VERSION_ID)" '/^# [A-Z][a-z0-9]*$/ { on = wanted == "  " || index(wanted, " " $2 " ") }
    on && (!/# only / || $0 ~ "# only " release ":") { sub(/#.*/, ""); gsub(/ /, ""); if ($0 != "") print }' \
    "$top/deploy/packages" | sort -u
}

# missing_packages [SECTION...]: of these, those that are not installed.
missing_packages() {
  comm -23 <(named_packages "$@") <(dpkg-query -W -f '${db:Status-Abbrev}${Package}\n' | sed -n 's/^ii *//p' | sort -u)
}

# install_missing [SECTION...]: touches the network only when a package is missing.
install_missing() {
  check_release
  local missing
  mapfile -t missing < <(missing_packages "$@")
  [ ${#missing[@]} -eq 0 ] || install_packages "${missing[@]}"
}

# install_packages PACKAGE...: fetches the package lists only when they do not know one, or are too old.
install_packages() {
  local missing=("$@") as_root=() unknown
  local offline="apt could not fetch its lists (is there no network, or does another apt run?); its messages are above"
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null && sudo true || fail "as root, run: apt-get install --no-install-recommends ${missing[*]}"
    as_root=(sudo env DEBIAN_FRONTEND=noninteractive)  # sudo keeps nothing of the environment
  fi
  say "Installing ${#missing[@]} packages: ${missing[*]}"
  export DEBIAN_FRONTEND=noninteractive
  local install=(apt-get install -y -qq --no-install-recommends -o Dpkg::Use-Pty=0)
  local update=("${as_root[@]}" apt-get update -qq -o APT::Update::Error-Mode=any)
  "${as_root[@]}" dpkg --configure -a >/dev/null || true  # what an interrupt left half installed
  if ! "${install[@]}" --simulate "${missing[@]}" >/dev/null 2>&1; then
    "${update[@]}" || "${install[@]}" --simulate "${missing[@]}" >/dev/null 2>&1 || fail "$offline"
    unknown=$(comm -23 <(printf '%s\n' "${missing[@]}" | sort) <(apt-cache pkgnames | sort) | paste -sd ' ')
    [ -z "$unknown" ] || fail "apt knows no package $unknown; are Debian's own sources in /etc/apt?"
  fi
  "${as_root[@]}" "${install[@]}" "${missing[@]}" >/dev/null && return
  "${update[@]}" || fail "$offline"
  "${as_root[@]}" "${install[@]}" "${missing[@]}" >/dev/null || fail "apt could not install all packages; its messages are above"
}

# fetch_node_modules LOCKED FOLDER: what LOCKED/package-lock.json names into FOLDER/node_modules, in its versions and with its
# hashes; nothing of it is run. Touches the network only when the lock file has changed.
fetch_node_modules() {
  cmp -s "$1/package-lock.json" "$2/node_modules/fetched-by" && return
  say "Fetching by npm what ${1#"$top/"} needs"
  { command -v npm >/dev/null || (install_packages npm); } && mkdir -p "$2" && cp "$1"/package{,-lock}.json "$2" &&
    timeout --foreground 120 npm ci --prefix "$2" --silent --ignore-scripts --no-audit --no-fund &&
    cp "$2/package-lock.json" "$2/node_modules/fetched-by"
}

# What tests need and Debian does not have: protobufjs and @mcap/core into build/node, the web page's packages into build/web.
# Without them EndToEnd.Stranger, EndToEnd.WebPage and a test of EndToEnd.SessionData are skipped.
install_node_modules() {
  fetch_node_modules "$top/graphics_client/web" "$top/build/web" ||
    echo "deploy/$(basename "$0"): the web page's packages could not be fetched; EndToEnd.WebPage will be skipped" >&2
  fetch_node_modules "$top/tests/e2e" "$top/build/node" ||
    echo "deploy/$(basename "$0"): protobufjs and @mcap/core could not be fetched; EndToEnd.Stranger will be skipped" >&2
}

# build_web_page OUT: the page of graphics_client/web, with its packages in build/web.
build_web_page() {
  fetch_node_modules "$top/graphics_client/web" "$top/build/web" &&
    "$top/graphics_client/web/build" "$top/build/web/node_modules" "$1" ||
    { echo "deploy/$(basename "$0"): the web page could not be built: its packages could not be fetched" >&2; return 1; }
}

# check_disk: why a build may have failed.
check_disk() {
  [ "$(df -k --output=avail "$top" "${TMPDIR:-/tmp}" | tail -n +2 | sort -n | head -n 1)" -gt 300000 ] ||
    fail "the disk is full; make room (a build takes 2 GB), then the same command goes on from here"
}

# is_configured PRESET TESTS: by these presets and with the packages that are installed; what else is changed the build sees.
is_configured() {
  local made=$top/build/$1/build.ninja
  [ "$made" -nt "$top/CMakePresets.json" ] && [ "$made" -nt /var/lib/dpkg/status ] &&
    grep -qx "HAPTICS_TESTS:[A-Z]*=$2" "$top/build/$1/CMakeCache.txt"
}

# build_preset PRESET [TARGET...]: configures and builds below build/PRESET; without tests where their packages are missing.
build_preset() {
  local preset=$1 targets=() tests=ON
  shift
  [ -z "$(missing_packages Test)" ] || tests=OFF
  [ $# -eq 0 ] || targets=(--target "$@")
  say "Building $preset"
  (cd "$top" &&
    { is_configured "$preset" "$tests" ||
      cmake --preset "$preset" "-DHAPTICS_TESTS=$tests" -Wno-dev --log-level=NOTICE >/dev/null; } &&
    NINJA_STATUS='[%f/%t, %es] ' cmake --build --preset "$preset" "${targets[@]}") && return
  check_disk
  return 1
}
