# SPDX-License-Identifier: Apache-2.0
"""The hostile clients of a soak."""
import contextlib
import random
import socket
import struct
import time
import zlib

from connection import form_body, request


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
            with self.server.connect() as connection:
                attack(connection)
        except OSError:
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
                crowd.enter_context(self.server.connect())
            self.end.wait(self.random.uniform(0, 3))

    def attack_impatience(self, connection):
        connection.send(request(connection.port, "POST", self.localize + "?deadline_ms=1", self.photo, "image/jpeg"))
        self.expect(connection)
