#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""cluster_test.py --program PROGRAM [--short]: what a cluster promises.

It starts PostgreSQL, HAProxy, three servers and two workers on this machine, from Debian's packages.

The maps are parts of a rendered walk, the store is a small HTTP server, and everything listens on free
ports of 127.0.0.1. In turn:

  answers    through the cluster they are those of one process, byte for byte but for timings
  kills      under load a server, PostgreSQL, the store, all servers and HAProxy are killed and started
             again: no wrong answer, no failed request but those in flight at what was killed, and each of
             them is answered when it is tried again
  a worker   that is killed in a job: another one ends it, no step is done twice, and the map is the same
  versions   a map is published anew under load: no failed request, no answer of neither version
  timings    what HAProxy adds, and a map's first answer beside its download, opening and query

A broken promise is named and makes the exit status 1. Figures beside targets of time are printed and
written to --json with the service times that bench/cluster/simulate.py takes. A busy machine misses
targets, but breaks no promise. --folder keeps the maps for the next time.
"""
import argparse
import hashlib
import json
import os
import random
import shutil
import statistics
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

from cluster import SERVERS, Cluster, Server, missing_programs, until
from connection import Connection
from kills import Kills
from load import Load, ask_all, localize
from made_maps import Maps
from measured import measure_load, measure_service
from workers import check_workers

CLIENTS = 4
SKIPPED = 77  # exit status
COLD = 3  # maps that nobody asks for before the store is killed
# kill_s: before and after something is killed; rounds of timings; versions that are published.
FULL = {"maps": 300 + COLD, "queries": 1040, "rounds": 300, "clients": (1, 2, 4, 8), "load_s": 15, "kill_s": 6,
        "versions": 6, "cold_maps": 60}
SHORT = {"maps": 9 + COLD, "queries": 40, "rounds": 20, "clients": (2,), "load_s": 1, "kill_s": 0.5, "versions": 2,
         "cold_maps": 3}


class Findings:
    """Promises, which break the test, and figures beside their targets."""

    def __init__(self):
        self.broken, self.figures, self.counts, self.kills = [], [], {}, []

    def promise(self, holds, what):
        if not holds:
            self.broken.append(what)
            print("BROKEN:", what, flush=True)

    def figure(self, name, text, value, target, unit):
        met = value <= target
        self.figures.append({"name": name, "measured": round(value, 4), "target": round(target, 4), "unit": unit,
                             "met": met})
        print(f"{text}: {value:.3g} {unit} (target {target:.3g}{'' if met else ', missed'})", flush=True)

    def count(self, name, text, value):
        self.counts[name] = value
        print(f"{text}: {value}", flush=True)

    def kill(self, what, answers, failed, answered_again):
        self.kills.append({"name": what, "answers": answers, "failed": failed, "answered_again": answered_again})
        print(f"{what} killed: {answers} answers; {failed} requests failed, {answered_again} of them were answered on "
              "retry", flush=True)


def choose_pairs(names, photos, count, seed=0):
    """Every map is asked, and what is asked is the same each time."""
    chance = random.Random(seed)
    pairs = [(name, chance.choice(photos)) for name in names]
    while len(set(pairs)) < count:
        pairs.append((chance.choice(names), chance.choice(photos)))
    return list(dict.fromkeys(pairs))


def check_answers(cluster, maps, cold, pairs, photos, findings, folder):
    """{pair: answers} but for timings, as one process with a folder of the maps gives them."""
    files = folder / "files"
    files.mkdir()
    for name, path in maps.items():
        shutil.copy(path, files / f"{name}.db")
    plain = Server(cluster.program, [files], folder / "plain.log")
    plain.start()
    try:
        expected = ask_all(plain.port, pairs, photos)
    finally:
        plain.stop()
    through = ask_all(cluster.port, [pair for pair in pairs if pair[0] not in cold], photos)
    differing = [pair for pair in through if through[pair] != expected[pair]]
    findings.promise(not differing, f"{len(differing)} answers differ from those of one process: {differing[:3]}")
    findings.count("maps", "maps", len({pair[0] for pair in through}))
    findings.count("queries", "queries whose answers were compared", len(through))
    findings.count("differing", "answers that differ from those of one process", len(differing))
    located = sum(b'"verdict":"localized"' in body for body in expected.values())
    findings.count("localized", "places found", located)
    findings.promise(0 < located < len(expected), "places are found and refused")
    opens = [server.metric("waystone_map_opens_total") for server in cluster.servers]
    findings.count("opened", "maps opened by each server", [int(each) for each in opens])
    findings.promise(max(opens) < sum(opens), "no server has all maps")
    return {pair: {body} for pair, body in expected.items()}


def check_versions(cluster, maps, photos, expected, findings, rounds):
    """Publishes another map's file and the own one under a name, again and again, while all ask for it."""
    name, *_, other = sorted(maps)
    files, slowest = [maps[other], maps[name]], 0
    pairs = [pair for pair in expected if pair[0] == name]
    of_other = answers_of(cluster, files[0], name, pairs, photos)
    answers = {pair: expected[pair] | {of_other[pair]} for pair in pairs}
    with Load(cluster.port, pairs, photos, answers).start(CLIENTS) as load:
        for server in cluster.servers:
            server.get(f"/v1/maps/{name}")
        for i in range(rounds):
            cluster.publish(files[i % 2], name)
            started = time.monotonic()
            version = "sha256:" + hashlib.sha256(files[i % 2].read_bytes()).hexdigest()
            everywhere = until(lambda: all(
                json.loads(server.get(f"/v1/maps/{name}")[1])["version"] == version for server in cluster.servers))
            findings.promise(everywhere[0], "a new version isn't served everywhere")
            slowest = max(slowest, time.monotonic() - started)
    findings.promise(not load.wrong, f"answers of neither version: {load.wrong[:2]}")
    findings.promise(not load.failures, f"requests failed while a version was exchanged: {load.failures[:2]}")
    findings.promise(load.good > rounds, "hardly anybody asked while versions were exchanged")
    findings.count("answers_of_versions", "answers while versions were exchanged", load.good)
    findings.figure("version", "a new version is served everywhere after", slowest, 2, "s")


