#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""contract.py URL OPENAPI MAP LAYERED CALIBRATED INSIDE ELSEWHERE: holds a running server to its contract.

LAYERED is a map with an appearance, an orientation and a pose layer, MAP one without, CALIBRATED one of planes that
several views of a calibrated camera saw.

Records the responses of every route and of requests that hypothesis makes, and validates each
against clients/openapi.yaml. A 5xx, an undocumented status, a body that doesn't fit its schema and a
connection that breaks are failures. Exits with 1 and says which.
"""
import base64
import http.client
import json
import math
import re
import sys
import urllib.parse

import jsonschema
import yaml
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

URL, OPENAPI, MAP, LAYERED, CALIBRATED, INSIDE, ELSEWHERE = sys.argv[1:]
HOST = urllib.parse.urlsplit(URL).netloc
PHOTO = open(INSIDE, "rb").read()
OTHER = open(ELSEWHERE, "rb").read()
with open(OPENAPI, encoding="utf-8") as file:
    CONTRACT = yaml.safe_load(file)
RESOLVER = jsonschema.RefResolver.from_schema(CONTRACT)
SETTINGS = settings(
    max_examples=60,
    deadline=None,
    derandomize=True,
    database=None,
    phases=[Phase.generate, Phase.shrink],
    suppress_health_check=list(HealthCheck),
)
recorded = 0
seen = set()


def resolved(node):
    while "$ref" in node:
        node = RESOLVER.resolve(node["$ref"])[1]
    return node


def operation_of(method, path):
    for pattern, operations in CONTRACT["paths"].items():
        regex = re.sub(r"\\{\w+\\}", "[^/]+", re.escape(pattern))
        if re.fullmatch(regex, path) and method.lower() in operations:
            return pattern, operations[method.lower()]
    return None, None


connection = None


def exchange(method, target, body, headers):
    """One request on a kept connection, which a server may have closed in between."""
    global connection
    for attempt in (1, 2):
        try:
            connection = connection or http.client.HTTPConnection(HOST, timeout=30)
            connection.request(method, target, body=body, headers=headers)
            response = connection.getresponse()
            return response.status, response.headers, response.read()
        except (http.client.RemoteDisconnected, BrokenPipeError, ConnectionResetError):
            connection = None
            if attempt == 2:
                raise


def ask(method, target, body=None, headers=None, path=None):
    """Asks, and validates the response by the contract. Returns status, headers and body."""
    global recorded
    status, fields, data = exchange(method, target, body, headers or {})
    assert status < 500 or status == 503, (method, target, status, data[:300])
    assert fields.get("X-Request-Id"), (method, target)
    assert "Content-Security-Policy" in fields, (method, target)
    validate(method, path or urllib.parse.urlsplit(target).path, status, fields, data)
    recorded += 1
    return status, fields, data


def validate(method, path, status, fields, data):
    pattern, operation = operation_of(method, urllib.parse.unquote(path))
    media = (fields.get("Content-Type") or "").split(";")[0]
    if operation is None:
        assert status in (400, 404, 405), (method, path, status)
        schema = CONTRACT["components"]["schemas"]["Problem"]
    else:
        seen.add((method, pattern, str(status) if status < 400 else "problem"))
        response = operation["responses"].get(str(status), None)
        if response is None:
            assert status >= 400, (method, path, status, "is not in the contract")
            response = operation["responses"]["default"]
        content = resolved(response).get("content", {})
        if status == 304:
            assert data == b"" and not content
            return
        assert media in content, (method, path, status, media, data[:200])
        schema = content[media]["schema"]
    if media.endswith("json"):
        jsonschema.Draft202012Validator(schema, resolver=RESOLVER).validate(json.loads(data))


def form(parts):
    body = b"".join(
        b"--frontier\r\nContent-Disposition: form-data; " + head.encode() + b"\r\n\r\n" + data + b"\r\n"
        for head, data in parts
    )
    return body + b"--frontier--\r\n", {"Content-Type": "multipart/form-data; boundary=frontier"}


def in_json(fields, *images):
    fields["images"] = [{"data": base64.b64encode(image).decode()} for image in images]
    return json.dumps(fields).encode(), {"Content-Type": "application/json"}


def every_route():
    base = "/v1/maps/" + urllib.parse.quote(MAP)
    for path in ["/", "/plain", "/page/main.js", "/api", "/openapi.json", "/healthz", "/readyz", "/version", "/metrics"]:
        assert ask("GET", path)[0] == 200, path
    lists = ["/planes", "/keyframes", "/planes/1/features", "/planes/1/views"]
    singles = ["", "/planes/1", "/graph", "/graph?format=graphml", "/graph?format=dot", "/audit",
               "/keyframes/1", "/keyframes/1/image", "/keyframes/1/image?width=64",
               "/keyframes/1/thumbnail", "/overview", "/names", "/plan"]
    for path in ["/v1/maps"] + [base + part for part in lists + singles]:
        status, fields, _ = ask("GET", path)
        assert status == 200, path
        if "ETag" in fields:
            assert ask("GET", path, headers={"If-None-Match": fields["ETag"]})[0] == 304, path
    for part in lists + [""]:
        target = (base + part if part else "/v1/maps") + "?limit=1"
        key = {"": "maps"}.get(part, part.rsplit("/", 1)[-1])
        first = json.loads(ask("GET", target)[2])
        assert len(first[key]) == 1, target
    for path in ["/v1/maps/nowhere", base + "/planes/999999", base + "/keyframes/x", "/nowhere", base + "/plan/image",
                 "/v1/maps/" + urllib.parse.quote(LAYERED) + "/plan/image?name=Attic"]:
        assert ask("GET", path)[0] == 404, path
    for name in ["g2o", "geojson", "ply", "tum", "poses"]:
        assert ask("GET", base + "/graph?format=" + name)[0] == 422, name
    every_layer(base)
    every_plane_in_space()
    return base


def every_layer(without):
    base = "/v1/maps/" + urllib.parse.quote(LAYERED)
    lists = ["/appearance/nodes", "/appearance/loops", "/orientation/frames", "/orientation/turns",
             "/orientation/corridors"]
    singles = ["/appearance", "/orientation", "/poses", "/appearance/nodes/1", "/appearance/nodes/1/signature",
               "/appearance/nodes/1/image", "/orientation/nodes/3/image", "/overview",
               "/orientation/frames/1", "/orientation/nodes/3/lines", "/keyframes/1/lines",
               "/plan", "/plan/image", "/plan/image?name=Ground%20floor",
               "/graph?format=g2o", "/graph?format=geojson", "/graph?format=ply", "/graph?format=tum"]
    for part in lists + singles:
        status, fields, _ = ask("GET", base + part)
        assert status == 200, part
        assert ask("GET", base + part, headers={"If-None-Match": fields["ETag"]})[0] == 304, part
    for part in lists:
        assert len(json.loads(ask("GET", base + part + "?limit=1")[2])[part.rsplit("/", 1)[-1]]) == 1, part
    for part in lists + singles[:3]:
        status, _, data = ask("GET", without + part)
        assert (status, json.loads(data)["code"]) == (404, "no_layer"), part


def every_plane_in_space():
    base = "/v1/maps/" + urllib.parse.quote(CALIBRATED)
    keyframes = json.loads(ask("GET", base + "/keyframes")[2])["keyframes"]
    answers = [ask("GET", f"{base}/keyframes/{keyframe['id']}/space") for keyframe in keyframes]
    assert all(status == 200 for status, _, _ in answers)
    planes = [plane for _, _, data in answers for plane in json.loads(data)["planes"]]
    assert any(plane["trouble"] is None and plane["outline"] for plane in planes), planes


def every_body(base):
    for target in [base + "/localize", "/v1/localize"]:
        image = {"Content-Type": "image/jpeg"}
        raw = json.loads(ask("POST", target + "?debug=true&top_k=3", PHOTO, image)[2])
        assert raw["verdict"] == "localized", raw
        assert raw["candidates"] and raw["explanation"]["candidates"][0]["points"]
        assert json.loads(ask("POST", target, OTHER, image)[2])["verdict"] == "not_in_map"
        assert json.loads(ask("POST", target, b"x", image)[2])["verdict"] == "bad_image"
        body, headers = form([('name="image"; filename="a.jpg"', OTHER),
                              ('name="image"; filename="b.jpg"', PHOTO),
                              ('name="request"', b'{"top_k": 1, "fov_deg": 63}')])
        several = json.loads(ask("POST", target, body, headers)[2])
        assert several["verdict"] == "localized" and several["image"] == "b.jpg", several
        assert [one["verdict"] for one in several["images"]] == ["not_in_map", "localized"]
        # Of all maps together, one knows the building's directions and so makes use of a camera.
        assert several.get("unused") == (["camera"] if target.startswith(base) else None)
        same = json.loads(ask("POST", target, *in_json({}, PHOTO))[2])
        assert same["planes"][0]["id"] == raw["planes"][0]["id"]
        late = json.loads(ask("POST", target + "?deadline_ms=1", PHOTO, image)[2])
        assert late["verdict"] == "undecided" and late["stage"] in ("queue", "decode", "extract")
        done = json.loads(ask("POST", target + "?deadline_ms=30000", PHOTO, image)[2])
        assert done["verdict"] == "localized" and done["stage"] == "decide"
    across = json.loads(ask("POST", "/v1/localize", PHOTO, {"Content-Type": "image/jpeg"})[2])
    assert across["maps"][0]["map"] == MAP
    assert ask("POST", base + "/localize?camera=none", PHOTO)[0] == 422
    assert ask("POST", "/v1/localize?camera=none", PHOTO)[0] == 400
    assert ask("POST", base + "/localize", b"x", {"Content-Type": "text/plain"})[0] == 415


def sample(schema):
    """A small value of a schema."""
    schema = resolved(schema)
    if "oneOf" in schema:
        return sample(schema["oneOf"][-1])
    if schema["type"] == "object":
        return {name: sample(schema["properties"][name]) for name in schema.get("required", [])}
    if schema["type"] == "array":
        return [sample(schema["items"])] * schema.get("minItems", 0)
    return {"string": "x", "boolean": True}.get(schema["type"], schema.get("minimum", 1))


def edges(schema):
    """Values of a schema, and others, on both sides of each of its limits."""
    schema = resolved(schema)
    if "oneOf" in schema:
        schema = resolved(schema["oneOf"][-1])
    yield from [None, [1], sample(schema)]
    kind = schema["type"]
    if kind == "number":
        for bound in (schema["minimum"], schema["maximum"]):
            yield from [bound, math.nextafter(bound, math.inf), math.nextafter(bound, -math.inf)]
    elif kind == "integer":
        for bound in (schema["minimum"], schema["maximum"]):
            yield from [bound - 1, bound, bound + 1, float(bound - 1), float(bound), bound + 0.5, 2.0]
    elif kind == "string":
        yield from ["x" * schema["maxLength"], "x" * (schema["maxLength"] + 1)]
    elif kind == "array":
        for count in (0, 1, schema["maxItems"], schema["maxItems"] + 1):
            yield [sample(schema["items"])] * count
        yield from ([item] for item in edges(schema["items"]))
    elif kind == "object":
        whole = sample(schema)
        yield {**whole, "more": 1}
        for name in whole:
            yield {other: value for other, value in whole.items() if other != name}
        for name, field in schema["properties"].items():
            yield from ({**whole, name: value} for value in edges(field))


def every_limit(base):
    """The server refuses what is outside of the contract's limits of requests, and nothing else."""
    schema = CONTRACT["components"]["schemas"]["Request"]
    within = jsonschema.Draft202012Validator(schema, resolver=RESOLVER)
    requests = [{"more": 1}, {"fov_deg": 60, "camera": "x"}]
    for name, field in schema["properties"].items():
        others = dict.fromkeys(schema["dependentRequired"].get(name, []), 1)
        requests += [{name: sample(field)}] + [{name: value, **others} for value in edges(field)]
        requests += [{name: sample(field), **others, "fov_deg": 60}]
    for request in requests:
        motions = request.get("odometry")
        images = [b"x"] * max(1, len(motions) if isinstance(motions, list) else 1)
        target = "/v1/localize" if "hints" in request else base + "/localize"
        status, _, data = ask("POST", target, *in_json(dict(request), *images))
        # Ids are within the limits whether or not the map has them.
        refused = status == 400 and "the map has no " not in json.loads(data)["detail"]
        assert refused != within.is_valid(request), (request, status, data)


