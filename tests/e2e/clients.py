#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""clients.py PROGRAM MAP INSIDE ELSEWHERE: the Python client and the ROS node with live servers.

Starts `PROGRAM serve MAP` with and without tokens. INSIDE is a photo of the map, ELSEWHERE isn't.
What a Waystone server can't be brought to do at will (429 once, silence, others' pages) comes from
a server of the test's own. The READMEs' examples are run as they stand, but for the address.
"""
import asyncio
import contextlib
import email.utils
import http.server
import io
import json
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import threading
import time
import types
import unittest
from unittest import mock

ROOT = pathlib.Path(__file__).resolve().parents[2]
PYTHON = ROOT / "clients/python"
ROS2 = ROOT / "clients/ros2"
JS = ROOT / "clients/js"
CPP = ROOT / "clients/cpp"
sys.path[:0] = [str(PYTHON), str(ROS2)]
sys.dont_write_bytecode = True

import waystone_client  # noqa: E402
from waystone_client import AsyncClient, Client, Image, Options, WaystoneError  # noqa: E402

PROGRAM, MAP, INSIDE, ELSEWHERE = sys.argv[1:5]
NAME = pathlib.Path(MAP).stem
TOKEN = "an-entirely-secret-token"
# A server that starts, or a query on a machine that is busy.
PATIENCE_S = 60
TRICKLE_S = 0.1


def start(*flags):
    """A server of the map, and its address."""
    command = [PROGRAM, "serve", MAP, "--port", "0", *flags]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    line = process.stdout.readline()
    return process, re.search(r"http://[\d.:]+", line)[0]


def stop(process):
    process.terminate()
    process.wait(PATIENCE_S)
    process.stdout.close()


def setUpModule():
    global folder, url, guarded_url, token_file
    folder = pathlib.Path(tempfile.mkdtemp(prefix="waystone-clients-"))
    unittest.addModuleCleanup(shutil.rmtree, folder)
    token_file = folder / "tokens"
    token_file.write_text(TOKEN + "\n")
    shutil.copy(INSIDE, folder / "photo.jpg")
    process, url = start()
    unittest.addModuleCleanup(stop, process)
    process, guarded_url = start("--token-file", str(token_file))
    unittest.addModuleCleanup(stop, process)


@contextlib.contextmanager
def scripted(*responses):
    """A server that answers requests with these (status, headers, body), or with silence for None.
    A body that is a list goes out piece by piece, TRICKLE_S apart; so does a list instead of a
    response, from its first line on.

    Yields its address and the requests as they came: (path, headers, body).
    """
    left = list(responses)
    requests = []
    over = threading.Event()

    class Handler(http.server.BaseHTTPRequestHandler):
        def log_message(self, *_):
            pass

        def do_POST(self):
            body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
            requests.append((self.path, self.headers, body))
            response = left.pop(0)
            if response is None:
                over.wait(PATIENCE_S)
                return
            if isinstance(response, list):
                body = response
            else:
                status, headers, body = response
                self.send_response(status)
                for name, value in headers.items():
                    self.send_header(name, value)
                self.end_headers()
            with contextlib.suppress(OSError):  # the client may be gone
                for piece in body if isinstance(body, list) else [body]:
                    self.wfile.write(piece)
                    if over.wait(TRICKLE_S if isinstance(body, list) else 0):
                        return

        do_GET = do_POST

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever, args=(0.01,))
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}", requests
    finally:
        over.set()
        server.shutdown()
        thread.join()
        server.server_close()


def commented_token_file():
    """The servers' token in a file as they read it, too."""
    path = folder / "commented"
    path.write_bytes(b"# of the robots\r\n\r\n" + TOKEN.encode() + b"\r\nanother-secret-token\n")
    return path


def problem(code, status):
    return json.dumps({"type": "urn:waystone:problem:" + code, "title": code, "status": status,
                       "detail": "cause; remedy", "code": code}).encode()


BUSY = (429, {"Retry-After": "1"}, problem("busy", 429))
ANSWER = {"verdict": "undecided", "image": "-", "timing_ms": {"total": 1.0}}
FINE = (200, {}, json.dumps(ANSWER).encode())


class Case(unittest.TestCase):
    @contextlib.contextmanager
    def fails(self, code, status):
        with self.assertRaises(WaystoneError) as context:
            yield context
        self.assertEqual((context.exception.code, context.exception.status), (code, status))
        self.assertTrue(context.exception.detail)
        self.assertNotIn("\n", str(context.exception))


