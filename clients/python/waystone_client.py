#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Asks a Waystone server where photos were taken. One file, Python 3.11, nothing but its library.

    from waystone_client import Client
    answer = Client("http://127.0.0.1:8080").localize("photo.jpg", map="lab")

`Client` blocks, `AsyncClient` is awaited; both may be shared by threads, as each request has a
connection of its own. Whatever fails raises `WaystoneError`; "not in this map" is an answer.
As a program: waystone-localize --help. The fields are those of clients/openapi.yaml.
"""
import argparse
import asyncio
import contextlib
import dataclasses
import email.utils
import http.client
import json
import os
import re
import secrets
import socket
import sys
import threading
import time
import urllib.parse
from collections.abc import AsyncIterator, Iterator, Sequence
from typing import Any, Literal, NoReturn, NotRequired, TypedDict

DEFAULT_SERVER = "http://127.0.0.1:8080"
READ_CHUNK = 1 << 16  # bytes
MAX_TIMEOUT_S = 1e6  # what timers take
MAX_ANSWER = 100 << 20  # bytes; a server doesn't send more
ANY_TEXT = "surrogatepass"  # the server doesn't know a name that isn't UTF-8
DEFAULT_RETRY_S = 1.0  # wait after a 429 that doesn't say how long


# ------------------------------------------------------------------------------ answers and errors


class WaystoneError(Exception):
    """What went wrong: the server's problem (RFC 9457), or that it couldn't be queried.

    `code` is the stable name of clients/openapi.yaml ("busy", "not_found", ...), "unreachable" or
    "timeout" when no answer came, "bad_answer" when it isn't one of Waystone's, "unreadable_photo"
    for a file. `status` is the HTTP status, or 0. `detail` is a line with cause and remedy.
    """

    def __init__(self, code: str, status: int, detail: str):
        super().__init__(f"{detail} ({code})")
        self.code = code
        self.status = status
        self.detail = detail


Verdict = Literal["localized", "ambiguous", "not_in_map", "bad_image", "undecided"]
Matrix = list[list[float]]


class Keyframe(TypedDict):
    """One image of the map."""

    id: int
    sequence: str
    source: str
    time_s: NotRequired[float | None]


class Heading(TypedDict):
    """Which way the camera looks. `of` is "keyframe", "building" or "layer"."""

    rad: float
    deviation_rad: float
    of: str


class Pose(TypedDict):
    """The camera in the frame of the poses that the map was built with: x right, y down, z forward.

    `orientation` is the quaternion x, y, z, w that turns its axes into the frame's; `covariance`
    that of x, y, z and of small rotations about the frame's axes; `unit` "metres" or "unknown"."""

    frame: str
    unit: str
    position: list[float]
    orientation: list[float]
    covariance: Matrix
    inliers: int
    camera: str


class Position(TypedDict):
    """In the frame and units of the map's panoramas; `deviation` along the worst direction."""

    x: float
    y: float
    deviation: float
    metres_per_unit: float | None


class PlanPosition(TypedDict):
    """On a floor plan of the map, in pixels of its image from the upper left corner."""

    name: str
    x: float
    y: float


class AnsweredPlace(TypedDict):
    """Where a localized photo was taken, whatever the layer: the nearest keyframe ("planes") or
    panorama ("appearance"), and the photo's position and heading where they are known."""

    layer: Literal["planes", "appearance"]
    id: int
    name: str | None  # given by people
    image: str
    sequence: str
    time_s: float | None
    position: Position | None
    heading: Heading | None
    plan: PlanPosition | None


class PlaneReference(TypedDict):
    """The keyframe in whose image a plane is described."""

    id: int
    source: str


class Plane(TypedDict):
    """A planar region in the photo: x_reference = reference_from_query x_query, homogeneous px."""

    id: int
    inliers: int
    reference: PlaneReference
    reference_from_query: Matrix
    outline: list[list[float]]
    expect_next: list[int]


class EpipolarMatches(TypedDict):
    """The photo's matches with one keyframe that fit one epipolar geometry."""

    keyframe: PlaneReference
    inliers: int
    matches: int


class Place(TypedDict):
    """A keyframe that the photo may be near."""

    keyframe: Keyframe
    probability: float
    inliers: int


