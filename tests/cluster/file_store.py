#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""file_store.py PORT FOLDER: a store of map files over HTTP on 127.0.0.1.

GET (with ranges), HEAD and PUT. While FOLDER/slow exists, files are sent at SLOW_BYTES_S. Each request
is a line of stdout: method, path, first byte.
"""
import os
import re
import sys
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

BLOCK = 1 << 18
SLOW_BLOCK = 4096
SLOW_BYTES_S = 100_000


class Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True
    folder = Path()

    def file(self):
        """The file of the path, or None where the path isn't one of a store."""
        found = re.fullmatch(r"/([0-9a-f]{2}/[0-9a-f]{64}\.db)", self.path)
        return self.folder / found[1] if found else None

    def answer(self, status, size=0, headers=()):
        self.send_response(status)
        self.send_header("Content-Length", str(size))
        for name, value in headers:
            self.send_header(name, value)
        self.end_headers()

    def do_HEAD(self):
        file = self.file()
        there = file is not None and file.exists()
        self.answer(200 if there else 404, file.stat().st_size if there else 0)

    def do_GET(self):
        file = self.file()
        if file is None or not file.exists():
            self.answer(404)
            return
        size = file.stat().st_size
        found = re.fullmatch(r"bytes=(\d+)-", self.headers.get("Range", ""))
        first = int(found[1]) if found else 0
        print("GET", self.path, first, flush=True)
        if first >= size:
            self.answer(416)
            return
        self.answer(206 if found else 200, size - first,
                    [("Content-Range", f"bytes {first}-{size - 1}/{size}")] if found else [])
        with file.open("rb") as source:
            source.seek(first)
            self.send(source)

    def send(self, source):
        while True:
            slow = (self.folder / "slow").exists()
            block = source.read(SLOW_BLOCK if slow else BLOCK)
            if not block:
                return
            self.wfile.write(block)
            if slow:
                time.sleep(SLOW_BLOCK / SLOW_BYTES_S)

    def do_PUT(self):
        file = self.file()
        body = self.rfile.read(int(self.headers["Content-Length"]))
        if file is None:
            self.answer(404)
            return
        file.parent.mkdir(exist_ok=True)
        part = file.with_suffix(f".{os.getpid()}-{id(body)}")
        part.write_bytes(body)
        os.replace(part, file)
        self.answer(201)

    def log_message(self, *_):
        pass


class Server(ThreadingHTTPServer):
    request_queue_size = 64
    daemon_threads = True


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    Handler.folder = Path(sys.argv[2])
    Server(("127.0.0.1", int(sys.argv[1])), Handler).serve_forever()
