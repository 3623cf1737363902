#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""soak.py --program PROGRAM [--offline PROGRAM]: wears out a server of a few maps of a rendered building.

Honest clients send photos whose answers `waystone localize` gave before: every answer must equal that
one, but for times. Hostile clients send everything else. Maps are replaced under their feet. Bounds:

  answers      all equal; none with status 500 to anybody
  reloads      a new file is served within PATIENCE_S
  memory       what is held when little goes on, the lower quartile of RSS: in the last third at most
               GROWTH_SHARE + GROWTH_MB more than in the first (queries come and go with 20 to 300 MB);
               in runs of WARM_S or more; not with a sanitizer, which keeps memory of its own
  descriptors  when all is quiet, as many as when all was quiet before
  threads      in the last third at most as many as in the first
  end          exit 0 within END_S of SIGTERM, while connections drip
  sanitizer    no report of it in the server's log

Prints one line a minute and a summary as JSON; exits with 1 when a bound is broken. The maps take
about 40 s of one core to make; --folder keeps them for the next time. A server that is built with a
sanitizer gets N times as long for everything by --slower N, and --offline names a program without it
for the maps and the answers.
"""
import argparse
import base64
import contextlib
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from pathlib import Path

from connection import PATIENCE_S, Connection, form_body
from hostile import Hostile
from offline import comparable, make_maps, version

END_S = 5
GROWTH_SHARE = 0.05
GROWTH_MB = 16
WARM_S = 300  # a third of it fills what the server keeps: shorter runs tell nothing of growth
HONEST = 3
HOSTILE = 5
RELOAD_S = 3.0
QUIET_S = 15  # idle and half requests are over by then: a head has 10 s


# ---- the server

class Server:
    def __init__(self, program, maps, log, slower):
        self.slower, self.patience_s, self.end_s = slower, slower * PATIENCE_S, slower * END_S
        self.log = open(log, "wb")
        self.process = subprocess.Popen(
            [program, "serve", str(maps), "--port", "0", "--watch", "0.5", "--threads", "2", "--queue", "16"],
            stdout=subprocess.PIPE, stderr=self.log)
        line = self.process.stdout.readline().decode()
        if "http://" not in line:
            sys.exit(f"the server didn't start: {line}, see {log}")
        self.port = int(line.rsplit(":", 1)[1])
        threading.Thread(target=self.process.stdout.read, daemon=True).start()

    def connect(self):
        return Connection(self.port, self.patience_s)

    def proc(self, name):
        return Path(f"/proc/{self.process.pid}/{name}")

    def rss_mb(self):
        fields = dict(line.split(":", 1) for line in self.proc("status").read_text().splitlines())
        return int(fields["VmRSS"].split()[0]) / 1024

    def descriptors(self):
        return len(os.listdir(self.proc("fd")))

    def threads(self):
        return len(os.listdir(self.proc("task")))

    def alive(self):
        return self.process.poll() is None


# ---- what clients share

class Tally:
    """Counts what happened, and keeps the first things that must not."""

    def __init__(self):
        self.lock = threading.Lock()
        self.counts = Counter()
        self.broken = []

    def count(self, what):
        with self.lock:
            self.counts[what] += 1

    def fail(self, what):
        with self.lock:
            self.counts["failures"] += 1
            if len(self.broken) < 20:
                self.broken.append(what)


class Clients:
    """Threads that each do one thing until they are told to end. What they don't expect goes to `fail`."""

    def __init__(self, patience_s, fail):
        self.end, self.patience_s, self.fail = threading.Event(), patience_s, fail
        self.threads = []

    def start(self, function, *arguments):
        def loop():
            while not self.end.is_set():
                try:
                    function(*arguments)
                except Exception as error:
                    self.fail(f"{type(function).__name__}: {error!r}")
                    self.end.wait(0.2)
        self.threads.append(threading.Thread(target=loop, daemon=True))
        self.threads[-1].start()

    def stop(self):
        self.end.set()
        for thread in self.threads:
            thread.join(2 * self.patience_s)
            if thread.is_alive():
                self.fail("a client doesn't end")


# ---- honest clients

def json_body(photo):
    return json.dumps({"images": [{"name": "q.jpg", "data": base64.b64encode(photo).decode()}]}).encode()


