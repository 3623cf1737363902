# SPDX-License-Identifier: Apache-2.0
"""Servers of one registry behind HAProxy as a simulation of discrete events.

A query goes to the node that the consistent hash of its map's name says, or to the next one on the ring
that has fewer queries than HAProxy's hash-balance-factor allows. There it waits until its map is open
(fetched from the store over the node's link if it isn't on its disk, and opened one map at a time),
for one of the node's turns, and then takes its service time of a core. The cores of a host are shared
evenly by what runs on it. Open maps and files go by least recent use.
"""
import bisect
import functools
import heapq
import itertools
import random
import zlib
from collections import OrderedDict, deque
from dataclasses import dataclass, field

POINTS = 256  # of a server on the ring: weight 16
OPEN_FACTOR = 2  # an open map's memory, as a multiple of its file
MAX_QUEUED = 128  # of a server: maxconn and maxqueue; then the next one gets it
WARM_SHARE = 0.25  # of the queries, before anything is counted


@dataclass
class Setting:
    nodes: int
    hosts: int
    cores: int
    turns: int
    map_bytes: list
    memory: float
    disk: float
    link_bytes_s: float
    clients: int = 0  # that ask one query after the other; 0: open arrivals
    rate: float = 0  # of open arrivals, a second
    balance_factor: int = 0
    elsewhere_s: float = 0  # of a core of the host, for clients and balancer on it
    zipf: float = 1.0


class Host:
    """Cores that are shared evenly by the work that is on them."""

    def __init__(self, model, cores):
        self.model, self.cores = model, cores
        self.tasks, self.progress, self.since, self.stamp = [], 0.0, 0.0, 0

    def advance(self):
        if self.tasks:
            self.progress += (self.model.now - self.since) * min(1.0, self.cores / len(self.tasks))
        self.since = self.model.now

    def add(self, work_s, done):
        self.advance()
        heapq.heappush(self.tasks, (self.progress + work_s, next(self.model.numbers), done))
        self.schedule()

    def schedule(self):
        self.stamp += 1
        if self.tasks:
            left = max(0.0, self.tasks[0][0] - self.progress)
            self.model.at(self.model.now + left * max(1.0, len(self.tasks) / self.cores), self.finish, self.stamp)

    def finish(self, stamp):
        if stamp != self.stamp:
            return
        self.advance()
        done = heapq.heappop(self.tasks)[2]
        self.schedule()
        done()


class Recent:
    """Sizes within a bound by least recent use."""

    def __init__(self, bound):
        self.bound, self.used, self.sizes = bound, 0, OrderedDict()

    def use(self, key):
        if key not in self.sizes:
            return False
        self.sizes.move_to_end(key)
        return True

    def add(self, key, size):
        while self.sizes and self.used + size > self.bound:
            self.used -= self.sizes.popitem(last=False)[1]
        self.sizes[key] = size
        self.used += size


@dataclass
class Query:
    map: int
    began: float
    node: object = None


@dataclass
class Node:
    host: Host
    opened: Recent
    files: Recent
    running: int = 0
    served: int = 0  # by the balancer
    waiting: deque = field(default_factory=deque)  # for a turn
    opening: dict = field(default_factory=dict)  # {map: queries}
    to_open: deque = field(default_factory=deque)
    link_free: float = 0.0
    is_opening: bool = False


