#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""soak.py --program PROGRAM [--seconds N] [--maps N]: wears out a server of a few maps of a rendered building.

Honest clients send photos whose answers `waystone localize` gave before: every answer must equal that
one, but for times. Hostile clients send everything else. Maps are replaced under their feet. Bounds:

  answers      all equal; none with status 500 to anybody
  reloads      a new file is served within PATIENCE_S
  memory       what is held when little goes on, the lower quartile of RSS: in the last third at most
               GROWTH_SHARE + GROWTH_MB more than in the first (queries come and go with 20 to 300 MB);
               in runs of WARM_S or more
  descriptors  when all is quiet, as many as when all was quiet before
  threads      in the last third at most as many as in the first
  end          exit 0 within END_S of SIGTERM, while connections drip

Prints one line a minute and a summary as JSON; exits with 1 when a bound is broken. The maps take
about 40 s of one core to make; --folder keeps them for the next time.
"""
import argparse
import base64
import contextlib
import json
import os
import random
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import zlib
from collections import Counter
from pathlib import Path

PATIENCE_S = 30  # for an answer, or for a new map: sanitizers are slow
END_S = 5
GROWTH_SHARE = 0.05
GROWTH_MB = 16
WARM_S = 300  # a third of it fills what the server keeps: shorter runs tell nothing of growth
HONEST = 3
HOSTILE = 5
RELOAD_S = 3.0
QUIET_S = 15  # idle and half requests are over by then: a head has 10 s


# ---- the maps

def make_maps(program, folder, count):
    """Map files of parts of a building, and {map's version: {photo: answer}}."""
    walk = folder / "walk"
    if not (walk / "queries.csv").exists():
        run(program, "demo", "--write", walk)
    maps = []
    for name, first, last in (("west", 0, 56), ("east", 104, 159), ("middle", 52, 108))[:count]:
        path = folder / f"{name}.db"
        if not path.exists():
            run(program, "build", walk / "images", "--from", first, "--to", last, "--every", 4, "-o", path)
        maps.append(path)
    every = sorted((walk / "queries").glob("*.jpg"))
    elsewhere = [photo for photo in every if photo.name.startswith("other")]
    photos = [photo for photo in every if photo not in elsewhere][::2] + elsewhere[::7]
    answers = {}
    for path in maps:
        lines = run(program, "localize", path, *photos, "--json").splitlines()
        parsed = [json.loads(line) for line in lines]
        answers[parsed[0]["map_version"]] = {
            photo: comparable(answer) for photo, answer in zip(photos, parsed, strict=True)}
    return maps, photos, answers


def run(program, *arguments):
    """What the program prints; it may say that there is no usable answer (4) to some of the photos."""
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 4):
        sys.exit(f"waystone {arguments[0]} exited with {done.returncode}: {done.stderr}")
    return done.stdout


def comparable(answer):
    """An answer without times and the names that whoever asked gave."""
    return {key: value for key, value in answer.items() if key not in ("timing_ms", "image", "map")}


# ---- the server

class Server:
    def __init__(self, program, maps, log):
        self.log = open(log, "wb")
        self.process = subprocess.Popen(
            [program, "serve", str(maps), "--port", "0", "--watch", "0.5", "--threads", "2", "--queue", "16"],
            stdout=subprocess.PIPE, stderr=self.log)
        line = self.process.stdout.readline().decode()
        if "http://" not in line:
            sys.exit(f"the server didn't start: {line}, see {log}")
        self.port = int(line.rsplit(":", 1)[1])
        threading.Thread(target=self.process.stdout.read, daemon=True).start()

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