class ShortAnswer(TypedDict):
    """The answer of one map or for one image, named by `map` or `image`."""

    map: NotRequired[str]
    image: NotRequired[str]
    verdict: Verdict
    probability: float
    place: AnsweredPlace | None
    keyframe: Keyframe | None
    inliers: int


class Answer(TypedDict):
    """The server's answer; docs/http-api.md says when the optional fields are there."""

    verdict: Verdict
    probability: float
    image: str
    map: str
    map_version: str
    place: AnsweredPlace | None
    keyframe: Keyframe | None
    heading: Heading | None
    planes: list[Plane]
    runner_up: dict[str, Any] | None
    decided_by: str
    timing_ms: dict[str, float]
    message: NotRequired[str]
    pose: NotRequired[Pose | None]
    pose_reason: NotRequired[str]
    building: NotRequired[dict[str, Any]]
    epipolar: NotRequired[EpipolarMatches]
    panorama: NotRequired[dict[str, Any]]
    belief: NotRequired[list[dict[str, Any]]]
    places: NotRequired[list[Place]]
    maps: NotRequired[list[ShortAnswer]]
    images: NotRequired[list[ShortAnswer]]
    candidates: NotRequired[list[Place]]
    explanation: NotRequired[dict[str, Any]]
    stage: NotRequired[str]
    camera: NotRequired[dict[str, Any]]
    unused: NotRequired[list[str]]
    searched: NotRequired[list[dict[str, Any]]]
    partial: NotRequired[bool]
    unindexed: NotRequired[int]


# --------------------------------------------------------------------------------- what is asked


@dataclasses.dataclass(frozen=True)
class Image:
    """An encoded image (JPEG, PNG, ...) and its name in the answer."""

    name: str
    data: bytes


Encoded = bytes | bytearray | memoryview
Photo = str | os.PathLike[str] | Encoded | Image  # a path, encoded bytes, or bytes with a name


@dataclasses.dataclass(frozen=True)
class Options:
    """What a request may say besides its images; None leaves a field out.

    The server checks the ranges and names the field at fault. The camera is given in one of three
    ways: fx, fy, cx and cy together, `fov_deg`, or `camera`. `camera`, `prior_keyframe`,
    `previous` and `odometry` refer to one map, `hints` narrow a query of all maps: `position`
    (`frame`, `x`, `y`, `z` if known, `radius`), `tags` and `previous_map`.
    """

    fx: float | None = None  # focal length, px
    fy: float | None = None  # focal length, px
    cx: float | None = None  # principal point, px
    cy: float | None = None  # principal point, px
    fov_deg: float | None = None  # horizontal field of view
    camera: str | None = None  # name of a sequence of the map whose camera took the image
    prior_keyframe: int | None = None  # where the caller believes it is
    previous: Answer | None = None  # the answer before this one
    # For each panorama the motion {"x", "y", "heading_rad"} since the one before it, or None.
    odometry: Sequence[dict[str, float] | None] | None = None
    hints: dict[str, Any] | None = None
    top_k: int | None = None  # 1 to 50: list that many candidates
    debug: bool = False  # include the explanation: what became of every plane
    deadline_ms: int | None = None  # 1 to 60000: after this the answer is of no use

    def to_json(self) -> dict[str, Any]:
        """The object that goes with the images."""
        fields = {
            field.name: getattr(self, field.name)
            for field in dataclasses.fields(self)
            if field.name not in ("prior_keyframe", "previous", "debug")
        }
        fields["prior"] = _prior_to_json(self.prior_keyframe)
        fields["previous"] = _previous_to_json(self.previous) if self.previous else None
        fields["debug"] = True if self.debug else None
        return {name: value for name, value in fields.items() if value is not None}


def _prior_to_json(keyframe: int | None) -> dict[str, int] | None:
    return None if keyframe is None else {"keyframe": keyframe}


def _previous_to_json(answer: Answer) -> dict[str, Any] | None:
    fields: dict[str, Any] = {}
    if keyframe := answer["keyframe"]:
        fields["keyframe"] = keyframe["id"]
    if heading := answer["heading"]:
        fields["heading_rad"] = heading["rad"]
    if belief := answer.get("belief"):
        fields["belief"] = belief
        fields["map_version"] = answer["map_version"]
    return fields or None


