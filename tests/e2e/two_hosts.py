"""Server and viewer on two hosts: two network namespaces, joined by a cable, made and removed here. Needs root.

The commands are those of a section of deploy/README.md, word for word: the namespaces have its addresses, each host has a
folder that looks like a clone. Only scp is played: there is one file system.
"""
import os
import re
import shlex
import subprocess
import time
import unittest

import harness
import pages

PAGE = harness.PROJECT / "deploy/README.md"
SECTION = "Run it on two machines"
SERVER_SIDE, CLIENT_SIDE = "beside the device", "elsewhere"
FELT = "operations { set_material { object { name: \"torus\" } material { stiffness_N_per_m: 1500 } } }"


def ip(*arguments):
    done = subprocess.run(["ip", *arguments], capture_output=True, text=True)
    if done.returncode != 0:
        raise AssertionError(f"ip {' '.join(arguments)}: {done.stderr.strip()}")


def commands_of_the_page():
    """[(host, command)], from lines such as "elsewhere$  command \\" with what continues them."""
    block = pages.blocks(pages.section(PAGE.read_text(), SECTION))[0].replace("\\\n", " ")
    return [(host, command.strip()) for host, command in re.findall(r"^([^$\n]+)\$(.*)$", block, re.MULTILINE)]


class TwoHosts(harness.EndToEnd):
    def setUp(self):
        super().setUp()
        if os.geteuid() != 0:
            self.fail("network namespaces need root: run the tests as root, or leave this one out with ctest -LE root")
        self.commands = commands_of_the_page()
        self.server_host = re.search(r"--listen (\S+):", " ".join(command for _, command in self.commands))[1]
        network, last = self.server_host.rsplit(".", 1)
        client_host = f"{network}.{int(last) + 1}"
        self.space = {}
        cable = [f"hs{os.getpid() % 10**8}", f"hc{os.getpid() % 10**8}"]
        for side in (SERVER_SIDE, CLIENT_SIDE):
            self.space[side] = f"haptics-{side.replace(' ', '-')}-{os.getpid()}"
            ip("netns", "add", self.space[side])
            self.addCleanup(ip, "netns", "del", self.space[side])
        ip("link", "add", cable[0], "netns", self.space[SERVER_SIDE], "type", "veth", "peer", "name", cable[1], "netns",
           self.space[CLIENT_SIDE])
        for side, end, host in zip(self.space, cable, (self.server_host, client_host)):
            ip("-n", self.space[side], "address", "add", f"{host}/24", "dev", end)
            ip("-n", self.space[side], "link", "set", end, "up")
            ip("-n", self.space[side], "link", "set", "lo", "up")
            pages.lay_out_clone(self.folder / side)

    def on(self, side):
        return ["ip", "netns", "exec", self.space[side]]

    def play_scp(self, command):
        """Copies to the host's folder, mode and all."""
        _, source, target = shlex.split(command)
        host, folder = target.split(":", 1)
        self.assertEqual(host, CLIENT_SIDE)
        self.assertEqual(folder, "haptics/", "the folder of the clone")
        subprocess.run(["cp", "--preserve=mode", self.folder / SERVER_SIDE / source, self.folder / CLIENT_SIDE], check=True)

    def start(self, side, command, env=None):
        process = harness.Process(shlex.split(command), prefix=self.on(side), env=env, cwd=self.folder / side)
        self.addCleanup(process.kill)
        return process

    def test_the_pages_commands_work_as_they_stand(self):
        viewer_env = {"DISPLAY": self.start_display().name, "LP_NUM_THREADS": "1", **harness.FOREIGN_CODE}
        running = {}
        for side, command in self.commands:
            with self.subTest(command):
                program = command.split()[0]
                if program == "scp":
                    self.play_scp(command)
                elif program.endswith("haptic_server"):
                    server = running["server"] = self.start(side, command)
                    harness.wait_until(lambda: server.find(r"^listening on ") or not server.alive(),
                                       harness.START_TIMEOUT_S, server.text)
                    self.assertTrue(server.alive(), server.text())
                elif program.endswith("graphics_client"):
                    viewer = running["viewer"] = self.start(side, command, viewer_env)
                    harness.wait_until(lambda: viewer.find(r" equal$") or not viewer.alive(), harness.START_TIMEOUT_S,
                                       viewer.text)
                    self.assertTrue(viewer.alive(), viewer.text())
                else:
                    process = self.start(side, command)
                    self.assertEqual(process.wait(), 0, process.text())
        self.assertEqual(set(running), {"server", "viewer"})

        address = running["server"].find(r"^listening on (\S+)")[1]
        editor = self.folder / CLIENT_SIDE / "editor.credentials"
        self.assertEqual(editor.stat().st_mode & 0o777, 0o600)
        from_there = {"prefix": self.on(CLIENT_SIDE), "credentials": editor}
        reply = harness.ctl(address, "apply", "-", text=FELT, **from_there).json()
        self.assertGreater(reply["live_since_tick"], 0)
        seen = rf"^scene revision {reply['revision']} root {reply['root']} equal$"
        harness.wait_until(lambda: running["viewer"].find(seen), 30, running["viewer"].text)
        self.assertEqual(harness.ctl(address, "verify", **from_there).code, 0)

        plain = harness.ctl(address, "status", prefix=self.on(CLIENT_SIDE))
        self.assertEqual(plain.code, 3)
        self.assertIn("--credentials", plain.errors)
        for name in ("viewer", "server"):
            self.assertEqual(running[name].stop(), 0, running[name].text())

    def test_another_host_is_not_served_unless_it_was_allowed(self):
        with self.assertRaises(harness.NotStarted) as refusal:
            self.start_server(listen=f"{self.server_host}:0", prefix=self.on(SERVER_SIDE))
        for way_out in ("--credentials", "--allow-insecure-lan"):
            self.assertIn(way_out, str(refusal.exception))

    def test_without_tls_telemetry_comes_by_udp_over_the_cable(self):
        server = self.start_server(listen=f"{self.server_host}:0", options=["--allow-insecure-lan"],
                                   prefix=self.on(SERVER_SIDE))
        from_there = {"prefix": self.on(CLIENT_SIDE)}
        answer = server.ctl("watch", "--udp", "--seconds", "3", **from_there)
        self.assertEqual(answer.code, 0, answer.errors)
        self.assertIn("telemetry over UDP", answer.errors)
        self.assertGreater(len(answer.output.splitlines()), 10)

        # A firewall that lets no datagram through: telemetry goes on over TCP, and says so.
        watching = harness.Process([harness.BIN / "hapticctl", "--connect", server.address, "watch", "--udp", "--seconds",
                                    "8"], prefix=self.on(CLIENT_SIDE))
        self.addCleanup(watching.kill)
        harness.wait_until(lambda: "telemetry over UDP" in watching.text(), 5, watching.text)
        ip("-n", self.space[SERVER_SIDE], "rule", "add", "ipproto", "17", "blackhole")  # udp, also without /etc/protocols
        harness.wait_until(lambda: "no datagram has come for 1 s" in watching.text(), 5, watching.text)
        lines = len(watching.lines)
        time.sleep(1)
        self.assertGreater(len(watching.lines), lines + 3, "samples go on")
        self.stop_and_check(server)


if __name__ == "__main__":
    unittest.main()