class Honest:
    BODIES = ((lambda photo: photo, "image/jpeg"), (form_body, "multipart/form-data; boundary=edge"),
              (json_body, "application/json"))

    def __init__(self, server, names, photos, answers, tally, seed):
        self.server, self.names, self.answers, self.tally = server, names, answers, tally
        self.photos = {photo: photo.read_bytes() for photo in photos}
        self.random = random.Random(seed)

    def __call__(self):
        """Some queries on one connection."""
        try:
            with self.server.connect() as connection:
                for _ in range(self.random.randint(1, 6)):
                    self.query(connection)
        except (OSError, ValueError) as error:
            if self.server.alive():
                self.tally.fail(f"an honest client: {error!r}")
            time.sleep(0.2)

    def query(self, connection):
        name, photo = self.random.choice(self.names), self.random.choice(list(self.photos))
        make, content_type = self.random.choice(self.BODIES)
        started = time.monotonic()
        status, body = connection.ask("POST", f"/v1/maps/{name}/localize", make(self.photos[photo]), content_type)
        if status in (429, 503):
            self.tally.count("honest_told_to_wait")
            time.sleep(0.2)
            return
        if status != 200:
            self.tally.fail(f"an honest query got {status}: {body[:200]!r}")
            return
        answer = json.loads(body)
        self.tally.count("honest_answers")
        self.tally.count("honest_" + answer["verdict"])
        with self.tally.lock:
            self.tally.counts["honest_ms"] += int(1000 * (time.monotonic() - started))
        expected = self.answers.get(answer["map_version"])
        if answer["map"] != name or expected is None:
            self.tally.fail(f"an answer of map {answer['map']} {answer['map_version']}, asked was {name}")
        elif comparable(answer) != expected[photo]:
            self.tally.fail(f"{photo.name} in {name}: {json.dumps(comparable(answer))[:300]} and offline "
                            f"{json.dumps(expected[photo])[:300]}")


# ---- reloads