class LiveTest(Case):
    def setUp(self):
        self.client = Client(url, timeout_s=PATIENCE_S)

    def test_one_map_and_all_maps(self):
        one = self.client.localize(INSIDE, map=NAME)
        self.assertEqual((one["verdict"], one["map"], one["image"]), ("localized", NAME, INSIDE))
        every = self.client.localize(pathlib.Path(INSIDE))
        self.assertEqual(every["planes"], one["planes"])
        self.assertEqual(every["maps"][0]["map"], NAME)

    def test_not_in_map_and_bad_image_are_answers(self):
        self.assertEqual(self.client.localize(ELSEWHERE, map=NAME)["verdict"], "not_in_map")
        self.assertEqual(self.client.localize(b"no image", map=NAME)["verdict"], "bad_image")

    def test_several_images_in_their_order(self):
        photo = pathlib.Path(INSIDE).read_bytes()
        answer = self.client.localize([ELSEWHERE, photo, Image("c", b"x")], map=NAME)
        self.assertEqual([one["image"] for one in answer["images"]], [ELSEWHERE, "image-2", "c"])
        self.assertEqual([one["verdict"] for one in answer["images"]],
                         ["not_in_map", "localized", "bad_image"])
        self.assertEqual(answer["image"], "image-2")

    def test_names_of_images_come_back(self):
        photo = pathlib.Path(INSIDE).read_bytes()
        for name in ('a "b" \\ c.jpg', "küche/ü.jpg", "; name=x", "日本"):
            self.assertEqual(self.client.localize(Image(name, photo))["image"], name)
        split = self.client.localize(Image("a\r\nX-Evil: 1\r\n\r\nb", photo))
        self.assertEqual(split["image"], "a__X-Evil: 1____b")

    def test_every_option_reaches_the_server(self):
        first = self.client.localize(INSIDE, map=NAME)
        answer = self.client.localize(INSIDE, map=NAME, options=Options(
            fx=500, fy=500, cx=320, cy=240, prior_keyframe=1, previous=first, top_k=2, debug=True,
            deadline_ms=60_000))  # fmt: skip
        self.assertEqual(answer["camera"]["params"][:4], [500, 500, 320, 240])
        self.assertEqual(answer["unused"], ["camera", "prior", "previous"])
        self.assertTrue(answer["explanation"]["candidates"][0]["points"])
        self.assertIn(len(answer["candidates"]), (1, 2))
        self.assertEqual(answer["stage"], "decide")
        wide = self.client.localize(INSIDE, map=NAME, options=Options(fov_deg=63))
        self.assertEqual(wide["camera"]["source"], "fov")

    def test_options_are_the_contracts_fields(self):
        contract = self.client.get("/openapi.json")
        fields = set(contract["components"]["schemas"]["Request"]["properties"])
        ours = {name.replace("prior_keyframe", "prior") for name in Options.__dataclass_fields__}
        self.assertEqual(ours, fields)

    def test_answers_are_typed_as_the_contract_says(self):
        schemas = self.client.get("/openapi.json")["components"]["schemas"]
        for ours, theirs in (("Answer", "Answer"), ("Plane", "RecognisedPlane"),
                             ("EpipolarMatches", "EpipolarMatches"),
                             ("Place", "Place"), ("ShortAnswer", "ShortAnswer"),
                             ("AnsweredPlace", "AnsweredPlace"), ("Position", "PlacePosition"),
                             ("Heading", "Heading"), ("Keyframe", "KeyframeRef")):  # fmt: skip
            typed = getattr(waystone_client, ours)
            self.assertEqual(set(typed.__annotations__), set(schemas[theirs]["properties"]), ours)
            self.assertEqual(typed.__required_keys__, set(schemas[theirs]["required"]), ours)
        self.assertEqual(list(waystone_client.Verdict.__args__), schemas["Verdict"]["enum"])

    def test_problems_become_one_exception(self):
        with self.fails("not_found", 404):
            self.client.localize(INSIDE, map="no/where?")
        with self.fails("bad_request", 400) as context:
            self.client.localize(INSIDE, map=NAME, options=Options(top_k=0))
        self.assertIn("top_k", context.exception.detail)
        with self.fails("bad_camera", 422):
            self.client.localize(INSIDE, map=NAME, options=Options(camera="none"))
        with self.fails("bad_request", 400):
            self.client.localize([], map=NAME)
        with self.fails("bad_request", 400):
            self.client.localize(INSIDE, map=NAME, options=Options(fov_deg=float("nan")))
        with self.fails("unreadable_photo", 0):
            self.client.localize(str(folder / "none.jpg"))

    def test_names_that_no_map_has(self):
        for name in ("..", ".", "\udcff", "\ud800", "%2e%2e"):
            with self.fails("not_found", 404):
                self.client.localize(INSIDE, map=name)
        with self.fails("not_found", 404):
            self.client.get("/v1/maps/\udcff")
        with self.fails("bad_request", 400):
            self.client.get("/v1/maps", cursor="\udcff")

    def test_a_body_over_the_limit_is_the_servers_problem(self):
        with self.fails("payload_too_large", 413):
            self.client.localize(bytes(21 << 20), map=NAME)

    def test_lists_page_by_page(self):
        self.assertEqual([row["name"] for row in self.client.maps()], [NAME])
        path = f"/v1/maps/{NAME}/keyframes"
        ids = [row["id"] for row in self.client.rows(path, limit=2)]
        self.assertGreater(len(ids), 2)
        self.assertEqual(ids, [row["id"] for row in self.client.rows(path)])

    def test_async_asks_at_the_same_time(self):
        async def ask():
            client = AsyncClient(url, timeout_s=PATIENCE_S)
            photos = (client.localize(photo, map=NAME) for photo in (INSIDE, ELSEWHERE))
            return await asyncio.gather(*photos, client.maps(), client.get("/version"))

        inside, elsewhere, maps, version = asyncio.run(ask())
        self.assertEqual((inside["verdict"], elsewhere["verdict"]), ("localized", "not_in_map"))
        self.assertEqual(maps[0]["name"], NAME)
        self.assertIn("schema", version)

    def test_async_lists_page_by_page(self):
        async def ids(limit):
            rows = AsyncClient(url, timeout_s=PATIENCE_S).rows(path, limit=limit)
            return [row["id"] async for row in rows]

        path = f"/v1/maps/{NAME}/keyframes"
        wanted = [row["id"] for row in self.client.rows(path)]
        self.assertEqual(asyncio.run(ids(2)), wanted)
        self.assertEqual(asyncio.run(ids(100)), wanted)

    def test_tokens(self):
        self.assertEqual(Client(guarded_url, token=TOKEN).maps()[0]["name"], NAME)
        for token in (None, TOKEN + "x"):
            with self.fails("unauthorized", 401):
                Client(guarded_url, token=token).maps()
        for token in ("", " ", "a\r\nb", "ü"):
            with self.assertRaisesRegex(ValueError, "token"):
                Client(url, token=token)


