# SPDX-License-Identifier: Apache-2.0
"""Clients that ask a cluster, or one server, and compare each answer with the one that is expected."""
import random
import re
import threading
import time
from dataclasses import dataclass

from connection import Connection
from soak import Clients

TIMES = re.compile(rb',"timing_ms":\{[^{}]*\}')
PATIENCE_S = 60  # for an answer by trying again
PAUSE_S = 0.1


def without_times(body):
    """An answer's bytes but for its timings."""
    return TIMES.sub(b"", body)


def localize(connection, name, photo):
    return connection.ask("POST", f"/v1/maps/{name}/localize", photo, "image/jpeg")


@dataclass
class Failure:
    """A request without an answer, and how it went when it was tried again."""
    name: str
    cause: str
    began: float
    ended: float
    answered: bool = False


class Load:
    """What some clients asked, in pairs of map and photo; `expected` has the bytes of each pair's answer."""

    def __init__(self, port, pairs, photos, expected, weights=None, keeps=True):
        self.port, self.pairs, self.photos, self.expected, self.weights = port, pairs, photos, expected, weights
        self.keeps = keeps  # connections
        self.lock, self.clients = threading.Lock(), Clients(PATIENCE_S, self.fail)
        self.good, self.ms, self.wrong, self.failures = 0, [], [], []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.clients.stop()

    def fail(self, what):
        with self.lock:
            self.wrong.append(what)

    def start(self, clients, seed=0):
        for i in range(clients):
            self.clients.start(Client(self, random.Random(1000 * seed + i)))
        return self

    def ask(self, connection, pair):
        """Asks until there is an answer; the connection for the next time."""
        failure, first = None, time.monotonic()
        while time.monotonic() - first < PATIENCE_S:
            began = time.monotonic()
            try:
                connection = connection or Connection(self.port, PATIENCE_S)
                status, body = localize(connection, pair[0], self.photos[pair[1]])
                cause = None if status == 200 else f"status {status}: {body[:200]!r}"
            except (OSError, ValueError) as error:
                connection, cause = None, repr(error)
            if connection and not self.keeps:
                connection.close()
                connection = None
            if cause is None:
                self.take(pair, body, began, failure)
                return connection
            if failure is None:
                failure = Failure(pair[0], cause, began, time.monotonic())
                with self.lock:
                    self.failures.append(failure)
            time.sleep(PAUSE_S)
        return connection

    def take(self, pair, body, began, failure):
        took_ms = 1000 * (time.monotonic() - began)
        with self.lock:
            if self.is_right(pair, body):
                self.good += 1
                self.ms.append(took_ms)
                if failure:
                    failure.answered = True
            else:
                self.wrong.append(f"{pair}: {body[:300]!r}")

    def is_right(self, pair, body):
        return without_times(body) in self.expected[pair]


class Client:
    """Asks one query after the other, on one connection while that is good."""

    def __init__(self, load, chance):
        self.load, self.chance, self.connection = load, chance, None

    def __call__(self):
        pair = self.chance.choices(self.load.pairs, self.load.weights)[0]
        self.connection = self.load.ask(self.connection, pair)


def ask_all(port, pairs, photos, threads=2):
    """The bytes of each pair's answer but for timings, asked by some clients side by side."""
    answers, failures, lock, left = {}, [], threading.Lock(), list(reversed(pairs))

    def client():
        with Connection(port, PATIENCE_S) as connection:
            while True:
                with lock:
                    if not left:
                        return
                    pair = left.pop()
                status, body = localize(connection, pair[0], photos[pair[1]])
                with lock:
                    if status == 200:
                        answers[pair] = without_times(body)
                    else:
                        failures.append(f"{pair}: status {status}: {body[:200]!r}")

    clients = [threading.Thread(target=client, daemon=True) for _ in range(threads)]
    for each in clients:
        each.start()
    for each in clients:
        each.join()
    if failures:
        raise RuntimeError(f"{len(failures)} queries failed: {failures[0]}")
    return answers
