"""What a page tells a reader to type: found on it, and typed in a folder that looks like a clone that was built."""
import os
import queue
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

from harness import BIN, PROJECT


def blocks(page):
    """The blocks of a page that are fenced without a language, in order."""
    found, block, language = [], None, None
    for line in page.splitlines(keepends=True):
        if line.startswith("```"):
            if block is None:
                block, language = [], line[3:].strip()
                continue
            if not language:
                found.append("".join(block))
            block = None
        elif block is not None:
            block.append(line)
    return found


def section(page, heading):
    """What stands below a heading of the second level."""
    return page.split(f"\n## {heading}\n", 1)[1].split("\n## ", 1)[0]


def commands_in(block):
    """[(command, output shown)] of a block whose commands begin with "$ ". A command goes on over a backslash at the end of
    a line, and to the end of a here document."""
    found = []
    lines = iter(block.splitlines())
    for line in lines:
        if not line.startswith("$ "):
            if not found:
                raise AssertionError(f"output before any command: {line}")
            found[-1][1].append(line)
            continue
        command = [line[2:]]
        while command[-1].endswith("\\"):
            command.append(next(lines))
        here = re.search(r"<<'(\w+)'", command[-1])
        while here and command[-1] != here[1]:
            command.append(next(lines))
        found.append(("\n".join(command), []))
    return found


def is_as_shown(output, shown):
    """Does the output look as a page shows it? "..." stands for any text, on a line of its own for any lines."""
    pattern = "".join(r"([^\n]*\n)*" if line == "..." else r"[^\n]*".join(map(re.escape, line.split("..."))) + r"\n"
                      for line in shown)
    printed = "".join(line.rstrip() + "\n" for line in output.strip("\n").splitlines())
    return re.fullmatch(pattern, printed) is not None


def lay_out_clone(clone):
    """Makes a folder that looks like a clone of this repository that was built."""
    (clone / "build").mkdir(parents=True)
    (clone / "build" / "release").symlink_to(BIN.parent)
    for name in ("CMakePresets.json", "deploy", "graphics_client", "haptic_server", "tests"):
        (clone / name).symlink_to(PROJECT / name)


def enter_own_network():
    """Runs this program again in a network of its own, where no other program has the usual port. Goes on in the machine's
    where that is not permitted."""
    if "HAPTICS_OWN_NETWORK" in os.environ:
        return
    unshare = ["unshare", "--net", *([] if os.geteuid() == 0 else ["--map-root-user"])]
    up = ["ip", "link", "set", "lo", "up"]
    if subprocess.run([*unshare, *up], capture_output=True).returncode != 0:
        return
    os.environ["HAPTICS_OWN_NETWORK"] = "1"
    os.execvp("unshare", [*unshare, "sh", "-c", " ".join(up) + ' && exec "$@"', "sh", *sys.orig_argv])


class Shell:
    """A shell in which commands run one after another, as in a terminal: what one exports the next ones have."""

    def __init__(self, cwd, env=None):
        self.process = subprocess.Popen(["bash", "--noprofile", "--norc"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT, text=True, cwd=cwd, env={**os.environ, **(env or {})},
                                        process_group=0)
        # The ten seconds that it waits by default are few on a loaded machine.
        self.process.stdin.write('hapticctl() { command hapticctl --timeout 120 "$@"; }\n')
        self.lines = queue.Queue()
        threading.Thread(target=self.collect, daemon=True).start()

    def collect(self):
        with self.process.stdout as stream:
            for line in stream:
                self.lines.put(line)
        self.lines.put(None)

    def run(self, command, timeout_s):
        """(exit status, output) of a command, whose standard input is empty."""
        if self.process.poll() is not None:
            raise AssertionError(f"the shell has ended before {command}")
        end = f"--- end of command {time.monotonic_ns()} ---"
        self.process.stdin.write(f"{{ {command}\n}} </dev/null\nprintf '\\n%s %d\\n' '{end}' $?\n")
        self.process.stdin.flush()
        output, deadline = [], time.monotonic() + timeout_s
        while True:
            try:
                line = self.lines.get(timeout=max(0.0, deadline - time.monotonic()))
            except queue.Empty:
                threads = self.threads()
                self.close()  # what follows would wait for it too
                raise AssertionError(f"{command}\ndoes not end within {timeout_s} s:\n{''.join(output)}\n{threads}") from None
            if line is None:
                raise AssertionError(f"{command}\nended the shell:\n{''.join(output)}")
            if line.startswith(end):
                return int(line.split()[-1]), "".join(output)
            output.append(line)

    def hurry(self, program):
        """Processes of this name that it has started are real-time from now on, where that is permitted."""
        for comm in Path("/proc").glob("[0-9]*/comm"):
            try:
                process = int(comm.parent.name)
                if comm.read_text().strip() == program and os.getpgid(process) == self.process.pid:
                    os.sched_setscheduler(process, os.SCHED_FIFO, os.sched_param(1))
            except OSError:  # not permitted, or it has ended
                pass

    def threads(self):
        """Every thread of what runs in it: its state, processor time and what it waits for."""
        ps = subprocess.run(["ps", "-eLo", "pgid,pid,tid,stat,cls,time,wchan:24,comm"], capture_output=True, text=True)
        return "".join(line for line in ps.stdout.splitlines(keepends=True) if line.split()[0] in ("PGID", str(self.process.pid)))

    def close(self):
        try:
            os.killpg(self.process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        self.process.wait()
        self.process.stdin.close()
