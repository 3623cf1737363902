# SPDX-License-Identifier: Apache-2.0
"""PostgreSQL, a store, servers, workers and HAProxy on this machine, each on a free port, in one folder."""
import contextlib
import json
import os
import pwd
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "soak"))
from connection import Connection  # noqa: E402

HAPROXY = "/usr/sbin/haproxy"
CONFIGURATION = Path(__file__).resolve().parents[2] / "deploy/haproxy.cfg"
START_S = 60
TRY_LATER = 6  # exit status of waystone
SERVERS = 3


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def until(holds, patience_s=START_S, pause_s=0.02):
    """Whether it came to hold, and after how many seconds."""
    started = time.monotonic()
    while time.monotonic() - started < patience_s:
        with contextlib.suppress(OSError, ValueError, KeyError):
            if holds():
                return True, time.monotonic() - started
        time.sleep(pause_s)
    return False, time.monotonic() - started


def missing_programs():
    """What this machine hasn't got of Debian's packages."""
    missing = [] if Path(HAPROXY).exists() else ["haproxy"]
    return missing + ([] if Postgres.programs() else ["postgresql"])


class Process:
    """A program that can be killed and started again; its output goes to a file."""

    def __init__(self, command, log, **how):
        self.command, self.log, self.how = [str(word) for word in command], log, how
        self.process = None

    def start(self):
        with open(self.log, "ab") as log:
            self.process = subprocess.Popen(self.command, stdout=log, stderr=log, **self.how)

    def kill(self, number=signal.SIGKILL):
        """When it was killed and when it had ended, by time.monotonic()."""
        killed_at = time.monotonic()
        self.process.send_signal(number)
        self.process.wait()
        return killed_at, time.monotonic()

    def stop(self):
        if self.process and self.process.poll() is None:
            self.process.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(10)
                return
            self.process.kill()

    def output(self):
        return Path(self.log).read_text(encoding="utf-8", errors="replace")


class Postgres(Process):
    """Reached by a Unix socket alone. As root it runs as the package's user, because it refuses root."""

    @staticmethod
    def programs():
        found = sorted(Path("/usr/lib/postgresql").glob("*/bin/initdb"))
        return found[-1].parent if found else None

    def __init__(self, folder):
        how = {}
        folder.mkdir()
        if os.getuid() == 0:
            user = pwd.getpwnam("postgres")
            os.chown(folder, user.pw_uid, user.pw_gid)
            how = {"user": user.pw_uid, "group": user.pw_gid, "extra_groups": []}
        super().__init__([self.programs() / "postgres", "-D", folder / "data", "-k", folder,
                          "-c", "listen_addresses=", "-c", "fsync=off"], folder.with_suffix(".log"), cwd="/", **how)
        self.folder = folder
        subprocess.run([self.programs() / "initdb", "-D", folder / "data", "-A", "trust", "-U", "waystone",
                        "-E", "UTF8", "--no-locale", "--no-sync"], check=True, stdout=subprocess.DEVNULL, cwd="/", **how)
        self.url = f"postgresql:///postgres?user=waystone&host={folder}"

    def start(self):
        super().start()
        ready = [self.programs() / "pg_isready", "-q", "-h", self.folder, "-U", "waystone", "-d", "postgres"]
        if not until(lambda: subprocess.run(ready, check=False).returncode == 0)[0]:
            raise RuntimeError(f"PostgreSQL didn't start: {self.output()[-1000:]}")

    def stop(self):
        if self.process and self.process.poll() is None:
            self.kill(signal.SIGQUIT)


class Store(Process):
    def __init__(self, folder):
        folder.mkdir()
        self.port, self.folder = free_port(), folder
        self.url = f"http://127.0.0.1:{self.port}"
        program = Path(__file__).with_name("file_store.py")
        super().__init__([sys.executable, program, self.port, folder], folder.with_suffix(".log"))

    def start(self):
        super().start()
        if not until(lambda: socket.create_connection(("127.0.0.1", self.port)).close() is None)[0]:
            raise RuntimeError("the store didn't start")

    def make_slow(self, slow):
        if slow:
            (self.folder / "slow").touch()
        else:
            (self.folder / "slow").unlink(missing_ok=True)