def _image_of(photo: Photo, number: int) -> Image:
    if isinstance(photo, Image):
        return photo
    if isinstance(photo, Encoded):
        return Image(f"image-{number}", bytes(photo))
    if not isinstance(photo, str | os.PathLike):
        kind = type(photo).__name__
        raise TypeError(f"photo {number} is of type {kind}; expected a path, bytes or an Image")
    try:
        with open(photo, "rb") as file:
            return Image(os.fspath(photo), file.read())
    except (OSError, ValueError) as error:  # a path with a NUL is a ValueError
        why = error.strerror if isinstance(error, OSError) else error
        detail = f"{os.fspath(photo)}: {why}; check the path and its permissions"
        raise WaystoneError("unreadable_photo", 0, detail) from error


def _form_of(images: Sequence[Image], options: Options) -> tuple[bytes, str]:
    """The body of multipart/form-data (RFC 7578) and its Content-Type."""
    boundary = secrets.token_hex(16)
    pieces: list[bytes] = []

    def add(disposition: str, data: bytes) -> None:
        head = f"--{boundary}\r\nContent-Disposition: form-data; {disposition}\r\n\r\n"
        pieces.extend((head.encode("utf-8", "replace"), data, b"\r\n"))

    for image in images:
        add(f'name="image"; filename="{_quotable(image.name)}"', image.data)
    add('name="request"', json.dumps(options.to_json()).encode())
    pieces.append(f"--{boundary}--\r\n".encode())
    return b"".join(pieces), f"multipart/form-data; boundary={boundary}"


def _quotable(name: str) -> str:
    """A name for a quoted string: without what would end its line, and escaped."""
    printable = "".join(letter if letter.isprintable() else "_" for letter in name)
    return printable.replace("\\", "\\\\").replace('"', '\\"')


# -------------------------------------------------------------------------------------- the clients


