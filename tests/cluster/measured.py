# SPDX-License-Identifier: Apache-2.0
"""Service times of one server, a cold map's first answer, and what the cluster holds: for the simulation."""
import hashlib
import os
import random
import resource
import shutil
import statistics
import time
from pathlib import Path

from connection import Connection
from kills import store_path
from load import Load, localize

ZIPF = 1.0
SEED = 3
STILL = 4  # times that a server holds as much of the coarse index as before
TICKS = os.sysconf("SC_CLK_TCK")


def timed_ms(call):
    started = time.monotonic()
    result = call()
    return 1000 * (time.monotonic() - started), result


def download_ms(store, file, folder):
    """As a server does it: fetched, written, flushed and verified."""
    target = folder / "download"

    def fetch():
        with Connection(store.port) as connection:
            body = connection.ask("GET", store_path(file))[1]
        with open(target, "wb") as out:
            out.write(body)
            os.fsync(out.fileno())
        return hashlib.sha256(target.read_bytes()).digest()
    return timed_ms(fetch)[0]


def empty_cache(server):
    """Starts the server anew without files, and lets it fetch what it holds of the coarse index."""
    server.stop()
    shutil.rmtree(server.command[server.command.index("--cache") + 1])
    server.start()
    held, still = -1, 0
    while still < STILL:
        time.sleep(0.5)
        before, held = held, server.registry()["coarse"]["maps"]
        still = still + 1 if held == before else 0


def queries_by_popularity(server, pairs, photos, count):
    """Milliseconds that queries of open maps take, drawn as `measure_load` draws them."""
    weights = zipf_weights(sorted({pair[0] for pair in pairs}), pairs)
    took = []
    with Connection(server.port) as connection:
        for name, photo in random.Random(SEED).choices(pairs, weights, k=count):
            connection.ask("GET", f"/v1/maps/{name}")
            took.append(timed_ms(lambda: localize(connection, name, photos[photo]))[0])
    return took


def measure_service(cluster, maps, pairs, photos, findings, folder, count):
    """Of one server by itself, in milliseconds, a number for each of `count` maps or queries."""
    server = cluster.servers[0]
    chosen = {name: photo for name, photo in pairs}
    names = sorted(chosen)[::max(1, len(chosen) // count)][:count]
    empty_cache(server)
    first, downloads, opened, queries = [], [], [], []
    with Connection(server.port) as connection:
        connection.ask("GET", "/version")
        for name in names:
            first.append(timed_ms(lambda: localize(connection, name, photos[chosen[name]]))[0])
            downloads.append(download_ms(cluster.store, maps[name], folder))
            queries.append(timed_ms(lambda: localize(connection, name, photos[chosen[name]]))[0])
    popular = queries_by_popularity(server, pairs, photos, 4 * count)
    server.stop()
    server.start()
    with Connection(server.port) as connection:
        connection.ask("GET", "/version")
        for name in names:
            cold = timed_ms(lambda: connection.ask("GET", f"/v1/maps/{name}"))[0]
            warm = timed_ms(lambda: connection.ask("GET", f"/v1/maps/{name}"))[0]
            opened.append(max(0.0, cold - warm))
    sums = [sum(parts) for parts in zip(downloads, opened, queries)]
    findings.figure("cold", "a cold map's first answer (median), beside download, opening and query",
                    statistics.median(first), statistics.median(sums), "ms")
    sizes = [maps[name].stat().st_size for name in names]
    return {"query_ms": rounded(popular), "open_ms": rounded(opened),
            "download_ms": rounded(downloads), "first_ms": rounded(first), "map_bytes": sizes}


def rounded(values):
    return [round(value, 2) for value in values]


def cpu_s(process):
    fields = Path(f"/proc/{process.process.pid}/stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def own_cpu_s():
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def zipf_weights(names, pairs):
    """Of the pairs: their maps are as popular as their rank in a fixed order says."""
    share = {name: 1 / (rank + 1) ** ZIPF for rank, name in enumerate(names)}
    count = {name: sum(pair[0] == name for pair in pairs) for name in names}
    return [share[pair[0]] / count[pair[0]] for pair in pairs]


def measure_load(cluster, pairs, photos, expected, findings, clients, seconds):
    """What `clients` that ask one query after the other get, with Zipf popularity of the maps."""
    names = sorted({pair[0] for pair in pairs})
    elsewhere = lambda: own_cpu_s() + cpu_s(cluster.proxy)  # noqa: E731
    opens, cpu = cluster.sum_of("waystone_map_opens_total"), elsewhere()
    started = time.monotonic()
    with Load(cluster.port, pairs, photos, expected, zipf_weights(names, pairs)).start(clients, seed=7) as load:
        time.sleep(seconds)
    took_s = time.monotonic() - started
    findings.promise(not load.wrong and not load.failures, f"{clients} clients: {(load.wrong + load.failures)[:2]}")
    ms = sorted(load.ms)
    return {"clients": clients, "queries": load.good, "per_s": round(load.good / took_s, 2),
            "p50_ms": round(ms[len(ms) // 2], 2), "p99_ms": round(ms[int(0.99 * len(ms))], 2),
            "opens_per_query": round((cluster.sum_of("waystone_map_opens_total") - opens) / load.good, 4),
            "cpu_ms_elsewhere": round(1000 * (elsewhere() - cpu) / load.good, 2)}
