#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The simulation of a cluster where one can say by hand what comes out, and what docs/scaling.md reckons with."""
import dataclasses
import json
import math
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bench/cluster"))
import simulate  # noqa: E402
from simulation import Model, Setting  # noqa: E402

SERVICE = {"query_ms": [100], "open_ms": [50]}
ONE = Setting(nodes=1, hosts=1, cores=2, turns=2, map_bytes=[10] * 5, memory=1000, disk=1000, link_bytes_s=100,
              clients=1)
QUERIES = 400


def run(service=SERVICE, queries=QUERIES, **changes):
    return Model(dataclasses.replace(ONE, **changes), service, 1).run(queries)


class SimulationTest(unittest.TestCase):
    def test_one_client_gets_the_service_time(self):
        result = run()
        self.assertAlmostEqual(result["per_s"], 10, delta=0.1)
        self.assertEqual(result["p50_ms"], 100)
        self.assertEqual(result["p99_ms"], 100)

    def test_cores_are_shared_and_turns_are_kept(self):
        self.assertAlmostEqual(run(clients=2)["per_s"], 20, delta=0.3)
        for changes in ({"turns": 2}, {"turns": 8}):  # waiting for a turn, or sharing the cores
            result = run(clients=8, **changes)
            self.assertAlmostEqual(result["per_s"], 20, delta=0.7)
            self.assertAlmostEqual(result["p50_ms"], 400, delta=1)

    def test_nodes_of_one_host_share_its_cores_and_others_do_not(self):
        self.assertAlmostEqual(run(nodes=4, clients=16)["per_s"], 20, delta=1)
        self.assertGreater(run(nodes=4, hosts=4, clients=16, map_bytes=[10] * 100)["per_s"], 40)

    def test_work_elsewhere_takes_cores_too(self):
        self.assertAlmostEqual(run(elsewhere_s=0.1)["per_s"], 5, delta=0.1)

    def test_maps_that_do_not_fit_are_opened_and_fetched_again(self):
        self.assertEqual(run()["opens_per_query"], 0)
        few = run(memory=2 * 10 * 2, queries=4000)
        self.assertGreater(few["opens_per_query"], 0.3)
        self.assertEqual(few["fetches_per_query"], 0)
        none = run(memory=20, disk=10, map_bytes=[10] * 2, zipf=0, queries=4000)
        # Of two equally popular maps the one that isn't there is asked for half of the time: 0.1 s
        # over the link, 0.05 s to open it.
        self.assertAlmostEqual(none["opens_per_query"], 0.5, delta=0.03)
        self.assertEqual(none["opens_per_query"], none["fetches_per_query"])
        self.assertEqual(none["p99_ms"], 250)
        self.assertAlmostEqual(none["per_s"], 1 / 0.175, delta=0.2)

    def test_popularity_is_zipfs(self):
        model = Model(dataclasses.replace(ONE, map_bytes=[10] * 3), SERVICE, 1)
        whole = 1 + 1 / 2 + 1 / 3
        self.assertEqual([round(each / whole, 6) for each in model.cumulative],
                         [round(each / whole, 6) for each in (1, 1.5, whole)])

    def test_a_map_that_all_ask_for_is_shared_with_a_balance_factor(self):
        hot = {"nodes": 4, "hosts": 4, "map_bytes": [10], "clients": 16, "queries": 2000}
        self.assertAlmostEqual(run(**hot)["per_s"], 20, delta=0.7)
        # 16 queries at once, of which each node may have 6 (150 % of the mean, rounded up): three do.
        self.assertAlmostEqual(run(**hot, balance_factor=150)["per_s"], 60, delta=1)

    def test_the_ring_gives_even_shares_and_moves_few_maps(self):
        names = range(10_000)
        setting = dataclasses.replace(ONE, nodes=10, map_bytes=[10] * len(names))
        more = dataclasses.replace(setting, nodes=11)
        owners = [[model.owner(name, lambda _: True) for name in names]
                  for model in (Model(setting, SERVICE, 1), Model(more, SERVICE, 1))]
        counts = [owners[0].count(node) for node in range(10)]
        self.assertGreater(min(counts), 750)
        self.assertLess(max(counts), 1300)
        moved = [b for a, b in zip(*owners) if a != b]
        self.assertEqual(set(moved), {10})
        self.assertLess(len(moved), 1500)

    def test_one_seed_gives_one_result(self):
        changes = {"clients": 0, "rate": 15, "nodes": 3, "map_bytes": [10] * 50, "memory": 200, "queries": 2000}
        self.assertEqual(run(**changes), run(**changes))
        service = {"query_ms": [50, 100, 200], "open_ms": [50]}
        one = Model(dataclasses.replace(ONE), service, 1).run(500)
        other = Model(dataclasses.replace(ONE), service, 2).run(500)
        self.assertNotEqual(one, other)

    def test_more_than_it_holds_is_refused(self):
        result = run(clients=0, rate=100, queries=3000)
        self.assertGreater(result["refused_share"], 0.3)
        self.assertAlmostEqual(result["per_s"], 20, delta=1)


class ScalingTest(unittest.TestCase):
    def test_the_arithmetic_is_of_what_was_measured(self):
        text = (ROOT / "docs/scaling.md").read_text(encoding="utf-8")
        run_of = json.loads((ROOT / "docs/benchmarks/scale.json").read_text(encoding="utf-8"))["result"]["runs"][0]
        megabytes = run_of["file_bytes"] / 1e6
        held = simulate.MEMORY / (2 * run_of["file_bytes"])
        for said in (f"{megabytes:.1f} MB", f"{1000 * run_of['open_s']:.0f} ms", f"{run_of['median_ms']['total']:.0f} ms",
                     f"{simulate.MAPS * megabytes / 1000:.0f} GB", f"{held:.0f} maps",
                     f"{math.ceil(simulate.MAPS / held)} servers"):
            self.assertIn(said, text)


if __name__ == "__main__":
    unittest.main()