class Server(Process):
    """A server of waystone: of a registry's maps, or of a folder."""

    def __init__(self, program, maps, log):
        self.port = free_port()
        super().__init__([program, "serve", *maps, "--port", self.port], log)

    def start(self):
        super().start()
        if not until(lambda: self.get("/readyz")[0] == 200)[0]:
            raise RuntimeError(f"a server didn't start: {self.output()[-1000:]}")

    def get(self, path):
        return self.ask("GET", path)

    def ask(self, *request):
        with Connection(self.port) as connection:
            return connection.ask(*request)

    def registry(self):
        return json.loads(self.get("/readyz")[1])["registry"]

    def answered(self):
        """Queries with an answer, of all maps."""
        lines = re.findall(r"^waystone_localized_total\{.*\} (\S+)$", self.get("/metrics")[1].decode(), re.MULTILINE)
        return sum(map(float, lines))

    def metric(self, name):
        found = re.search(rf"^{re.escape(name)} (\S+)$", self.get("/metrics")[1].decode(), re.MULTILINE)
        return float(found[1]) if found else 0.0


class ProxyLog:
    """What HAProxy says of each request: {path: [(server, status, termination state)]}."""

    LINE = re.compile(r" servers/(\S+) \S+ (-?\d+) \d+ \S+ \S+ (\S\S)\S\S .* \"\S+ (\S+) HTTP")

    def __init__(self):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.port = self.socket.getsockname()[1]
        self.lines = []
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        with contextlib.suppress(OSError):
            while True:
                found = self.LINE.search(self.socket.recv(65536).decode(errors="replace"))
                if found:
                    self.lines.append((time.monotonic(), found[1], int(found[2]), found[3], found[4]))

    def close(self):
        self.socket.close()


class Cluster:
    """Three servers behind HAProxy with the configuration that is shipped."""

    def __init__(self, program, folder, memory, cache_size="20G"):
        self.program = program
        self.postgres = Postgres(folder / "postgres")
        self.store = Store(folder / "store")
        self.log = ProxyLog()
        self.port = free_port()
        self.servers = []
        for i in range(SERVERS):
            maps = ["--registry", self.postgres.url, "--cache", folder / f"cache{i}", "--memory", memory,
                    "--cache-size", cache_size, "--public-name", f"localhost:{self.port}"]
            self.servers.append(Server(program, maps, folder / f"server{i}.log"))
        variables = {f"WAYSTONE_SERVER_{i + 1}": f"127.0.0.1:{server.port}" for i, server in enumerate(self.servers)}
        self.proxy = Process([HAPROXY, "-db", "-f", CONFIGURATION], folder / "haproxy.log",
                             env={**os.environ, **variables, "WAYSTONE_BIND": f"127.0.0.1:{self.port}",
                                  "WAYSTONE_LOG": f"127.0.0.1:{self.log.port}"})
        self.postgres.start()
        self.store.start()

    def run(self, *arguments):
        """What the program prints; tried again while it says that the registry or the store can't be reached."""
        command, started = [self.program, *map(str, arguments)], time.monotonic()
        while True:
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            if done.returncode == 0:
                return done.stdout
            if done.returncode != TRY_LATER or time.monotonic() - started > START_S:
                raise RuntimeError(f"waystone {arguments[0]} exited with {done.returncode}: {done.stderr}")

    def publish(self, file, name):
        self.run("publish", file, "--to", self.postgres.url, "--store", self.store.url, "--name", name)

    def start(self):
        for server in self.servers:
            server.start()
        self.proxy.start()
        self.wait_for_servers()

    def wait_for_servers(self):
        """Until the proxy takes all of them for ready, which it asks each second."""
        for server in self.servers:
            if not until(lambda: server.get("/readyz")[0] == 200)[0]:
                raise RuntimeError("a server isn't ready")
        if not until(lambda: all(self.ask("GET", "/readyz")[0] == 200 for _ in self.servers))[0]:
            raise RuntimeError("the proxy passes nothing on")
        time.sleep(1.5)

    def ask(self, *request):
        with Connection(self.port) as connection:
            return connection.ask(*request)

    def sum_of(self, metric):
        return sum(server.metric(metric) for server in self.servers)

    def stop(self):
        for process in (self.proxy, *self.servers, self.store, self.postgres):
            process.stop()
        self.log.close()