class Client:
    """A server at `url`, queried with a bearer `token` where it requires one.

    A call takes at most `timeout_s`, including its retries and their waits. A busy server (429) is
    asked again up to `retries` times, each after the time in its Retry-After; if that doesn't fit
    into `timeout_s`, the error is raised at once. Redirects aren't followed, so that a token isn't
    sent elsewhere.
    """

    def __init__(
        self,
        url: str = DEFAULT_SERVER,
        *,
        token: str | None = None,
        timeout_s: float = 30.0,
        retries: int = 3,
    ):
        parts = urllib.parse.urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise ValueError(f"{url!r} is no server; it looks like {DEFAULT_SERVER}")
        if parts.port == 0:
            raise ValueError(f"{url!r} has port 0; expected a port from 1 to 65535")
        if token is not None and not (token.isascii() and token.isprintable() and token.strip()):
            raise ValueError("the token has characters that can't be sent; it must be printable ASCII")
        if not 0 < timeout_s < MAX_TIMEOUT_S or retries < 0:
            most = f"{MAX_TIMEOUT_S:.0f}"
            raise ValueError(f"timeout_s is above 0 and below {most}, and retries 0 or more")
        self._secure = parts.scheme == "https"
        self._host, self._root = parts.hostname, _quoted(parts.path.rstrip("/"))
        # http.client would look for a port in an IPv6 address.
        self._port = parts.port or (443 if self._secure else 80)
        self._token = token
        self._timeout_s = timeout_s
        self._retries = retries

    def localize(
        self,
        photos: Photo | Sequence[Photo],
        *,
        map: str | None = None,  # named as the API names it
        options: Options = Options(),
    ) -> Answer:
        """Where `photos` were taken: one, or a rig's, or a series in order; the surest answers.

        Asks the map of this name, or all of them. Every verdict is an answer.
        """
        listed: Sequence[Photo]
        listed = [photos] if isinstance(photos, str | os.PathLike | Encoded | Image) else photos
        images = [_image_of(photo, number) for number, photo in enumerate(listed, start=1)]
        body, media = _form_of(images, options)
        path = "/v1/localize" if map is None else f"/v1/maps/{_segment(map)}/localize"
        answer: Answer = self._ask("POST", path, body, {"Content-Type": media})
        if not isinstance(answer.get("verdict"), str):
            raise _not_ours(200)
        return answer

    def get(self, path: str, **query: str | int) -> Any:
        """The JSON at a path of the API: get("/v1/maps/lab/graph"), get("/version")."""
        query_text = "?" + urllib.parse.urlencode(query, errors=ANY_TEXT) if query else ""
        return self._ask("GET", _quoted(path) + query_text)

    def rows(self, path: str, *, limit: int = 100) -> Iterator[dict[str, Any]]:
        """All rows of a list, page after page: rows("/v1/maps/lab/planes")."""
        query: dict[str, str | int] | None = {"limit": limit}
        while query:
            rows, query = _rows_of(self.get(path, **query), limit)
            yield from rows

    def maps(self) -> list[dict[str, Any]]:
        """The maps that are served, with their numbers."""
        return list(self.rows("/v1/maps"))

    def _ask(self, method: str, path: str, body: bytes | None = None,
             headers: dict[str, str] | None = None) -> Any:  # fmt: skip
        end = time.monotonic() + self._timeout_s
        # A connection kept open would occupy one of the server's.
        headers = {"Accept": "application/json", "Connection": "close", **(headers or {})}
        if self._token is not None:
            headers["Authorization"] = "Bearer " + self._token
        for attempt in range(self._retries + 1):
            status, fields, data = self._exchange(method, self._root + path, body, headers, end)
            if status != 429 or attempt == self._retries:
                break
            wait_s = _retry_after_s(fields.get("Retry-After"))
            if time.monotonic() + wait_s >= end:
                break
            time.sleep(wait_s)
        return _parsed(status, data)

    def _exchange(self, method: str, path: str, body: bytes | None, headers: dict[str, str],
                  end: float) -> tuple[int, http.client.HTTPMessage, bytes]:  # fmt: skip
        kind = http.client.HTTPSConnection if self._secure else http.client.HTTPConnection
        with contextlib.ExitStack() as ended:
            try:
                connection = kind(self._host, self._port, timeout=_left_s(end))
                ended.callback(connection.close)
                connection.connect()
                wire = connection.sock
                # This timeout is for each piece: a slow sender could take longer in all.
                wire.settimeout(_left_s(end))
                cutter = threading.Timer(_left_s(end), _cut, [wire])
                cutter.daemon = True
                cutter.start()
                ended.callback(cutter.cancel)
                try:
                    connection.request(method, path, body=body, headers=headers)
                except (BrokenPipeError, ConnectionResetError):
                    pass  # it may have answered without reading everything, as with 413
                response = connection.getresponse()
                data = _read(response, wire, end)
                _left_s(end)  # what was cut off may look complete
                return response.status, response.headers, data
            except (OSError, UnicodeError, http.client.HTTPException) as error:
                if isinstance(error, TimeoutError) or time.monotonic() >= end:
                    raise self._too_late() from error
                raise self._unreachable(error) from error

    def _unreachable(self, error: Exception) -> WaystoneError:
        host = f"[{self._host}]" if ":" in self._host else self._host
        why = str(error) or type(error).__name__
        detail = f"no answer from {host}:{self._port}: {why}; is the server running?"
        return WaystoneError("unreachable", 0, detail)

    def _too_late(self) -> WaystoneError:
        detail = f"no answer from {self._host} within {self._timeout_s:g} s; increase the timeout"
        return WaystoneError("timeout", 0, detail)


class AsyncClient:
    """`Client` for asyncio: its calls run in threads of the loop's executor.

    A cancelled call's thread goes on until the server answers or the call's timeout is over.
    """

    def __init__(self, url: str = DEFAULT_SERVER, *, token: str | None = None,
                 timeout_s: float = 30.0, retries: int = 3):  # fmt: skip
        self._client = Client(url, token=token, timeout_s=timeout_s, retries=retries)

    async def localize(
        self,
        photos: Photo | Sequence[Photo],
        *,
        map: str | None = None,
        options: Options = Options(),
    ) -> Answer:
        """As Client.localize."""
        return await asyncio.to_thread(self._client.localize, photos, map=map, options=options)

    async def get(self, path: str, **query: str | int) -> Any:
        """As Client.get."""
        return await asyncio.to_thread(self._client.get, path, **query)

    async def rows(self, path: str, *, limit: int = 100) -> AsyncIterator[dict[str, Any]]:
        """As Client.rows: async for row in client.rows("/v1/maps/lab/planes")."""
        query: dict[str, str | int] | None = {"limit": limit}
        while query:
            rows, query = _rows_of(await self.get(path, **query), limit)
            for row in rows:
                yield row

    async def maps(self) -> list[dict[str, Any]]:
        """As Client.maps."""
        return await asyncio.to_thread(self._client.maps)