class Reloads:
    """Moves another map, or a damaged one, onto the name of a map, again and again."""

    def __init__(self, server, folder, maps, tally, end):
        self.server, self.folder, self.maps, self.tally, self.end = server, folder, maps, tally, end
        self.round = 0

    def __call__(self):
        self.round += 1
        name = self.maps[self.round % len(self.maps)].stem
        if self.round % 5 == 0:
            self.replace(name, self.maps[0].read_bytes()[:-1000])
            self.tally.count("damaged_files")
        else:
            self.replace_and_wait(name, self.maps[(self.round // 2) % len(self.maps)])
        self.end.wait(RELOAD_S)

    def replace(self, name, data):
        new = self.folder / f"{name}.new"
        new.write_bytes(data)
        os.replace(new, self.folder / f"{name}.db")
        if self.round % 2 == 0:
            self.server.process.send_signal(signal.SIGHUP)

    def replace_and_wait(self, name, source):
        self.replace(name, source.read_bytes())
        deadline = time.monotonic() + self.server.patience_s
        while not self.end.is_set():
            if self.served_bytes(name) == source.read_bytes():
                self.tally.count("reloads")
                return
            if time.monotonic() > deadline:
                self.tally.fail(f"map {name} isn't served {self.server.patience_s} s after it was replaced")
                return
            time.sleep(0.1)

    def served_bytes(self, name):
        """The map file whose version is served; nothing where the server has no time."""
        with contextlib.suppress(OSError, ValueError, KeyError), self.server.connect() as connection:
            served = json.loads(connection.ask("GET", f"/v1/maps/{name}")[1])["version"]
            return next((path.read_bytes() for path in self.maps if VERSIONS[path] == served), None)
        return None


VERSIONS = {}  # {map file: version}


# ---- measuring

class Samples:
    def __init__(self, server):
        self.server, self.rows = server, []

    def take(self):
        with contextlib.suppress(OSError, KeyError):
            self.rows.append((self.server.rss_mb(), self.server.threads(), self.server.descriptors()))

    def save(self, path):
        """A line a second: MB, threads, descriptors."""
        path.write_text("".join(f"{rss:.1f},{threads},{descriptors}\n" for rss, threads, descriptors in self.rows))

    def thirds(self, column):
        third = max(1, len(self.rows) // 3)
        return ([row[column] for row in self.rows[:third]], [row[column] for row in self.rows[-third:]])


def measure(server, seconds, tally):
    samples = Samples(server)
    started = time.monotonic()
    while (passed := time.monotonic() - started) < seconds and server.alive():
        samples.take()
        if len(samples.rows) % 60 == 0:
            rss, threads, descriptors = samples.rows[-1]
            print(f"{passed / 60:5.1f} min: {rss:.0f} MB, {threads} threads, {descriptors} descriptors, "
                  f"{tally.counts['honest_answers']} honest answers, {tally.counts['reloads']} reloads, "
                  f"{tally.counts['failures']} failures", flush=True)
        time.sleep(1)
    return samples


def wait_for_quiet(server, most):
    """Descriptors when nobody asks, at most `most` where it comes to that."""
    deadline = time.monotonic() + QUIET_S
    while server.descriptors() > most and time.monotonic() < deadline:
        time.sleep(0.2)
    return server.descriptors()


def stop(server, tally):
    """Ends the server while connections drip, and returns how long that took."""
    with contextlib.ExitStack() as open_ones:
        for i in range(10):
            connection = open_ones.enter_context(server.connect())
            connection.send(b"POST /v1/localize HTTP/1.1\r\nHost: localhost\r\n"[:5 + 4 * i])
        started = time.monotonic()
        server.process.send_signal(signal.SIGTERM)
        try:
            code = server.process.wait(4 * server.patience_s)
        except subprocess.TimeoutExpired:
            server.process.kill()
            code = "no end"
    took = time.monotonic() - started
    if code != 0:
        tally.fail(f"the server ended with {code}")
    if took > server.end_s:
        tally.fail(f"the server took {took:.1f} s to end")
    return took


def lower_quartile(values):
    return sorted(values)[len(values) // 4]


def check_growth(server, samples, quiet_before, quiet_after, tally):
    rss_first, rss_last = (lower_quartile(third) for third in samples.thirds(0))
    threads_first, threads_last = (max(third) for third in samples.thirds(1))
    bound = rss_first * (1 + GROWTH_SHARE) + GROWTH_MB
    if server.slower == 1 and len(samples.rows) >= WARM_S and rss_last > bound:
        tally.fail(f"memory grew from {rss_first:.0f} to {rss_last:.0f} MB")
    if threads_last > threads_first:
        tally.fail(f"threads grew from {threads_first} to {threads_last}")
    if quiet_after > quiet_before:
        tally.fail(f"descriptors grew from {quiet_before} to {quiet_after}")
    return {"rss_mb": [round(rss_first, 1), round(rss_last, 1)], "rss_bound_mb": round(bound, 1),
            "rss_peak_mb": round(max(row[0] for row in samples.rows), 1),
            "threads": [threads_first, threads_last], "quiet_descriptors": [quiet_before, quiet_after]}


def check_log(log, tally):
    """Reports of a sanitizer, each by its first lines."""
    reports = re.findall(r"WARNING: \w+Sanitizer.*(?:\n.+){0,8}|\S+: runtime error: .*", log)
    for report in reports:
        tally.fail(report)
    return len(reports)


def soak(arguments, folder, served):
    offline = arguments.offline or arguments.program
    maps, photos, answers = make_maps(offline, folder, arguments.maps)
    for path in maps:
        shutil.copy(path, served)
        VERSIONS[path] = version(offline, path)
    server = Server(arguments.program, served, folder / "server.log", arguments.slower)
    tally = Tally()
    clients = Clients(server.patience_s, tally.fail)
    try:
        return wear_out(server, tally, clients, arguments.seconds, maps, photos, answers, served)
    finally:
        server.process.kill()


def wear_out(server, tally, clients, seconds, maps, photos, answers, served):
    log = Path(server.log.name)
    names = [path.stem for path in maps]
    Honest(server, names, photos, answers, tally, 0)()
    quiet = wait_for_quiet(server, 0)
    for i in range(HONEST):
        clients.start(Honest(server, names, photos, answers, tally, i))
    for i in range(HOSTILE):
        clients.start(Hostile(server, names[i % len(names)], photos[i].read_bytes(), tally, clients.end, i))
    clients.start(Reloads(server, served, maps, tally, clients.end))
    samples = measure(server, seconds, tally)
    clients.stop()
    samples.save(log.with_name("samples.csv"))
    if not server.alive():
        sys.exit(f"the server ended with {server.process.returncode}: {log.read_text(errors='replace')[-3000:]}")
    growth = check_growth(server, samples, quiet, wait_for_quiet(server, quiet), tally)
    took = stop(server, tally)
    reports = check_log(log.read_text(errors="replace"), tally)
    if not tally.counts["honest_localized"] or not tally.counts["honest_not_in_map"] or not tally.counts["reloads"]:
        tally.fail("too little happened: no place found, none refused, or no map replaced")
    print(json.dumps({"seconds": len(samples.rows), **growth, "end_s": round(took, 2),
                      "sanitizer_reports": reports,
                      "honest_mean_ms": tally.counts.pop("honest_ms", 0) // max(1, tally.counts["honest_answers"]),
                      **dict(sorted(tally.counts.items()))}))
    for broken in tally.broken:
        print("broken:", broken)
    return 1 if tally.broken else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True)
    parser.add_argument("--offline")
    parser.add_argument("--slower", type=float, default=1)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--maps", type=int, choices=(2, 3), default=3)
    parser.add_argument("--folder", type=Path)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="waystone-soak-") as temporary:
        folder = arguments.folder or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        served = Path(temporary) / "maps"
        served.mkdir()
        return soak(arguments, folder, served)


if __name__ == "__main__":
    sys.exit(main())