class Connection:
    """A socket that reads one answer after the other."""

    def __init__(self, port, patience=PATIENCE_S):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=patience)
        self.buffer = b""
        self.port = port

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()

    def send(self, data):
        self.socket.sendall(data)

    def fill(self):
        received = self.socket.recv(65536)
        if not received:
            raise ConnectionError("closed")
        self.buffer += received

    def read_answer(self):
        """(status, body) of the next answer."""
        while b"\r\n\r\n" not in self.buffer:
            self.fill()
        head, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
        lines = head.decode("latin-1").split("\r\n")
        headers = {name.lower(): value.strip() for name, value in (line.split(":", 1) for line in lines[1:])}
        size = int(headers.get("content-length", 0))
        while len(self.buffer) < size:
            self.fill()
        body, self.buffer = self.buffer[:size], self.buffer[size:]
        return int(lines[0].split()[1]), body

    def ask(self, method, path, body=b"", content_type=None):
        self.send(request(self.port, method, path, body, content_type))
        return self.read_answer()


def request(port, method, path, body=b"", content_type=None, more=""):
    head = f"{method} {path} HTTP/1.1\r\nHost: localhost:{port}\r\n{more}"
    if content_type:
        head += f"Content-Type: {content_type}\r\n"
    if body or method == "POST":
        head += f"Content-Length: {len(body)}\r\n"
    return head.encode() + b"\r\n" + body


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
    """Threads that each do one thing until they are told to end."""

    def __init__(self):
        self.end = threading.Event()
        self.threads = []

    def start(self, function, *arguments):
        def loop():
            while not self.end.is_set():
                function(*arguments)
        self.threads.append(threading.Thread(target=loop, daemon=True))
        self.threads[-1].start()

    def stop(self):
        self.end.set()
        for thread in self.threads:
            thread.join(2 * PATIENCE_S)


# ---- honest clients

def form_body(photo):
    return (b"--edge\r\nContent-Disposition: form-data; name=\"image\"; filename=\"q.jpg\"\r\n\r\n" + photo +
            b"\r\n--edge\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{}\r\n--edge--\r\n")


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
            with Connection(self.server.port) as connection:
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


# ---- hostile clients

def jpeg_claiming(width, height):
    return (b"\xff\xd8\xff\xc0\x00\x0b\x08" + struct.pack(">HH", height, width) + b"\x01\x01\x11\x00" +
            b"\xff\xda\x00\x08\x01\x01\x00\x00\x3f\x00" + b"\x00" * 64 + b"\xff\xd9")


def png_of_zeros(width, height):
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    rows = zlib.compress(b"\x00" * ((width + 1) * height), 9)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", rows) + chunk(b"IEND", b""))


