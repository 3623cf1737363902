#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""simulate.py --measured CLUSTER --scale SCALE: what 10 to 1,000 servers of one registry hold.

Service times are recorded ones: CLUSTER is the JSON of tests/cluster/cluster_test.py, SCALE that of
`waystone-bench scale`, or results of scripts/bench.py with them. The simulation (simulation.py) is
checked first: three servers on one machine with as many clients as were measured. Then servers with
machines of their own and 10,000 maps of buildings, as large and as long to open and to ask as the first
one of SCALE, with Zipf popularity, are given more and more queries, with open arrivals. A rate holds
when 99 of 100 answers come within P99_S. The last line is JSON. Random numbers have a fixed seed.
"""
import argparse
import json
import statistics
from pathlib import Path

from simulation import Model, Setting

NODES = (10, 30, 100, 300, 1000)
FACTORS = (0, 150, 300)  # HAProxy's hash-balance-factor; 0: none
MAPS = 10_000
CORES = 4
SHARES = (0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1)  # of what the cores could do
MEMORY = 8_000_000_000
DISK = 50_000_000_000
LINK_BYTES_S = 125_000_000  # from the store: 1 Gbit/s
P99_S = 1.0
LEAST_QUERIES = 200  # of a node
SEED = 1


def read_measured(path):
    record = json.loads(path.read_text(encoding="utf-8"))
    return record.get("result", record)


def check(measured, queries):
    """The measured loads beside the simulated ones."""
    rows = []
    for load in measured["loads"]:
        setting = Setting(
            nodes=measured["servers"], hosts=1, cores=measured["cores"], turns=measured["cores"],
            map_bytes=warm_sizes(measured), memory=measured["memory_bytes"], disk=10**12,
            link_bytes_s=10**10, clients=load["clients"], elsewhere_s=load["cpu_ms_elsewhere"] / 1000)
        result = Model(setting, measured["service"], SEED).run(queries)
        row = {"clients": load["clients"]}
        for key in ("per_s", "p50_ms", "p99_ms", "opens_per_query"):
            row[key] = load[key]
            row["simulated_" + key] = result[key]
        row["deviation"] = {key: deviation(row["simulated_" + key], row[key]) for key in ("per_s", "p50_ms", "p99_ms")}
        rows.append(row)
        print(f"{load['clients']} clients: {load['per_s']}/s measured, {result['per_s']} simulated; "
              f"p50 {load['p50_ms']} and {result['p50_ms']} ms, p99 {load['p99_ms']} and {result['p99_ms']} ms, "
              f"openings a query {load['opens_per_query']} and {result['opens_per_query']}", flush=True)
    return rows


def warm_sizes(measured):
    return measured["map_bytes"][:measured["counts"]["maps"]]


def deviation(simulated, measured):
    return simulated / measured - 1


class Building:
    """A map of a building, and service times of it: those of SCALE, spread as the queries of CLUSTER are."""

    def __init__(self, measured, scale):
        run = scale["runs"][0]
        self.map_bytes, self.query_ms = run["file_bytes"], run["median_ms"]["total"]
        queries = measured["service"]["query_ms"]
        factor = self.query_ms / statistics.mean(queries)  # what the cores hold is a matter of the mean
        self.service = {"query_ms": [factor * ms for ms in queries], "open_ms": [1000 * run["open_s"]]}
        self.mean_s = statistics.mean(self.service["query_ms"]) / 1000

    def setting(self, nodes, factor, share):
        return Setting(nodes=nodes, hosts=nodes, cores=CORES, turns=CORES, map_bytes=[self.map_bytes] * MAPS,
                       memory=MEMORY, disk=DISK, link_bytes_s=LINK_BYTES_S, balance_factor=factor,
                       rate=share * nodes * CORES / self.mean_s)


def hold(nodes, factor, building, queries):
    """The highest of the rates that holds, and what it was like; with none, the lowest one."""
    for share in SHARES:
        result = Model(building.setting(nodes, factor, share), building.service, SEED).run(
            max(queries, LEAST_QUERIES * nodes))
        holds = result["p99_ms"] <= 1000 * P99_S and result["refused_share"] == 0
        if holds:
            break
    return {"name": f"{nodes}-{factor}", "nodes": nodes, "balance_factor": factor, "share": share, "holds": holds,
            **result}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bench", nargs="?", default="simulation", choices=["simulation"])
    parser.add_argument("--measured", type=Path, required=True)
    parser.add_argument("--scale", type=Path, required=True)
    parser.add_argument("--queries", type=int, default=60_000)
    parser.add_argument("--nodes", type=int, nargs="+", default=NODES)
    arguments = parser.parse_args()
    measured = read_measured(arguments.measured)
    checks = check(measured, min(arguments.queries, 20_000))
    building = Building(measured, read_measured(arguments.scale))
    runs = []
    for nodes in arguments.nodes:
        for factor in FACTORS:
            runs.append(hold(nodes, factor, building, arguments.queries))
            found = runs[-1]
            print(f"{nodes} nodes, factor {factor}: {found['per_s']:.0f}/s ({found['share']:.0%} of the cores), "
                  f"p99 {found['p99_ms']:.0f} ms, {found['opens_per_query']:.2%} opened, "
                  f"{found['fetches_per_query']:.2%} fetched", flush=True)
    print(json.dumps({"bench": "simulation", "check": checks, "runs": runs, "maps": MAPS, "cores": CORES,
                      "map_mb": building.map_bytes / 1e6, "memory_gb": MEMORY / 1e9, "disk_gb": DISK / 1e9,
                      "query_ms": 1000 * building.mean_s, "open_ms": building.service["open_ms"][0],
                      "queries": arguments.queries, "p99_bound_ms": 1000 * P99_S,
                      "deviation": {key: max(abs(row["deviation"][key]) for row in checks)
                                    for key in ("per_s", "p50_ms", "p99_ms")}}))


if __name__ == "__main__":
    main()