class ScriptedTest(Case):
    def test_busy_is_asked_again_after_retry_after(self):
        with scripted(BUSY, (429, {"Retry-After": "0"}, b""), FINE) as (address, requests):
            before = time.monotonic()
            self.assertEqual(Client(address).localize(b"photo"), ANSWER)
            self.assertGreaterEqual(time.monotonic() - before, 1)
        self.assertEqual(len(requests), 3)
        self.assertEqual(len({body for _, _, body in requests}), 1)

    def test_busy_for_good_is_the_servers_problem(self):
        none_left = (429, {"Retry-After": "0"}, problem("busy", 429))
        with scripted(*[none_left] * 3) as (address, requests):
            with self.fails("busy", 429):
                Client(address, retries=2).maps()
        self.assertEqual(len(requests), 3)

    def test_a_wait_beyond_the_timeout_is_not_begun(self):
        later = (429, {"Retry-After": "3600"}, problem("busy", 429))
        with scripted(later) as (address, _):
            before = time.monotonic()
            with self.fails("busy", 429):
                Client(address).maps()
            self.assertLess(time.monotonic() - before, 20)

    def test_retry_after_is_a_number_or_a_date_or_nonsense(self):
        seconds = waystone_client._retry_after_s
        self.assertEqual(seconds("7"), 7)
        date = email.utils.format_datetime(
            email.utils.datetime.datetime.now(email.utils.datetime.timezone.utc)
            + email.utils.datetime.timedelta(seconds=50), usegmt=True)  # fmt: skip
        self.assertAlmostEqual(seconds(date), 50, delta=5)
        self.assertEqual(seconds("Thu, 01 Jan 1970 00:00:00 GMT"), 0)
        for nonsense in (None, "", "soon", "-3", "1.5"):
            self.assertEqual(seconds(nonsense), waystone_client.DEFAULT_RETRY_S)

    def test_silence_ends_with_the_timeout(self):
        with scripted(None) as (address, _):
            with self.fails("timeout", 0):
                Client(address, timeout_s=0.3).maps()

    def test_a_trickle_ends_with_the_timeout(self):
        for headers in ({}, {"Content-Length": "600"}):
            with scripted((200, headers, [b" "] * 600)) as (address, _):
                before = time.monotonic()
                with self.fails("timeout", 0):
                    Client(address, timeout_s=0.5).maps()
                self.assertLess(time.monotonic() - before, 600 * TRICKLE_S / 2)

    def test_a_trickle_of_headers_ends_with_the_timeout(self):
        for start in (b"HT", b"HTTP/1.1 200 OK\r\n", b"HTTP/1.1 200 OK\r\nContent-Length: 2\r\nX-Slow: "):
            with scripted([start] + [b"x"] * 600) as (address, _):
                before = time.monotonic()
                with self.fails("timeout", 0):
                    Client(address, timeout_s=0.5).maps()
                self.assertLess(time.monotonic() - before, 600 * TRICKLE_S / 2)

    def test_no_timer_outlives_a_call(self):
        with scripted(FINE) as (address, _):
            Client(address).localize(b"x")
        self.assertFalse([one for one in threading.enumerate() if isinstance(one, threading.Timer)
                          and not one.finished.is_set()])  # fmt: skip

    def test_timeouts_and_retries_have_bounds(self):
        for wrong in (0, -1, float("nan"), float("inf"), 1e6, 1e300):
            with self.assertRaisesRegex(ValueError, "timeout_s"):
                Client(timeout_s=wrong)
        with self.assertRaisesRegex(ValueError, "retries"):
            Client(retries=-1)
        Client(timeout_s=999_999)

    def test_addresses_of_ipv6_and_ports_that_are_left_out(self):
        for address, wanted in (("http://[2001:db8::5]", ("2001:db8::5", 80)),
                                ("https://[fd00::abcd]/waystone", ("fd00::abcd", 443)),
                                ("http://[::1]:8080", ("::1", 8080)), ("https://maps", ("maps", 443))):
            with mock.patch("socket.create_connection", side_effect=OSError("no way")) as connect:
                with self.fails("unreachable", 0):
                    Client(address).maps()
            self.assertEqual(connect.call_args.args[0], wanted)

    def test_paths_may_have_any_letters(self):
        pages = [(200, {}, json.dumps({"planes": [], "next": None}).encode())] * 2
        with scripted((200, {}, b"{}"), (200, {}, b"{}"), *pages) as (address, requests):
            client = Client(address + "/my robot")
            client.get("/v1/maps/büro")
            client.get("/v1/maps/a%20b c/graph?format=json")
            self.assertEqual(list(client.rows("/v1/maps/a b/planes")), [])
        self.assertEqual([path for path, _, _ in requests], [
            "/my%20robot/v1/maps/b%C3%BCro", "/my%20robot/v1/maps/a%20b%20c/graph?format=json",
            "/my%20robot/v1/maps/a%20b/planes?limit=100"])

    def test_photos_are_paths_or_bytes(self):
        for photo in (bytearray(b"photo"), memoryview(b"photo"), [memoryview(b"photo")]):
            with scripted(FINE) as (address, requests):
                Client(address).localize(photo)
            self.assertIn(b'filename="image-1"\r\n\r\nphoto\r\n', requests[0][2])
        for wrong in ([0], [None], [b"photo", 1.5]):
            with self.assertRaisesRegex(TypeError, f"photo {len(wrong)} .*expected a path"):
                Client().localize(wrong)
        with self.fails("unreadable_photo", 0):
            Client().localize("a\0b")

    def test_nobody_there(self):
        with scripted() as (address, _):
            pass
        for nowhere in (address, f"http://{'x' * 100}.example"):
            with self.fails("unreachable", 0):
                Client(nowhere).maps()

    def test_answers_of_others_are_told(self):
        strangers = [(200, {}, b"<html>"), (404, {}, b"<html>"), (500, {}, b"[1]"),
                     (502, {}, b'{"error": 1}'), (302, {"Location": "http://127.0.0.1:1/"}, b"")]
        for stranger in strangers:
            with scripted(stranger) as (address, requests), self.fails("bad_answer", stranger[0]):
                Client(address, token=TOKEN).maps()
            self.assertEqual(len(requests), 1)

    def test_json_that_is_no_answer_is_told(self):
        no_objects = [b"null", b"[]", b'"ok"', b"7", b"[" * 100_000]
        asks = (
            (lambda client: client.localize(b"photo"), [b"{}", b'{"fine": true}', b'{"verdict": 1}']),
            (lambda client: client.maps(), [b"{}", b'{"next": null}', b'{"maps": []}',
                                            b'{"maps": 1, "next": null}',
                                            b'{"maps": [], "more": [], "next": null}',
                                            b'{"maps": [], "next": {}}']),
            (lambda client: list(client.rows("/v1/jobs")), [b'{"verdict": "localized"}']),
            (lambda client: client.get("/version"), []),
        )  # fmt: skip
        for ask, objects in asks:
            for body in no_objects + objects:
                with self.subTest(body[:40]), scripted((200, {}, body)) as (address, _):
                    with self.fails("bad_answer", 200):
                        ask(Client(address))

    def test_an_answer_cut_off(self):
        with scripted((200, {"Content-Length": "99"}, b'{"fi')) as (address, _):
            with self.fails("unreachable", 0):
                Client(address).maps()

    def test_an_answer_that_is_too_large(self):
        for headers in ({}, {"Content-Length": "600"}):
            with scripted((200, headers, bytes(600))) as (address, _):
                with mock.patch("waystone_client.MAX_ANSWER", 500), self.fails("bad_answer", 200) as context:
                    Client(address).maps()
                self.assertIn("more than 500 bytes", context.exception.detail)

    def test_a_path_before_the_api(self):
        with scripted(FINE) as (address, requests):
            Client(address + "/waystone/", token=TOKEN).localize(b"x", map="a b/c")
        self.assertEqual(requests[0][0], "/waystone/v1/maps/a%20b%2Fc/localize")
        self.assertEqual(requests[0][1]["Authorization"], "Bearer " + TOKEN)

    def test_what_is_no_server(self):
        for address in ("127.0.0.1:8080", "ftp://host", "http://", "http://host:port", "http://127.0.0.1:0"):
            with self.assertRaises(ValueError):
                Client(address)