class Hostile:
    """One attack after the other. What the server answers is counted; it may close at any time."""

    def __init__(self, server, name, photo, tally, end, seed):
        self.server, self.name, self.photo = server, name, photo
        self.tally, self.end, self.random = tally, end, random.Random(seed)
        self.localize = f"/v1/maps/{name}/localize"
        self.attacks = [getattr(self, attack) for attack in dir(self) if attack.startswith("attack_")]

    def __call__(self):
        attack = self.random.choice(self.attacks)
        self.tally.count("hostile_" + attack.__name__.removeprefix("attack_"))
        try:
            with Connection(self.server.port) as connection:
                attack(connection)
        except (OSError, ValueError, IndexError):
            self.tally.count("hostile_closed")
        time.sleep(0.02)

    def expect(self, connection):
        status, body = connection.read_answer()
        self.tally.count(f"hostile_status_{status}")
        if status == 500:
            self.tally.fail(f"a hostile request got 500: {body[:200]!r}")

    def post(self, connection, body, content_type="image/jpeg"):
        connection.send(request(connection.port, "POST", self.localize, body, content_type))
        self.expect(connection)

    def noise(self, most):
        return self.random.randbytes(self.random.randint(1, most))

    def attack_half_head(self, connection):
        connection.send(request(connection.port, "POST", self.localize)[:self.random.randint(1, 60)])
        if self.random.random() < 0.5:
            connection.socket.shutdown(socket.SHUT_WR)
            self.expect(connection)

    def attack_half_body(self, connection):
        whole = request(connection.port, "POST", self.localize, self.photo, "image/jpeg")
        connection.send(whole[:self.random.randint(100, len(whole) - 1)])

    def attack_noise(self, connection):
        connection.send(self.noise(3000) + b"\r\n\r\n")
        self.expect(connection)

    def attack_drip(self, connection):
        drops = request(connection.port, "POST", self.localize, b"x" * 100, "image/jpeg")
        for drop in drops:
            if self.end.is_set() or self.random.random() < 0.02:
                return
            connection.send(bytes([drop]))
            time.sleep(0.1)

    def attack_long_line(self, connection):
        connection.send(b"GET /" + b"a" * 200_000 + b" HTTP/1.1\r\n\r\n")
        self.expect(connection)

    def attack_many_headers(self, connection):
        connection.send(b"GET / HTTP/1.1\r\n" + b"".join(b"A%d: b\r\n" % i for i in range(5000)) + b"\r\n")
        self.expect(connection)

    def attack_long_body(self, connection):
        connection.send(f"POST {self.localize} HTTP/1.1\r\nHost: localhost:{connection.port}\r\n"
                        "Content-Length: 99999999999\r\n\r\n".encode())
        for _ in range(100):
            connection.send(b"x" * 65536)
        self.expect(connection)

    def attack_endless_chunks(self, connection):
        connection.send(f"POST {self.localize} HTTP/1.1\r\nHost: localhost:{connection.port}\r\n"
                        "Transfer-Encoding: chunked\r\n\r\n".encode())
        for _ in range(500):
            connection.send(b"10000\r\n" + b"x" * 65536 + b"\r\n")
        self.expect(connection)

    def attack_bad_chunks(self, connection):
        connection.send(f"POST {self.localize} HTTP/1.1\r\nHost: localhost:{connection.port}\r\n"
                        "Transfer-Encoding: chunked\r\n\r\n".encode() + self.noise(200) + b"\r\n\r\n")
        self.expect(connection)

    def attack_pipeline(self, connection):
        paths = ["/healthz", "/v1/maps", f"/v1/maps/{self.name}", "/nowhere", "/metrics"] * 6
        connection.send(b"".join(request(connection.port, "GET", path) for path in paths))
        for _ in paths:
            self.expect(connection)

    def attack_leave_during_answer(self, connection):
        self.random.choice([
            lambda: connection.send(request(connection.port, "POST", self.localize, self.photo, "image/jpeg")),
            lambda: connection.send(b"".join(
                request(connection.port, "GET", f"/v1/maps/{self.name}/keyframes/1/image") for _ in range(50)))])()
        if self.random.random() < 0.5:
            connection.socket.recv(100)
        # A reset instead of an orderly end.
        connection.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))

    def attack_wrong_json(self, connection):
        body = self.random.choice([
            b"{", b"[]", b'{"images":7}', b'{"images":[{"data":"!!!!"}]}', b"[" * 100_000,
            b'{"images":[{"data":"QUJD"}],"fov_deg":1e400}', b'{"images":[],"unknown":1}', self.noise(500)])
        self.post(connection, body, "application/json")

    def attack_wrong_form(self, connection):
        body = form_body(self.photo)
        at = self.random.randrange(len(body))
        self.post(connection, body[:at] + self.noise(20) + body[at + 20:], "multipart/form-data; boundary=edge")

    def attack_huge_header(self, connection):
        image = self.random.choice([jpeg_claiming(65535, 65535), jpeg_claiming(7000, 7000),
                                    png_of_zeros(2000, 2000), png_of_zeros(20_000, 4000)])
        self.post(connection, image)

    def attack_damaged_photo(self, connection):
        photo = bytearray(self.photo)
        for _ in range(self.random.randint(1, 20)):
            photo[self.random.randrange(len(photo))] = self.random.randrange(256)
        self.post(connection, bytes(photo[:self.random.randint(1, len(photo))]))

    def attack_foreign_names(self, connection):
        connection.send(b"POST /v1/localize HTTP/1.1\r\nHost: evil.example\r\nOrigin: http://evil.example\r\n"
                        b"Content-Length: 1\r\n\r\nx")
        self.expect(connection)

    def attack_idle_crowd(self, connection):
        with contextlib.ExitStack() as crowd:
            for _ in range(40):
                crowd.enter_context(Connection(connection.port))
            self.end.wait(self.random.uniform(0, 3))

    def attack_impatience(self, connection):
        connection.send(request(connection.port, "POST", self.localize + "?deadline_ms=1", self.photo, "image/jpeg"))
        self.expect(connection)


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
        deadline = time.monotonic() + PATIENCE_S
        while not self.end.is_set():
            if self.served_bytes(name) == source.read_bytes():
                self.tally.count("reloads")
                return
            if time.monotonic() > deadline:
                self.tally.fail(f"map {name} isn't served {PATIENCE_S} s after it was replaced")
                return
            time.sleep(0.1)

    def served_bytes(self, name):
        """The map file whose version is served; nothing where the server has no time."""
        with contextlib.suppress(OSError, ValueError, KeyError), Connection(self.server.port) as connection:
            version = json.loads(connection.ask("GET", f"/v1/maps/{name}")[1])["version"]
            return next((path.read_bytes() for path in self.maps if VERSIONS[path] == version), None)
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
            connection = open_ones.enter_context(Connection(server.port))
            connection.send(b"POST /v1/localize HTTP/1.1\r\nHost: localhost\r\n"[:5 + 4 * i])
        started = time.monotonic()
        server.process.send_signal(signal.SIGTERM)
        try:
            code = server.process.wait(4 * PATIENCE_S)
        except subprocess.TimeoutExpired:
            server.process.kill()
            code = "no end"
    took = time.monotonic() - started
    if code != 0:
        tally.fail(f"the server ended with {code}")
    if took > END_S:
        tally.fail(f"the server took {took:.1f} s to end")
    return took


