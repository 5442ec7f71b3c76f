# In a root of fresh_root: in_fresh_root.sh run|tour|test|packages. Every line must succeed.
set -eu
say() { printf '\n== %s\n' "$*"; }
fail() { echo "in_fresh_root: $*" >&2; exit 1; }

case $1 in
  run)
    cd /clone/haptics
    deploy/run --headless --seconds 5
    exit
    ;;
  tour)
    cd /clone/haptics
    start=$(sed -n 's/.*(without a display: `\([^`]*\)`.*/\1/p' README.md)
    $start >run.log 2>&1 &
    run=$!
    until grep -q '^haptic_server listens at 127.0.0.1:7654;' run.log; do
      kill -0 $run || { cat run.log; fail "$start ended"; }
      sleep 1
    done
    HAPTICS_BIN=$PWD/build/release/bin PYTHONPATH=tests/e2e python3 - <<'PYTHON'
import pages
tour = pages.section((pages.PROJECT / "README.md").read_text(), "A tour of five minutes")
shell = pages.Shell(pages.PROJECT)
for command, shown in [found for block in pages.blocks(tour) for found in pages.commands_in(block)]:
    if command.startswith("haptic_eval"):  # deploy/run does not build it
        continue
    status, output = shell.run(command, 300)
    print("$", command)
    print(output, flush=True)
    assert status == 0, f"exit status {status}"
    assert not shown or pages.is_as_shown(output, shown), "\n".join(["shown:", *shown])
shell.close()
PYTHON
    kill $run
    wait $run || { cat run.log; fail "$start failed"; }
    exit
    ;;
  test)
    cd /clone/haptics
    objects=$(find build/release -path '*.dir/*.o')
    touch stamp
    deploy/test
    deploy/run --headless --seconds 5
    again=$(find $objects -newer stamp)
    [ -z "$again" ] || fail "compiled twice: $again"
    exit
    ;;
esac

traces() { find / -xdev \( -path /packages -o -path /proc -o -path /tmp \) -prune -o -iname '*haptic*' -print; }
export DEBIAN_FRONTEND=noninteractive LP_NUM_THREADS=1 HOME=/tmp
cd /tmp

say "Install"
apt-get update -qq
apt-get install -y -qq --no-install-recommends -o Dpkg::Use-Pty=0 /packages/*.deb inventor-data xvfb xauth bash-completion \
  g++ make cmake libprotobuf-dev libopenmesh-dev libssl-dev >/dev/null
[ -z "$(find /etc/systemd -name '*haptic*')" ] || fail "the service was enabled without being asked for"

say "Every program, its manual and its completion"
for program in haptic_server graphics_client hapticctl haptic_relay haptic_ros2 haptic_eval mesh_report; do
  "$program" --version
  [ -s "/usr/share/man/man1/$program.1.gz" ] || fail "$program has no manual"
done
complete() {  # complete WORD...: what Tab offers for the last one
  bash -c 'source /usr/share/bash-completion/bash_completion; _completion_loader "$1"
    COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMP_LINE="$*" COMP_POINT=${#COMP_LINE}
    $(complete -p "$1" | sed -n "s/.*-F \([^ ]*\) .*/\1/p") "$1" "${!#}" "${COMP_WORDS[COMP_CWORD - 1]}"
    printf "%s\n" "${COMPREPLY[@]}"' - "$@"
}
complete haptic_server --sce | grep -qx -- --scene || fail "no completion of haptic_server --sce"
complete hapticctl sta | grep -qx status || fail "no completion of hapticctl sta"
complete hapticctl apply --upl | grep -qx -- --upload || fail "no completion of hapticctl apply --upl"

say "Doctor"
haptic_server doctor --help >/dev/null
timeout 120 haptic_server doctor >doctor.txt || true  # this machine need not be a good one
grep -qi kernel doctor.txt || { cat doctor.txt; fail "the doctor found nothing"; }

say "The demo, headless"
haptic_server --scene /usr/share/haptics/scenes/demo.scene --assets /usr/share/inventor/data --listen 127.0.0.1:0 \
  --recordings /tmp/recordings --seconds 60 >server.log 2>&1 &
server=$!
address=
for _ in $(seq 600); do
  address=$(sed -n 's/^listening on //p' server.log)
  [ -z "$address" ] && kill -0 "$server" || break
  sleep 0.1
done 2>/dev/null
[ -n "$address" ] || { cat server.log; fail "the server did not start"; }
hapticctl --connect "$address" status
hapticctl --connect "$address" verify
xvfb-run -a -s '-screen 0 1280x1024x24' graphics_client --connect "$address" --offscreen --seconds 5 --screenshot view.png
[ "$(stat -c %s view.png)" -gt 10000 ] || fail "the picture is empty"
kill -TERM "$server"
wait "$server"

say "Libraries"
python3 -c '
import haptics, haptic_client, haptic_experiment, numpy
world = haptics.SceneWorld("/usr/share/haptics/scenes/demo.scene", folders=["/usr/share/inventor/data"])
positions = numpy.zeros((2000, 3))
positions[:, 0] = [body.pose.position_m[0] for body in world.bodies() if body.name == "box"][0]
positions[:, 2] = 0.2 - 0.0001 * numpy.arange(2000)
print("largest force", abs(world.run(positions)["force_N"]).max(), "N")
assert world.run(positions)["body"].max() > 0'
for example in own_loop scene_loop follow_force; do
  cmake -S "/packages/$example" -B "$example" >/dev/null
  cmake --build "$example" >/dev/null
done

say "Purge"
apt-get purge -y -qq haptics-server haptics-viewer haptics-tools libhaptics-dev python3-haptics >/dev/null
left=$(traces)
[ -z "$left" ] || fail "purging leaves $left"