def run(*arguments, **environment):
    """The program waystone-localize as users start it: code, out and err."""
    command = [sys.executable, "-B", str(PYTHON / "waystone-localize"), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S,
                          env={**os.environ, **environment})  # fmt: skip
    return done.returncode, done.stdout, done.stderr


class ProgramTest(unittest.TestCase):
    def test_a_line_a_photo(self):
        code, out, err = run("--server", url, "--map", NAME, INSIDE, ELSEWHERE)
        self.assertEqual((code, err), (0, ""))
        first, second = out.splitlines()
        self.assertRegex(first, r"inside.jpg: localized in \S+ near \S+ \(plane \d+, \d+ inliers, ")
        self.assertRegex(second, r"elsewhere.jpg: not_in_map: .+ \(\d+ ms\)")

    def test_json_is_the_servers_answer(self):
        code, out, _ = run("--server", url, "--json", "--together", INSIDE, ELSEWHERE)
        answer = json.loads(out)
        self.assertEqual((code, answer["image"], len(answer["images"])), (0, INSIDE, 2))

    def test_tokens_from_file_and_environment(self):
        asked = ("--server", guarded_url, INSIDE)
        self.assertEqual(run(*asked, "--token-file", str(token_file))[0], 0)
        self.assertEqual(run(*asked, "--token-file", str(commented_token_file()))[0], 0)
        self.assertEqual(run(*asked, WAYSTONE_TOKEN=TOKEN)[0], 0)
        code, _, err = run(*asked)
        self.assertEqual(code, 3)
        self.assertIn("unauthorized", err)

    def test_errors_are_a_line_and_a_code(self):
        code, out, err = run("--server", url, str(folder / "none.jpg"), INSIDE)
        self.assertEqual((code, len(out.splitlines()), len(err.splitlines())), (3, 1, 1))
        (folder / "empty").write_text("# none yet\n\n")
        for usage in (["--server", "nowhere", INSIDE], ["--token-file", "/none", INSIDE],
                      ["--token-file", str(folder / "empty"), INSIDE],
                      ["--timeout", "0", INSIDE], ["--timeout", "nan", INSIDE],
                      ["--timeout", "inf", INSIDE], ["--timeout", "1e300", INSIDE]):
            code, _, err = run(*usage)
            self.assertEqual((code, len(err.splitlines())), (2, 1), usage)
        self.assertEqual(run()[0], 2)

    def test_an_answer_without_its_fields_is_a_line_and_a_code(self):
        with scripted((200, {}, b'{"verdict":"undecided"}')) as (address, _):
            code, out, err = run("--server", address, INSIDE)
        self.assertEqual((code, out, len(err.splitlines())), (3, "", 1))
        self.assertIn("bad_answer", err)

    def test_names_are_printed_harmlessly(self):
        acting = "\x1b[2J\x7f\x9b\u202e\u2066\u2028\r\nz\udcff"
        shown = r"\u001b[2J\u007f\u009b\u202e\u2066\u2028\u000d\u000az\udcff"
        place = {"layer": "planes", "id": 1, "name": acting, "image": acting, "sequence": "", "time_s": None,
                 "position": None, "heading": None, "plan": {"name": acting, "x": 1, "y": 2}}  # fmt: skip
        answer = {"verdict": "localized", "image": acting, "map": acting, "place": place, "planes": [],
                  "timing_ms": {"total": 1}}  # fmt: skip
        refusal = json.dumps({"code": acting, "detail": acting}).encode()
        responses = [(200, {}, json.dumps(answer).encode())] * 2 + [(400, {}, refusal)]
        with scripted(*responses) as (address, _):
            asked = ("--server", address, INSIDE)
            said = [run(*asked), run(*asked, "--json"), run(*asked)]
        said += [run("--server", url, "--map", acting, INSIDE), run("--server", url, "none\x1b\u202e\n.jpg"),
                 run("--token-file", "none\x1b\u202e\n", INSIDE)]  # fmt: skip
        self.assertEqual([code for code, _, _ in said], [0, 0, 3, 3, 3, 2])
        for _, out, err in said:
            self.assertEqual((out + err).count("\n"), 1)
            self.assertTrue((out + err)[:-1].isprintable(), out + err)
        self.assertEqual(said[0][1].count(shown), 5)
        self.assertEqual(json.loads(said[1][1]), answer)
        self.assertEqual(said[2][2].count(shown), 2)
        code, _, err = run("--\x1b\u202e", INSIDE)
        self.assertEqual(code, 2)
        self.assertTrue(err.splitlines()[-1].isprintable(), err)

    def test_help_has_an_example(self):
        code, out, _ = run("--help")
        self.assertEqual(code, 0)
        self.assertIn("Example: waystone-localize", out)


