# SPDX-License-Identifier: Apache-2.0
"""What honest and hostile clients of a soak send requests through."""
import socket

PATIENCE_S = 30  # for an answer, or for a new map


class Connection:
    """A socket that reads one answer after the other."""

    def __init__(self, port, patience_s=PATIENCE_S):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=patience_s)
        self.buffer = b""
        self.port = port

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
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


def form_body(photo):
    return (b"--edge\r\nContent-Disposition: form-data; name=\"image\"; filename=\"q.jpg\"\r\n\r\n" + photo +
            b"\r\n--edge\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{}\r\n--edge--\r\n")