def answers_of(cluster, file, name, pairs, photos):
    """What that file answers under this name, by one process."""
    with tempfile.TemporaryDirectory(prefix="waystone-cluster-") as folder:
        shutil.copy(file, Path(folder) / f"{name}.db")
        plain = Server(cluster.program, [folder], Path(folder) / "log")
        plain.start()
        try:
            return ask_all(plain.port, pairs, photos)
        finally:
            plain.stop()


def server_of(cluster, name, photo):
    """The server that HAProxy sends a map's queries to."""
    before = [server.answered() for server in cluster.servers]
    with Connection(cluster.port) as connection:
        localize(connection, name, photo)
    return next(server for server, count in zip(cluster.servers, before) if server.answered() > count)


def check_timings(cluster, pairs, photos, findings, rounds):
    """What HAProxy adds to a small request and to a query, each asked of one server with and without it in turn."""
    name, photo = pairs[0]
    direct = server_of(cluster, name, photos[photo])
    for what, ask in (("request", lambda connection: connection.ask("GET", f"/v1/maps/{name}")),
                      ("query", lambda connection: localize(connection, name, photos[photo]))):
        took = {cluster.port: [], direct.port: []}
        with ExitStack() as stack:
            connections = {port: stack.enter_context(Connection(port)) for port in took}
            for connection in connections.values():
                ask(connection)
            for i in range(rounds):
                # Which of them comes second finds warmer caches.
                for port, connection in list(connections.items())[::1 if i % 2 else -1]:
                    started = time.monotonic()
                    status = ask(connection)[0]
                    took[port].append(1000 * (time.monotonic() - started))
                    findings.promise(status == 200, f"a {what} got status {status}")
        added = statistics.median(proxied - straight for proxied, straight in zip(*took.values()))
        findings.figure(f"proxy_{what}", f"HAProxy adds to a {what} (median)", added, 1, "ms")


def publish_all(cluster, maps, findings):
    """One after the other, as publishers of one registry come in any case."""
    started = time.monotonic()
    for name, path in maps.items():
        cluster.publish(path, name)
    findings.count("publish_s", "publishing a map takes (s)", round((time.monotonic() - started) / len(maps), 2))


def check(cluster, made, arguments, findings, folder):
    sizes = SHORT if arguments.short else FULL
    maps = made.files
    photos = {path.name: path.read_bytes() for path in made.photos}
    pairs = choose_pairs(sorted(maps), sorted(photos), sizes["queries"])
    cold = sorted(maps)[-COLD:]
    publish_all(cluster, maps, findings)
    cluster.start()
    expected = check_answers(cluster, maps, cold, pairs, photos, findings, folder)
    warm = [pair for pair in pairs if pair[0] not in cold]
    check_timings(cluster, warm, photos, findings, sizes["rounds"])
    loads = [measure_load(cluster, warm, photos, expected, findings, clients, sizes["load_s"])
             for clients in sizes["clients"]]
    kills = Kills(cluster, maps, cold, photos, expected, findings, sizes["kill_s"])
    kills.all(1 if arguments.short else SERVERS)
    check_versions(cluster, {name: maps[name] for name in maps if name not in cold}, photos, expected, findings,
                   sizes["versions"])
    check_workers(cluster, made.walk / "images", photos[warm[0][1]], findings, folder)
    service = measure_service(cluster, maps, warm, photos, findings, folder, sizes["cold_maps"])
    return {"loads": loads, "service": service}


def memory_of(maps):
    """Of a server: half of what its share of the maps takes when it is open, so that maps come and go."""
    sizes = [path.stat().st_size for path in maps.values()]
    return max(sum(sizes) // SERVERS, 8 * max(sizes))


def run(arguments, folder):
    findings, sizes = Findings(), SHORT if arguments.short else FULL
    made = Maps(arguments.program, arguments.folder or folder / "made", sizes["maps"])
    memory = memory_of(made.files)
    cluster = Cluster(arguments.program, folder, f"{memory // 1_000_000 + 1}M")
    try:
        measured = check(cluster, made, arguments, findings, folder)
    finally:
        cluster.stop()
    measured |= {"memory_bytes": (memory // 1_000_000 + 1) * 1_000_000, "servers": SERVERS, "cores": os.cpu_count(),
                 "map_bytes": sorted(path.stat().st_size for path in made.files.values())}
    return {"bench": "cluster", "short": arguments.short, "counts": findings.counts, "figures": findings.figures,
            "kills": findings.kills, "broken": findings.broken, **measured}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bench", nargs="?", default="cluster", choices=["cluster"])
    parser.add_argument("--program", required=True)
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    missing = missing_programs()
    if missing:
        print(f"skipped: needs {' and '.join(missing)} (apt-get install {' '.join(missing)})")
        return SKIPPED
    with tempfile.TemporaryDirectory(prefix="waystone-cluster-") as temporary:
        Path(temporary).chmod(0o755)  # PostgreSQL's user has a folder in it
        result = run(arguments, Path(temporary))
    if arguments.json:
        arguments.json.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    print(json.dumps(result))
    return 1 if result["broken"] else 0


if __name__ == "__main__":
    sys.exit(main())
