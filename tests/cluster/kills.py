# SPDX-License-Identifier: Apache-2.0
"""What is killed under load, one after the other, and what may fail then."""
import hashlib
import json
import signal
import subprocess
import threading
import time

from cluster import TRY_LATER, until
from connection import Connection
from load import Load, localize, without_times

CLIENTS = 4
LOG_S = 3  # that HAProxy's log may be late
SKEW_S = 0.05  # between this program's clock readings and what they are of


def store_path(file):
    digits = hashlib.sha256(file.read_bytes()).hexdigest()
    return f"/{digits[:2]}/{digits}.db"


class Kills:
    def __init__(self, cluster, maps, cold, photos, expected, findings, seconds):
        self.cluster, self.maps, self.cold, self.photos = cluster, maps, cold, photos
        self.expected, self.findings, self.seconds = expected, findings, seconds
        self.pairs = [pair for pair in expected if pair[0] not in cold]

    def all(self, servers):
        """One after the other; of the servers the first ones."""
        for i in range(servers):
            self.server(i)
        self.postgres()
        self.store()
        self.every_server()
        self.proxy()

    def under_load(self, what, strike):
        """`strike` returns a function that says what speaks against a failure: nothing for one that may be."""
        print(f"-- {what} is killed", flush=True)
        # When a server dies, HAProxy closes connections without an answer and a line in its log where that
        # wasn't their first request. One request a connection tells what became of each.
        with Load(self.cluster.port, self.pairs, self.photos, self.expected, keeps=False).start(CLIENTS) as load:
            time.sleep(self.seconds)
            against = strike()
            time.sleep(self.seconds)
        promise = self.findings.promise
        promise(not load.wrong, f"{what} killed: {len(load.wrong)} wrong answers: {load.wrong[:2]}")
        stray = [(failure, reason) for failure in load.failures if (reason := against(failure))]
        promise(not stray, f"{what} killed: {len(stray)} requests failed that had nothing to do with it: {stray[:2]}")
        unanswered = [failure for failure in load.failures if not failure.answered]
        promise(not unanswered, f"{what} killed: {len(unanswered)} requests weren't answered on retry")
        promise(load.good > 0, f"{what} killed: nobody was answered")
        self.findings.kill(what, load.good, len(load.failures), len(load.failures) - len(unanswered))

    # ---- one of three servers

    def server(self, i):
        server, name = self.cluster.servers[i], ("one", "two", "three")[i]

        def strike():
            killed_at, ended_at = server.kill()
            time.sleep(self.seconds)
            server.start()
            self.cluster.wait_for_servers()
            return lambda failure: self.against_being_in_flight(failure, name, killed_at, ended_at)
        self.under_load(f"server {name}", strike)

    def against_being_in_flight(self, failure, server, killed_at, ended_at):
        """It must have begun when the server ended, and HAProxy must say that this server had it."""
        if failure.began > ended_at + SKEW_S or failure.ended < killed_at - SKEW_S:
            return f"killed at {killed_at:.3f}, ended at {ended_at:.3f}"
        path = f"/v1/maps/{failure.name}/localize"

        def told():
            return [line for line in list(self.cluster.log.lines) if line[4] == path and abs(line[0] - failure.ended) < LOG_S]
        # S: the server aborted, D: it was down.
        found = until(lambda: any(line[1] == server and line[3][0] in "SD" for line in told()), LOG_S)
        return "" if found[0] else f"HAProxy says {told()}"

    # ---- the database

    def postgres(self):
        def strike():
            self.cluster.postgres.kill(signal.SIGQUIT)
            servers = self.cluster.servers
            noticed = until(lambda: not any(server.registry()["connected"] for server in servers))
            self.findings.promise(noticed[0], "servers don't notice that the registry is away")
            time.sleep(self.seconds)
            name = self.cold[0]
            refused = subprocess.run([self.cluster.program, "retire", name, "--in", self.cluster.postgres.url],
                                     capture_output=True, check=False)
            self.findings.promise(refused.returncode == TRY_LATER, f"without the registry: exit {refused.returncode}")
            self.cluster.postgres.start()
            back = until(lambda: all(server.registry()["connected"] for server in servers))
            self.findings.promise(back[0], "servers don't find the registry again")
            self.cluster.run("retire", name, "--in", self.cluster.postgres.url)
            heard = until(lambda: all(server.get(f"/v1/maps/{name}")[0] == 404 for server in servers))
            self.findings.promise(heard[0], "servers don't hear of changes after the registry came back")
            self.cluster.run("rollback", name, "--in", self.cluster.postgres.url)
            return lambda failure: "nothing may fail"
        self.under_load("PostgreSQL", strike)

    # ---- the store

    def store(self):
        """In the middle of a file; what the caches have is served."""
        store, (halved, unseen, *_) = self.cluster.store, self.cold[1:]

        def strike():
            store.make_slow(True)
            answers = []
            path = store_path(self.maps[halved])
            asking = threading.Thread(target=lambda: answers.append(self.ask(halved)), daemon=True)
            asking.start()
            begun = until(lambda: f"GET {path}" in store.output())
            self.findings.promise(begun[0], "nobody fetches a map that was asked for")
            time.sleep(0.3)
            store.kill()
            asking.join()
            self.expect_unavailable(*answers[0])
            self.expect_unavailable(*self.ask(unseen))
            time.sleep(self.seconds)
            store.make_slow(False)
            store.start()
            for name in (halved, unseen):
                served = until(lambda: self.ask(name)[0] == 200)[0]
                self.findings.promise(served and self.is_right(name), f"{name} isn't served after the store is back")
            starts = [int(line.split()[2]) for line in store.output().splitlines() if path in line]
            self.findings.promise(starts[-1] > 0, f"a fetch that was cut didn't go on where it stopped: {starts}")
            return lambda failure: "nothing may fail"
        self.under_load("the store", strike)

    def ask(self, name):
        pair = next(pair for pair in self.expected if pair[0] == name)
        with Connection(self.cluster.port, 60) as connection:
            return localize(connection, name, self.photos[pair[1]])

    def is_right(self, name):
        pair = next(pair for pair in self.expected if pair[0] == name)
        return without_times(self.ask(name)[1]) in self.expected[pair]

    def expect_unavailable(self, status, body):
        holds = status == 503 and json.loads(body).get("code") == "store_unavailable"
        self.findings.promise(holds, f"without the store a map that isn't cached got status {status}: {body[:200]!r}")

    # ---- everything at once

    def every_server(self):
        servers = self.cluster.servers

        def strike():
            killed_at = min(server.kill()[0] for server in servers)
            time.sleep(self.seconds)
            for server in servers:
                server.start()
            self.cluster.wait_for_servers()
            back_at = time.monotonic()
            return lambda failure: "" if failure.ended >= killed_at and failure.began <= back_at else "before or after"
        self.under_load("every server", strike)

    def proxy(self):
        def strike():
            killed_at, _ = self.cluster.proxy.kill()
            time.sleep(self.seconds / 2)
            self.cluster.proxy.start()
            self.cluster.wait_for_servers()
            back_at = time.monotonic()
            return lambda failure: "" if failure.ended >= killed_at and failure.began <= back_at else "before or after"
        self.under_load("HAProxy", strike)