SEGMENT = st.text(st.characters(blacklist_categories=["Cs"]), min_size=1, max_size=12).map(
    lambda text: urllib.parse.quote(text, safe="")
)
NUMBER = st.one_of(st.integers(-5, 2000), st.floats(), st.integers()).map(str)
VALUE = st.one_of(NUMBER, st.sampled_from(["json", "dot", "true", "", "r1", "r0"]), SEGMENT)
FIELDS = ["fx", "fy", "cx", "cy", "fov_deg", "camera", "prior", "previous", "prior_keyframe",
          "top_k", "debug", "deadline_ms", "name", "limit", "cursor", "format", "width", "images"]
QUERY = st.dictionaries(st.sampled_from(FIELDS), VALUE, max_size=4)
ANY_JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(FIELDS + ["keyframe",
                                                  "data", "heading_rad"]), inner, max_size=4),
    max_leaves=8,
)
SMALL = st.one_of(st.binary(max_size=60), st.just(PHOTO[:400]), st.just(b""))


@SETTINGS
@given(st.sampled_from(sorted(CONTRACT["paths"])), st.sampled_from(["GET", "POST"]),
       st.lists(st.one_of(st.just(MAP), st.just("1"), SEGMENT), min_size=2, max_size=2), QUERY)
def any_address(pattern, method, captures, query):
    path = pattern
    for name, value in zip(("{map}", "{id}"), captures):
        path = path.replace(name, value)
    target = path + ("?" + urllib.parse.urlencode(query) if query else "")
    ask(method, target, b"" if method == "POST" else None)