def video_of(jpegs):
    """An AVI file of JPEG images of 640x480 pixels, ten a second."""
    def chunk(kind, data):
        return kind + struct.pack("<I", len(data)) + data + bytes(len(data) % 2)

    def group(kind, *chunks):
        return chunk(b"LIST", kind + b"".join(chunks))

    main = struct.pack("<14I", 100_000, 0, 0, 0, len(jpegs), 0, 1, 0, 640, 480, 0, 0, 0, 0)
    stream = struct.pack("<4s4s10I4H", b"vids", b"MJPG", 0, 0, 0, 1, 10, 0, len(jpegs), 0, 0, 0, 0, 0, 640, 480)
    picture = struct.pack("<3I2H4s5I", 40, 640, 480, 1, 24, b"MJPG", 0, 0, 0, 0, 0)
    heads = group(b"hdrl", chunk(b"avih", main), group(b"strl", chunk(b"strh", stream), chunk(b"strf", picture)))
    return chunk(b"RIFF", b"AVI " + heads + group(b"movi", *(chunk(b"00dc", jpeg) for jpeg in jpegs)))


class CommandTest(unittest.TestCase):
    """The program's commands that ask a server, or say what to ask one."""

    def ask(self, *arguments):
        done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=PATIENCE_S)
        return done.returncode, done.stdout.splitlines(), done.stderr.splitlines()

    def watch(self, *responses):
        """Watches a video of as many frames as there are responses."""
        video = folder / "walk.avi"
        video.write_bytes(video_of([pathlib.Path(INSIDE).read_bytes()] * len(responses)))
        with scripted(*responses) as (address, requests):
            said = self.ask("watch", NAME, str(video), "--every", "0", "--json", "--server", address)
        self.assertEqual(len(requests), len(responses))
        return said

    def test_watch_goes_on_when_the_server_is_back(self):
        away = (503, {}, problem("not_ready", 503))
        code, answers, errors = self.watch(FINE, away, FINE, (503, {}, problem("registry_unavailable", 503)))
        answers = [json.loads(answer) | {"image": "-"} for answer in answers]
        self.assertEqual((answers, code), ([ANSWER] * 2, 3))
        self.assertEqual(len(errors), 2)
        self.assertRegex(errors[0], r"^waystone: 0\.\d{3} s: http://.*: cause; remedy$")

    def test_watch_ends_where_every_frame_would_fail_alike(self):
        for problem_of_all in ("not_found", "unauthorized"):
            video = folder / "walk.avi"
            video.write_bytes(video_of([pathlib.Path(INSIDE).read_bytes()] * 3))
            status = {"not_found": 404, "unauthorized": 401}[problem_of_all]
            with scripted((status, {}, problem(problem_of_all, status))) as (address, requests):
                code, answers, errors = self.ask("watch", NAME, str(video), "--every", "0", "--server", address)
            self.assertEqual((code, answers, len(errors), len(requests)), (3, [], 1, 1), problem_of_all)

    def test_watch_goes_on_when_a_map_is_gone_later(self):
        code, answers, errors = self.watch(FINE, (404, {}, problem("not_found", 404)), FINE)
        self.assertEqual((code, len(answers), len(errors)), (3, 2, 1))

    def test_watch_says_when_it_has_every_answer(self):
        code, answers, errors = self.watch(FINE, FINE)
        self.assertEqual((code, len(answers), errors), (0, 2, []))

    def test_ports_that_there_cannot_be_are_refused(self):
        for port in ("99999999999", "65536", "0", "x", ""):
            code, _, (error,) = self.ask("localize", "-", INSIDE, "--server", f"http://localhost:{port}")
            self.assertEqual(code, 2, port)
            self.assertIn("port from 1 to 65535", error)

    def test_eval_names_paths_of_the_contract(self):
        queries = folder / "queries.csv"
        queries.write_text(f"image,keyframe\n{INSIDE},none.jpg\n")
        code, _, (error,) = self.ask("eval", MAP, str(queries))
        self.assertEqual(code, 3)
        first, second = re.search(r"GET /v1/maps/{map}(/\S+) and (/\S+) list them", error).groups()
        paths = list(Client(url).get("/openapi.json")["paths"])
        self.assertIn("/v1/maps/{map}" + first, paths)
        self.assertIn("/v1/maps/{map}" + second, paths)


JS_SCRIPT = """
import { Client, WaystoneError } from "./waystone.js";
const [url, token, map] = process.argv.slice(2);
const client = new Client(url, { token: token || null, timeout_ms: Number(process.argv[5]) });
const said = [];
for (const ask of [
  () => client.listMaps(),
  () => client.getPlane(map, 999999),
  async () => { const ids = []; for await (const k of client.rows("listKeyframes", map)) ids.push(k.id); return ids; },
]) {
  try { said.push(await ask()); } catch (e) {
    if (!(e instanceof WaystoneError)) throw e;
    said.push([e.code, e.status]);
  }
}
console.log(JSON.stringify(said));
"""


JS_NAMES_SCRIPT = """
import { Client, WaystoneError } from "./waystone.js";
const [url] = process.argv.slice(2);
const client = new Client(url);
const codeOf = (e) => {
  if (!(e instanceof WaystoneError)) throw e;
  return e.code;
};
const photo = new Uint8Array([1]);
const paths = ["..", ".", "\\ud800"].flatMap((name) => [
  () => client.localize(name, photo), () => client.getMap(name), () => client.getPlane("lab", name),
  () => client.getKeyframeImage(name, 1), () => client.rows("listKeyframes", name).next(),
  () => client.ask("GET", `/v1/maps/${name.replace(/[.]/g, "%2e")}/graph`),
]);
const configurations = [["foo"], ["127.0.0.1:8080"], ["ftp://host"], ["http://host:port"], ["http://127.0.0.1:0"],
  ["http://me:secret@host"], [""], [url, { token: "a\\nb" }], [url, { token: "\u65e5\u672c" }], [url, { token: " " }]];
const said = { paths: [], configurations: [], answers: [] };
for (const ask of paths) said.paths.push(await ask().then(() => "answered", codeOf));
for (const given of configurations) {
  try {
    new Client(...given);
    said.configurations.push("taken");
  } catch (e) {
    said.configurations.push(codeOf(e));
  }
}
for (let i = 0; i < 3; ++i) said.answers.push(await client.localizeAcross(photo).then((answer) => answer.verdict, codeOf));
console.log(JSON.stringify(said));
"""