def read_token_file(path: str | os.PathLike[str]) -> str:
    """The first token of a file as `waystone serve --token-file` reads it: one token per line.

    Blank lines and lines that begin with # are skipped. Raises ValueError."""
    try:
        with open(path, encoding="utf-8") as file:
            lines = [line.strip() for line in file]
    except (OSError, ValueError) as error:
        raise ValueError(f"the token file {path} can't be read: {error}") from error
    for line in lines:
        if line and not line.startswith("#"):
            return line
    raise ValueError(f"the token file {path} has no token; expected one per line")


def _cut(wire: socket.socket) -> None:
    """Ends whatever waits for a connection. Below TLS, whose state the waiting thread uses."""
    with contextlib.suppress(OSError):
        socket.socket.shutdown(wire, socket.SHUT_RDWR)


def _read(response: http.client.HTTPResponse, wire: socket.socket, end: float) -> bytes:
    """The body, piece by piece, as a server that sends slowly mustn't outlive `end`."""
    length = response.length  # None when it comes in chunks
    data = bytearray()
    while length is None or len(data) < length:
        wire.settimeout(_left_s(end))
        piece = response.read1(READ_CHUNK)
        if not piece:
            break
        data += piece
        if len(data) > MAX_ANSWER:
            detail = f"the response has more than {MAX_ANSWER} bytes; check the server's address"
            raise WaystoneError("bad_answer", response.status, detail)
    if length is not None and len(data) < length:
        raise http.client.IncompleteRead(bytes(data), length - len(data))
    return bytes(data)


def _segment(name: str) -> str:
    return urllib.parse.quote(name, safe="", errors=ANY_TEXT)


def _quoted(path: str) -> str:
    """A path, maybe with a query, in the letters of HTTP; what is quoted already stays."""
    return urllib.parse.quote(path, safe="/%?&=:;@!$'()*+,~", errors=ANY_TEXT)


def _left_s(end: float) -> float:
    left = end - time.monotonic()
    if left <= 0:
        raise TimeoutError
    return left


def _retry_after_s(value: str | None) -> float:
    """Seconds of a Retry-After field: a number, or a date (RFC 9110, 10.2.3)."""
    if value is None:
        return DEFAULT_RETRY_S
    if value.strip().isdecimal():
        return float(value)
    try:
        return max(0.0, email.utils.parsedate_to_datetime(value).timestamp() - time.time())
    except ValueError:
        return DEFAULT_RETRY_S


def _rows_of(
    page: dict[str, Any], limit: int
) -> tuple[list[dict[str, Any]], dict[str, str | int] | None]:
    """The rows of a list's page, and the query of the next one."""
    lists = [value for value in page.values() if isinstance(value, list)]
    if len(lists) != 1 or not isinstance(page.get("next", ...), str | int | None):
        raise _not_ours(200)
    return lists[0], None if page["next"] is None else {"limit": limit, "cursor": page["next"]}


def _parsed(status: int, data: bytes) -> dict[str, Any]:
    try:
        value = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise _not_ours(status) from error
    if not isinstance(value, dict):  # every JSON of the contract is one
        raise _not_ours(status)
    if status == 200:
        return value
    if not {"code", "detail"} <= value.keys():
        raise _not_ours(status)
    raise WaystoneError(str(value["code"]), status, str(value["detail"]))


def _not_ours(status: int) -> WaystoneError:
    detail = f"status {status} without JSON of Waystone; check the address of the server"
    return WaystoneError("bad_answer", status, detail)


# -------------------------------------------------------------------------------------- the program