@SETTINGS
@given(QUERY, SMALL, st.sampled_from(["image/jpeg", "", "application/json", "text/html",
                                      "multipart/form-data; boundary=frontier", "multipart/form-data"]))
def any_body(query, body, media):
    target = "/v1/maps/" + MAP + "/localize?" + urllib.parse.urlencode(query)
    ask("POST", target, body, {"Content-Type": media})


@SETTINGS
@given(ANY_JSON)
def any_json(value):
    headers = {"Content-Type": "application/json"}
    ask("POST", "/v1/localize", json.dumps(value).encode(), headers)
    if isinstance(value, dict):
        value["images"] = [{"data": base64.b64encode(PHOTO[:400]).decode()}]
        ask("POST", "/v1/maps/" + MAP + "/localize", json.dumps(value).encode(), headers)


@SETTINGS
@given(st.lists(st.tuples(st.sampled_from(['name="image"', 'name="request"', 'name="x"', "name", "",
                                           'name="image"; filename="\\"']),
                          st.one_of(SMALL, ANY_JSON.map(lambda v: json.dumps(v).encode()))),
                max_size=4), st.integers(0, 40))
def any_form(parts, cut):
    body, headers = form(parts)
    ask("POST", "/v1/maps/" + MAP + "/localize", body[: len(body) - cut], headers)


def main():
    base = every_route()
    every_body(base)
    for name in (MAP, LAYERED):
        every_limit("/v1/maps/" + urllib.parse.quote(name))
    for generate in (any_address, any_body, any_json, any_form):
        generate()
    wanted = {(method.upper(), path) for path, operations in CONTRACT["paths"].items()
              for method in operations if method in ("get", "post")}
    # This server has no registry: jobs_contract.py asks one that has.
    assert json.loads(ask("GET", "/v1/jobs")[2])["code"] == "not_available"
    wanted -= {("GET", "/v1/jobs"), ("GET", "/v1/jobs/{id}")}
    missing = wanted - {(method, path) for method, path, status in seen if status == "200"}
    assert not missing, f"routes of the contract without a good response: {missing}"
    assert ask("GET", "/healthz")[0] == 200
    print(f"{recorded} responses, {len(seen)} kinds, all as the contract says")


main()