def copy_js_client():
    for name in ("waystone.js", "package.json"):
        shutil.copy(JS / name, folder)


@unittest.skipUnless(shutil.which("node"), "Node is missing; its client is tested where it is")
class JsTest(unittest.TestCase):
    def ask(self, server, token="", timeout_ms=PATIENCE_S * 1000):
        (folder / "ask.mjs").write_text(JS_SCRIPT)
        copy_js_client()
        done = subprocess.run(["node", "ask.mjs", server, token, NAME, str(timeout_ms)], cwd=folder, capture_output=True, text=True,
                              timeout=PATIENCE_S)  # fmt: skip
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return json.loads(done.stdout)

    def test_answers_of_another_kind_are_told(self):
        page = {"Content-Type": "text/html; charset=utf-8"}
        ours = {"Content-Type": "application/json"}
        login = (302, {"Location": "/login"}, b"")
        for stranger in ((200, page, b"<html>"), (200, {}, b"{}"), (200, {"Content-Type": "image/png"}, b""),
                         (200, ours, b"<html>"), (200, ours, b"null"), (200, ours, b"[]"), login):
            with self.subTest(stranger), scripted(*[stranger] * 3) as (address, requests):
                self.assertEqual(self.ask(address), [["bad_answer", stranger[0]]] * 3)
                self.assertEqual(len(requests), 3)
        with scripted(*[(200, ours, b"{}")] * 3) as (address, _):
            self.assertEqual(self.ask(address), [{}, {}, ["bad_answer", 200]])

    def test_paths_addresses_and_tokens_that_cannot_be(self):
        (folder / "names.mjs").write_text(JS_NAMES_SCRIPT)
        copy_js_client()
        ours = {"Content-Type": "application/json"}
        unknown = (404, ours, problem("not_found", 404))
        answers = [(200, ours, body) for body in (b"{}", b'{"verdict": 1}', FINE[2])]
        with scripted(*[unknown] * 6, *answers) as (address, requests):
            done = subprocess.run(["node", "names.mjs", address], cwd=folder, capture_output=True, text=True,
                                  timeout=PATIENCE_S)  # fmt: skip
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        said = json.loads(done.stdout)
        self.assertEqual(said["paths"], ["not_found"] * 18)
        self.assertEqual(said["configurations"], ["bad_request"] * 10)
        self.assertEqual(said["answers"], ["bad_answer", "bad_answer", "undecided"])
        self.assertTrue(all("%EF%BF%BD" in path for path, _, _ in requests[:6]), "dots are never sent")

    def test_a_stalled_problem_ends_with_the_timeout(self):
        stalled = (500, {"Content-Length": "600"}, [b" "] * 600)
        with scripted(*[stalled] * 3) as (address, _):
            self.assertEqual(self.ask(address, timeout_ms=300), [["timeout", 0]] * 3)

    def test_timeouts_may_be_without_end_but_no_nonsense(self):
        for endless in ("Infinity", "1e300", str(2**31)):
            self.assertEqual(self.ask(url, timeout_ms=endless)[1], ["not_found", 404])
        self.assertEqual(self.ask(url, timeout_ms="NaN"), [["bad_request", 0]] * 3)

    def test_problems_tokens_and_pages(self):
        maps, missing, ids = self.ask(guarded_url, TOKEN)
        self.assertEqual(maps["maps"][0]["name"], NAME)
        self.assertEqual(missing, ["not_found", 404])
        self.assertEqual(ids, [row["id"] for row in Client(url).rows(f"/v1/maps/{NAME}/keyframes")])
        self.assertEqual(self.ask(guarded_url), [["unauthorized", 401]] * 3)

    def test_busy_is_asked_again_and_strangers_are_told(self):
        answer = (200, {"Content-Type": "application/json"}, b'{"fine": true}')
        again = (429, {"Retry-After": "0"}, problem("busy", 429))
        late = (429, {"Retry-After": "3600"}, problem("busy", 429))
        with scripted(again, answer, late, (500, {}, b"<html>")) as (address, requests):
            self.assertEqual(self.ask(address), [{"fine": True}, ["busy", 429], ["bad_answer", 500]])
            self.assertEqual(len(requests), 4)

    def test_silence_and_nobody(self):
        with scripted(None, None, None) as (address, _):
            self.assertEqual(self.ask(address, timeout_ms=300), [["timeout", 0]] * 3)
        self.assertEqual(self.ask(address), [["unreachable", 0]] * 3)


def block(readme, language):
    """The first fenced block of a language, asking the test's server."""
    text = readme.read_text(encoding="utf-8")
    found = re.search(rf"```{language}\n(.*?)```", text, re.DOTALL)[1]
    assert "http://127.0.0.1:8080" in found, found
    return found.replace("http://127.0.0.1:8080", url)


class ReadmeTest(unittest.TestCase):
    def example(self, readme):
        source = block(readme, "python")
        self.assertEqual(len(source.splitlines()), 5)
        environment = {**os.environ, "PYTHONPATH": f"{PYTHON}:{ROS2}"}
        done = subprocess.run([sys.executable, "-B", "-c", source], cwd=folder, env=environment,
                              capture_output=True, text=True, timeout=PATIENCE_S)  # fmt: skip
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout

    def test_python(self):
        self.assertRegex(self.example(PYTHON / "README.md"), rf"^{NAME}: near \S+, p = [01]")

    @unittest.skipUnless(shutil.which("node"), "Node is missing; its client is tested where it is")
    def test_js(self):
        (folder / "example.mjs").write_text(block(JS / "README.md", "js"))
        copy_js_client()
        done = subprocess.run(["node", "example.mjs"], cwd=folder, capture_output=True, text=True,
                              timeout=PATIENCE_S)  # fmt: skip
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertRegex(done.stdout, rf"^localized {NAME} \S+")

    def test_js_is_a_package(self):
        package = json.loads((JS / "package.json").read_text())
        self.assertEqual(package["type"], "module")  # Node 18 doesn't find that out
        self.assertEqual("waystone " + package["version"], Client(url).get("/version")["program"])
        for file in (package["main"], package["types"], *package["exports"]["."].values()):
            self.assertTrue((JS / file).is_file(), file)

    def test_cpp(self):
        self.assertIn("http://127.0.0.1:8080", (CPP / "README.md").read_text(encoding="utf-8"))
        done = subprocess.run([os.environ["WAYSTONE_CPP_EXAMPLE"]], cwd=folder, capture_output=True,
                              text=True, timeout=PATIENCE_S,
                              env={**os.environ, "WAYSTONE_URL": url})  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r'^"localized" \{"layer":"planes",.*"image":"\d+\.jpg"')

    def test_ros2(self):
        self.assertRegex(self.example(ROS2 / "README.md"), rf"^{NAME}/keyframe_\d+ \(")

    def test_shell(self):
        command = block(PYTHON / "README.md", "sh").replace("./", f"{sys.executable} -B {PYTHON}/")
        done = subprocess.run(command, shell=True, cwd=folder, capture_output=True, text=True,
                              timeout=PATIENCE_S)  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("photo.jpg: localized", done.stdout)