class Model:
    def __init__(self, setting, service, seed):
        self.setting, self.chance = setting, random.Random(seed)
        self.query_s = [ms / 1000 for ms in service["query_ms"]]
        self.open_s = [ms / 1000 for ms in service["open_ms"]]
        self.now, self.events, self.numbers = 0.0, [], itertools.count()
        hosts = [Host(self, setting.cores) for _ in range(setting.hosts)]
        self.hosts = hosts
        self.nodes = [Node(hosts[i % len(hosts)], Recent(setting.memory), Recent(setting.disk))
                      for i in range(setting.nodes)]
        self.ring, self.owners = ring_of(setting.nodes)
        self.places = [bisect.bisect(self.ring, hash_of(f"map{i}")) for i in range(len(setting.map_bytes))]
        self.cumulative = list(itertools.accumulate(
            1 / (rank + 1) ** setting.zipf for rank in range(len(setting.map_bytes))))
        self.served, self.took, self.opens, self.fetches, self.refused, self.arrived = 0, [], 0, 0, 0, 0
        self.counting_since = None
        self.fill()

    def fill(self):
        """Files and open maps as they are after a long time, about: the most popular ones of each node."""
        for name in reversed(range(len(self.setting.map_bytes))):
            node = self.nodes[self.owner(name, lambda _: True)]
            node.files.add(name, self.setting.map_bytes[name])
            node.opened.add(name, OPEN_FACTOR * self.setting.map_bytes[name])

    # ---- time

    def at(self, when, call, *arguments):
        heapq.heappush(self.events, (when, next(self.numbers), call, arguments))

    def run(self, queries):
        self.left, self.warm = queries, int(WARM_SHARE * queries)
        if self.setting.clients:
            for _ in range(self.setting.clients):
                self.arrive()
        else:
            self.arrive()
        while self.events:
            self.now, _, call, arguments = heapq.heappop(self.events)
            call(*arguments)
        return self.result()

    def result(self):
        took = sorted(self.took)
        counted, seconds = len(took), self.now - self.counting_since
        return {"per_s": round(counted / seconds, 2), "p50_ms": round(1000 * took[counted // 2], 2),
                "p99_ms": round(1000 * took[int(0.99 * counted)], 2),
                "opens_per_query": round(self.opens / counted, 5), "fetches_per_query": round(self.fetches / counted, 5),
                "refused_share": self.refused / (counted + self.refused)}

    # ---- a query

    def arrive(self):
        if self.left == 0:
            return
        self.left -= 1
        self.arrived += 1
        if self.arrived == self.warm:
            self.counting_since, self.took, self.opens, self.fetches, self.refused = self.now, [], 0, 0, 0
        if not self.setting.clients:
            self.at(self.now + self.chance.expovariate(self.setting.rate), self.arrive)
        name = bisect.bisect(self.cumulative, self.chance.random() * self.cumulative[-1])
        query = Query(min(name, len(self.places) - 1), self.now)
        if self.setting.elsewhere_s:
            self.hosts[0].add(self.setting.elsewhere_s, lambda: self.balance(query))
        else:
            self.balance(query)

    def balance(self, query):
        found = self.owner(query.map, self.may_take())
        if found is None:
            self.refused += 1
            self.next_of_client()
            return
        query.node = self.nodes[found]
        query.node.served += 1
        self.served += 1
        self.enter(query)

    def may_take(self):
        """As HAProxy's chash_server_is_eligible for servers of one weight."""
        factor = self.setting.balance_factor
        if not factor:
            return lambda i: self.nodes[i].served < MAX_QUEUED
        nodes = len(self.nodes)
        each, rest = divmod(-(-(self.served + 1) * factor // 100), nodes)
        return lambda i: self.nodes[i].served < min(MAX_QUEUED, max(1, each + (i + 1) * rest // nodes - i * rest // nodes))

    def owner(self, name, may):
        """The first node from the map's place on the ring that may have it; None for none."""
        place, tried = self.places[name], set()
        while len(tried) < len(self.nodes):
            owner = self.owners[place % len(self.owners)]
            if owner not in tried:
                if may(owner):
                    return owner
                tried.add(owner)
            place += 1
        return None

    def enter(self, query):
        node = query.node
        if node.opened.use(query.map):
            self.take_turn(query)
        elif query.map in node.opening:
            node.opening[query.map].append(query)
        else:
            node.opening[query.map] = [query]
            self.opens += 1
            self.fetch(node, query.map)

    def fetch(self, node, name):
        if node.files.use(name):
            self.queue_opening(node, name)
            return
        self.fetches += 1
        size = self.setting.map_bytes[name]
        node.link_free = max(node.link_free, self.now) + size / self.setting.link_bytes_s
        self.at(node.link_free, self.fetched, node, name)

    def fetched(self, node, name):
        node.files.add(name, self.setting.map_bytes[name])
        self.queue_opening(node, name)

    def queue_opening(self, node, name):
        node.to_open.append(name)
        if not node.is_opening:
            self.open_next(node)

    def open_next(self, node):
        node.is_opening = bool(node.to_open)
        if node.is_opening:
            name = node.to_open.popleft()
            node.host.add(self.chance.choice(self.open_s), lambda: self.is_open(node, name))

    def is_open(self, node, name):
        node.opened.add(name, OPEN_FACTOR * self.setting.map_bytes[name])
        for query in node.opening.pop(name):
            self.take_turn(query)
        self.open_next(node)

    def take_turn(self, query):
        node = query.node
        if node.running == self.setting.turns:
            node.waiting.append(query)
            return
        node.running += 1
        node.host.add(self.chance.choice(self.query_s), lambda: self.answer(query))

    def answer(self, query):
        node = query.node
        node.running -= 1
        node.served -= 1
        self.served -= 1
        if self.counting_since is not None:
            self.took.append(self.now - query.began)
        if node.waiting:
            self.take_turn(node.waiting.popleft())
        self.next_of_client()

    def next_of_client(self):
        if self.setting.clients:
            self.arrive()


@functools.cache
def ring_of(nodes):
    """Points on the circle of hashes, ascending, and whose they are."""
    points = sorted((hash_of(f"{i}/{j}"), i) for i in range(nodes) for j in range(POINTS))
    return [point for point, _ in points], [node for _, node in points]


def hash_of(text):
    """32 bits, mixed: CRCs of texts that differ in one digit are near each other."""
    value = zlib.crc32(text.encode())
    for _ in range(2):
        value = ((value ^ value >> 16) * 0x45D9F3B) & 0xFFFFFFFF
    return value ^ value >> 16