# Characters that control a terminal, those of core/base/text.h, and surrogates, which can't be printed.
_CONTROLS = re.compile(
    "[\0-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)


def _printable(text: object) -> str:
    """One line, safe to print to a terminal: such characters as \\u001b, which JSON reads, too."""
    return _CONTROLS.sub(lambda found: f"\\u{ord(found[0]):04x}", str(text))


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        super().error(_printable(message))


def _arguments() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="waystone-localize",
        description="Localize images with a Waystone server.",
        epilog="Exit status: 0 if all images were answered, 2 for usage errors, 3 if an image can't "
        "be read or the server can't be reached. "
        "Example: waystone-localize --map lab photo.jpg --json",
    )
    add = parser.add_argument
    add("photos", nargs="+", help="image files")
    add("--server", default=DEFAULT_SERVER, metavar="URL", help="default: %(default)s")
    add("--map", metavar="NAME", help="query this map instead of all")
    add("--token-file", metavar="FILE", help="file with the token; default: $WAYSTONE_TOKEN")
    add("--together", action="store_true", help="send all images as one query: a rig, or a series")
    add("--timeout", type=float, default=30.0, metavar="S", help="timeout per image in seconds (%(default)s)")
    add("--retries", type=int, default=3, metavar="N", help="retries if the server is busy (%(default)s)")
    add("--json", action="store_true", help="print one JSON object per answer")
    for name in ("fx", "fy", "cx", "cy"):
        add("--" + name, type=float, metavar="PX", help="camera intrinsics; all four are required")
    add("--fov-deg", type=float, metavar="DEG", help="horizontal field of view in degrees")
    add("--camera", metavar="NAME", help="use the camera of this sequence of the map")
    add("--prior-keyframe", type=int, metavar="ID", help="keyframe assumed to be near")
    add("--top-k", type=int, metavar="N", help="number of candidates to list")
    add("--debug", action="store_true", help="include the outcome of every candidate plane")
    add("--deadline-ms", type=int, metavar="MS", help="deadline in milliseconds")
    return parser


def _token(path: str | None) -> str | None:
    if path is None:
        return os.environ.get("WAYSTONE_TOKEN") or None
    return read_token_file(path)


def _line(answer: Answer) -> str:
    """ "q.jpg: localized in lab near rgb/000120.jpg (plane 3, 143 inliers, 69 ms)" """
    try:
        return _summary(answer)
    except (AttributeError, LookupError, TypeError, ValueError) as error:
        raise _not_ours(200) from error


def _summary(answer: Answer) -> str:
    line = f"{answer['image']}: {answer['verdict']}"
    facts = [f"{answer['timing_ms']['total']:.0f} ms"]
    if answer["verdict"] == "localized":
        line += f" in {answer['map']}"
        if place := answer["place"]:
            if place.get("name"):
                line += f" in {place['name']}"
            line += f" near {place['image']}"
            if plan := place.get("plan"):
                line += f", at ({plan['x']:.0f}, {plan['y']:.0f}) of the plan {plan['name']}"
        if planes := answer["planes"]:
            facts = [f"plane {planes[0]['id']}", f"{planes[0]['inliers']} inliers"] + facts
    elif message := answer.get("message"):
        line += f": {message}"
    return f"{line} ({', '.join(facts)})"


def main(arguments: Sequence[str] | None = None) -> int:
    """The program waystone-localize. Returns its exit code."""
    flags = _arguments().parse_args(arguments)
    without_flag = ("previous", "odometry", "hints")
    names = [
        field.name for field in dataclasses.fields(Options) if field.name not in without_flag
    ]
    options = Options(**{name: getattr(flags, name) for name in names})
    try:
        client = Client(flags.server, token=_token(flags.token_file), timeout_s=flags.timeout,
                        retries=flags.retries)  # fmt: skip
    except ValueError as error:
        print(f"waystone-localize: {_printable(error)}", file=sys.stderr)
        return 2
    code = 0
    for photos in [flags.photos] if flags.together else [[photo] for photo in flags.photos]:
        try:
            answer = client.localize(photos, map=flags.map, options=options)
            line = json.dumps(answer) if flags.json else _line(answer)
        except WaystoneError as error:
            print(f"waystone-localize: {_printable(error)}", file=sys.stderr)
            code = 3
            continue
        print(_printable(line), flush=True)
        if answer["verdict"] == "bad_image":
            code = 3
    return code


if __name__ == "__main__":
    sys.exit(main())