class StandInNode:
    """What the node uses of rclpy.node.Node."""

    parameters = {}

    def __init__(self, name):
        self.subscriptions_made = {}
        self.published = {}
        self.warnings = []

    def declare_parameter(self, name, default, descriptor=None):
        value = self.parameters.get(name, default)
        if type(value) is not type(default) and not (descriptor and descriptor.dynamic_typing):
            raise TypeError(f"InvalidParameterTypeException: {name} is {value!r}")
        return types.SimpleNamespace(value=value)

    def create_publisher(self, kind, topic, depth):
        sent = self.published.setdefault(topic, [])
        return types.SimpleNamespace(publish=sent.append)

    def create_subscription(self, kind, topic, callback, qos):
        self.subscriptions_made[topic] = callback

    def destroy_node(self):
        self.destroyed = True

    def get_logger(self):
        warn = lambda text, throttle_duration_sec: self.warnings.append(text)  # noqa: E731
        return types.SimpleNamespace(warning=warn)


def stand_ins():
    """Modules for everything of ROS that node.py imports."""
    modules = {name: types.ModuleType(name) for name in (
        "rcl_interfaces", "rcl_interfaces.msg", "rclpy", "rclpy.executors", "rclpy.node", "rclpy.qos", "geometry_msgs", "geometry_msgs.msg", "sensor_msgs",
        "sensor_msgs.msg", "std_msgs", "std_msgs.msg")}  # fmt: skip
    modules["rcl_interfaces.msg"].ParameterDescriptor = types.SimpleNamespace
    for name in ("init", "spin", "try_shutdown"):
        setattr(modules["rclpy"], name, mock.MagicMock())
    modules["rclpy.executors"].ExternalShutdownException = type(
        "ExternalShutdownException", (Exception,), {})
    modules["rclpy.node"].Node = StandInNode
    for name in ("HistoryPolicy", "QoSProfile", "ReliabilityPolicy"):
        setattr(modules["rclpy.qos"], name, mock.MagicMock())
    modules["geometry_msgs.msg"].PoseWithCovarianceStamped = mock.MagicMock
    modules["sensor_msgs.msg"].Image = modules["sensor_msgs.msg"].CompressedImage = object
    modules["std_msgs.msg"].String = types.SimpleNamespace
    return modules


def message(**fields):
    stamp = types.SimpleNamespace(sec=12, nanosec=5)
    return types.SimpleNamespace(header=types.SimpleNamespace(stamp=stamp), **fields)


