"""usage: telemetry_cost.py BIN_FOLDER [SECONDS]: what telemetry at 1 kHz to one client costs the server's network thread.

Processor time of each of the server's threads, without and with such a client, in turns; the servo's apart, which runs
in either case. The client is hapticctl. Writes JSON to standard output.
"""
import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

BIN = Path(sys.argv[1])
SECONDS = float(sys.argv[2]) if len(sys.argv) > 2 else 5
TURNS = 5
SCENE = 'operations { add { name: "ball" mesh { sphere { radius_m: 0.03 } } } }'


def busy_ns(server):
    """By thread."""
    return {task.name: int((task / "schedstat").read_text().split()[0]) for task in Path(f"/proc/{server.pid}/task").iterdir()}


def shares(server):
    """Percent of a core, by thread."""
    before, began = busy_ns(server), time.monotonic()
    time.sleep(SECONDS)
    after, took_s = busy_ns(server), time.monotonic() - began
    return {thread: (after[thread] - before[thread]) / took_s * 1e-7 for thread in after if thread in before}


def samples_after(file, position):
    """hapticctl writes a line for each; the last ones come while it ends."""
    file.seek(position)
    return file.read().count(b"\n")


def main():
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "cost.scene"
        scene.write_text(SCENE)
        received = (Path(folder) / "received").open("w+b")
        server = subprocess.Popen([BIN / "haptic_server", "--scene", scene, "--listen", "127.0.0.1:0"], text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        try:
            address = server.stdout.readline().split()[-1]
            time.sleep(2)
            idle, busy, rates = [], [], []
            for _ in range(TURNS):
                idle.append(shares(server))
                client = subprocess.Popen([BIN / "hapticctl", "--connect", address, "--json", "watch", "--rate", "1000"],
                                          stdout=received)
                time.sleep(0.5)
                before = received.seek(0, 2)
                busy.append(shares(server))
                client.terminate()
                client.wait()
                rates.append(samples_after(received, before) / SECONDS)
        finally:
            server.terminate()
            server.wait()
    threads = {thread: {"idle_percent": statistics.median(turn.get(thread, 0) for turn in idle),
                        "telemetry_percent": statistics.median(turn.get(thread, 0) for turn in busy)}
               for thread in idle[0]}
    network = max(threads.values(), key=lambda share: share["telemetry_percent"] - share["idle_percent"])
    print(json.dumps({"asked_hz": 1000, "received_hz": statistics.median(rates), "seconds_a_turn": SECONDS, "turns": TURNS,
                      "network_thread_percent_of_a_core": network["telemetry_percent"],
                      "more_than_without_the_client": network["telemetry_percent"] - network["idle_percent"],
                      "threads": threads}, indent=2))


if __name__ == "__main__":
    main()