def lower_quartile(values):
    return sorted(values)[len(values) // 4]


def check_growth(samples, quiet_before, quiet_after, tally):
    rss_first, rss_last = (lower_quartile(third) for third in samples.thirds(0))
    threads_first, threads_last = (max(third) for third in samples.thirds(1))
    bound = rss_first * (1 + GROWTH_SHARE) + GROWTH_MB
    if len(samples.rows) >= WARM_S and rss_last > bound:
        tally.fail(f"memory grew from {rss_first:.0f} to {rss_last:.0f} MB")
    if threads_last > threads_first:
        tally.fail(f"threads grew from {threads_first} to {threads_last}")
    if quiet_after > quiet_before:
        tally.fail(f"descriptors grew from {quiet_before} to {quiet_after}")
    return {"rss_mb": [round(rss_first, 1), round(rss_last, 1)], "rss_bound_mb": round(bound, 1),
            "rss_peak_mb": round(max(row[0] for row in samples.rows), 1),
            "threads": [threads_first, threads_last], "quiet_descriptors": [quiet_before, quiet_after]}


def soak(program, seconds, count, folder, served):
    maps, photos, answers = make_maps(program, folder, count)
    for path in maps:
        shutil.copy(path, served)
        VERSIONS[path] = json.loads(run(program, "info", path, "--json"))["version"]
    server, tally, clients = Server(program, served, folder / "server.log"), Tally(), Clients()
    try:
        return wear_out(server, tally, clients, seconds, maps, photos, answers, served)
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
    growth = check_growth(samples, quiet, wait_for_quiet(server, quiet), tally)
    took = stop(server, tally)
    if not tally.counts["honest_localized"] or not tally.counts["honest_not_in_map"] or not tally.counts["reloads"]:
        tally.fail("too little happened: no place found, none refused, or no map replaced")
    print(json.dumps({"seconds": len(samples.rows), **growth, "end_s": round(took, 2),
                      "honest_mean_ms": tally.counts.pop("honest_ms", 0) // max(1, tally.counts["honest_answers"]),
                      **dict(sorted(tally.counts.items()))}))
    for broken in tally.broken:
        print("broken:", broken)
    return 1 if tally.broken else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--maps", type=int, choices=(2, 3), default=3)
    parser.add_argument("--folder", type=Path)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="waystone-soak-") as temporary:
        folder = arguments.folder or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        served = Path(temporary) / "maps"
        served.mkdir()
        return soak(arguments.program, arguments.seconds, arguments.maps, folder, served)


if __name__ == "__main__":
    sys.exit(main())