class NodeTest(unittest.TestCase):
    def setUp(self):
        patch = mock.patch.dict(sys.modules, stand_ins())
        patch.start()
        self.addCleanup(patch.stop)

    def node(self, **parameters):
        sys.modules.pop("waystone_ros2.node", None)
        from waystone_ros2.node import WaystoneNode

        given = {"server": url, "timeout_s": float(PATIENCE_S), **parameters}
        with mock.patch.object(StandInNode, "parameters", given):
            return WaystoneNode()

    def photo(self, path):
        return message(format="jpeg", data=pathlib.Path(path).read_bytes())

    def test_a_pose_for_a_known_place(self):
        node = self.node(map=NAME, position_deviation_m=2.0)
        sent = self.photo(INSIDE)
        node.subscriptions_made["image/compressed"](sent)
        (pose,), (answer,) = node.published["~/pose"], node.published["~/answer"]
        answer = json.loads(answer.data)
        self.assertEqual(answer["image"], "12.000000005")
        self.assertEqual(pose.header.frame_id, f"{NAME}/keyframe_{answer['keyframe']['id']}")
        self.assertIs(pose.header.stamp, sent.header.stamp)
        self.assertEqual(pose.pose.covariance[0], 4)
        self.assertEqual(pose.pose.pose.orientation.w, 1)
        self.assertEqual(node.warnings, [])

    def test_a_position_for_a_panorama(self):
        place = {"layer": "appearance", "id": 7, "image": "7.jpg", "sequence": "s", "time_s": None,
                 "position": {"x": 3, "y": -1, "deviation": 0.2, "metres_per_unit": 0.5},
                 "heading": {"rad": 0.5, "deviation_rad": 0.1, "of": "layer"}}  # fmt: skip
        known = {"verdict": "localized", "map": "hall", "keyframe": None, "place": place}
        with scripted((200, {}, json.dumps(known).encode())) as (address, _):
            node = self.node(server=address, map="hall")
            node.subscriptions_made["image/compressed"](self.photo(INSIDE))
        self.assertEqual(node.warnings, [])
        (pose,) = node.published["~/pose"]
        self.assertEqual(pose.header.frame_id, "hall/appearance")
        self.assertEqual((pose.pose.pose.position.x, pose.pose.pose.position.y), (1.5, -0.5))
        for at, variance in ((0, 0.01), (7, 0.01), (14, 1e6), (35, 0.01)):
            self.assertAlmostEqual(pose.pose.covariance[at], variance)

    def test_a_pose_in_metres_names_its_map_unless_one_is_asked(self):
        pose = {"frame": "map", "unit": "metres", "position": [1, 2, 3], "orientation": [0, 0, 0, 1],
                "covariance": [[0.1] * 6] * 6, "inliers": 50, "camera": "query"}  # fmt: skip
        place = {"layer": "planes", "id": 1, "position": None, "heading": None}
        for given, frame in (({}, "hall/map"), ({"map": "hall"}, "map")):
            known = {"verdict": "localized", "map": "hall", "place": place, "pose": pose}
            with scripted((200, {}, json.dumps(known).encode())) as (address, _):
                node = self.node(server=address, **given)
                node.subscriptions_made["image/compressed"](self.photo(INSIDE))
            self.assertEqual(node.warnings, [])
            (sent,) = node.published["~/pose"]
            self.assertEqual(sent.header.frame_id, frame)

    def test_silence_for_an_unknown_one(self):
        node = self.node()
        node.subscriptions_made["image/compressed"](self.photo(ELSEWHERE))
        node.subscriptions_made["image/compressed"](message(format="jpeg", data=b"x"))
        self.assertEqual(node.published, {"~/pose": [], "~/answer": []})
        self.assertEqual(node.warnings, [])

    def test_raw_images_are_read_by_the_server(self):
        node = self.node(compressed=False)
        size = 64
        data = bytes(7 * i % 251 for i in range(size * size * 3))
        image = message(encoding="bgr8", width=size, height=size, step=size * 3, data=data)
        with mock.patch.object(node._client, "localize", wraps=node._client.localize) as asked:
            node.subscriptions_made["image"](image)
        photo = asked.call_args.args[0]
        self.assertEqual(Client(url).localize(photo)["verdict"], "not_in_map")
        self.assertEqual((node.published["~/pose"], node.warnings), ([], []))

    def test_errors_are_warnings_and_the_node_goes_on(self):
        node = self.node(map="nowhere")
        node.subscriptions_made["image/compressed"](self.photo(INSIDE))
        node.subscriptions_made["image/compressed"](message(format="compressedDepth", data=b""))
        self.assertIn("not_found", node.warnings[0])
        self.assertIn("depth", node.warnings[1])
        self.assertEqual(node.published["~/pose"], [])

    def test_the_node_outlives_every_answer(self):
        known = {"verdict": "localized", "map": "hall", "place": {"layer": "planes", "id": 1,
                 "position": None, "heading": None}}  # fmt: skip
        strangers = [b"null", b"[]", b"7", b"{}", b'{"verdict": "localized"}', b'{"verdict": []}',
                     b'{"verdict": "localized", "place": 7}', b"[" * 100_000, b"\xff"]  # fmt: skip
        fine = (200, {}, json.dumps(known).encode())
        with scripted(*[(200, {}, body) for body in strangers], fine) as (address, requests):
            node = self.node(server=address)
            for _ in range(len(strangers) + 1):
                node.subscriptions_made["image/compressed"](self.photo(INSIDE))
        self.assertEqual(len(requests), len(strangers) + 1)
        self.assertEqual(len(node.warnings), len(strangers))
        self.assertEqual([pose.header.frame_id for pose in node.published["~/pose"]],
                         ["hall/keyframe_1"])

    def test_the_node_outlives_what_cannot_be_published(self):
        node = self.node(map=NAME)
        node._pose.publish = mock.Mock(side_effect=UnicodeEncodeError("utf-8", "", 0, 1, "surrogate"))
        node.subscriptions_made["image/compressed"](self.photo(INSIDE))
        self.assertIn("surrogate", node.warnings[0])

    def test_signals_end_the_program_cleanly(self):
        self.node()
        node = sys.modules["waystone_ros2.node"]
        rclpy = sys.modules["rclpy"]
        for signal in (KeyboardInterrupt, sys.modules["rclpy.executors"].ExternalShutdownException):
            rclpy.spin.side_effect = signal
            self.assertEqual(node.main(), 0)
            self.assertTrue(rclpy.spin.call_args.args[0].destroyed)
        self.assertEqual(rclpy.try_shutdown.call_count, 2)

    def test_whole_numbers_are_numbers(self):
        node = self.node(map=NAME, fov_deg=63, timeout_s=PATIENCE_S, position_deviation_m=2)
        node.subscriptions_made["image/compressed"](self.photo(INSIDE))
        (pose,), (answer,) = node.published["~/pose"], node.published["~/answer"]
        self.assertEqual(pose.pose.covariance[0], 4)
        self.assertEqual(json.loads(answer.data)["camera"]["source"], "fov")

    def test_parameters_of_another_type_are_told(self):
        for name, value in (("fov_deg", "wide"), ("fov_deg", True), ("compressed", 1), ("map", 12),
                            ("timeout_s", [2.0]), ("token_file", None)):
            with self.assertRaisesRegex(ValueError, f"parameter {name} is .*; expected "):
                self.node(**{name: value})

    def test_wrong_parameters_end_the_program_with_a_line(self):
        self.node()
        node = sys.modules["waystone_ros2.node"]
        for wrong in ({"fov_deg": "wide"}, {"server": "nowhere"}, {"token_file": "/none"},
                      {"position_deviation_m": -1.0}):
            said = io.StringIO()
            with mock.patch.object(StandInNode, "parameters", wrong), contextlib.redirect_stderr(said):
                self.assertEqual(node.main(), 2)
            self.assertRegex(said.getvalue(), r"\Awaystone: .+\n\Z")
        sys.modules["rclpy"].spin.assert_not_called()

    def test_tokens(self):
        node = self.node(server=guarded_url, token_file=str(token_file))
        node.subscriptions_made["image/compressed"](self.photo(INSIDE))
        self.assertEqual(len(node.published["~/pose"]), 1)

    def test_tokens_below_a_comment(self):
        node = self.node(server=guarded_url, token_file=str(commented_token_file()))
        node.subscriptions_made["image/compressed"](self.photo(INSIDE))
        self.assertEqual((len(node.published["~/pose"]), node.warnings), (1, []))


if __name__ == "__main__":
    result = unittest.main(argv=sys.argv[:1] + sys.argv[5:], exit=False).result
    sys.exit(1 if not result.wasSuccessful() else 77 if result.skipped else 0)
