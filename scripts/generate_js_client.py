#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""generate_js_client.py OPENAPI FOLDER [--check]: writes waystone.js, waystone.d.ts and package.json.

A type for every schema of the contract and a method for every operation that has a JSON, text or image
answer; scripts/js_client/client.js has what they share. With --check nothing is written: exits with 1
when the files aren't what the contract gives.
"""
import json
import pathlib
import re
import sys

import yaml

HERE = pathlib.Path(__file__).resolve().parent
NOTE = "// Made from clients/openapi.yaml by scripts/generate_js_client.py; don't edit.\n"
# Pages for people, which are of no use to a program.
PAGES = {"page", "pageFile", "plainPage", "contractPage"}


def type_of(schema):
    """The TypeScript type of a schema."""
    if "$ref" in schema:
        return schema["$ref"].rsplit("/", 1)[1]
    if "const" in schema:
        return literal(schema["const"])
    if "enum" in schema:
        return " | ".join(literal(value) for value in schema["enum"])
    if "oneOf" in schema:
        return " | ".join(type_of(choice) for choice in schema["oneOf"])
    kind = schema.get("type")
    if isinstance(kind, list):
        return " | ".join(type_of({**schema, "type": one}) for one in kind)
    if kind == "array":
        return array_type(schema)
    if kind == "object":
        return object_type(schema)
    if kind == "string":
        return "Blob" if schema.get("format") == "binary" else "string"
    return {"integer": "number", "number": "number", "boolean": "boolean", "null": "null"}[kind]


def literal(value):
    return "null" if value is None else str(value).lower() if isinstance(value, bool) else f'"{value}"'


def array_type(schema):
    item = type_of(schema["items"])
    size = schema.get("minItems")
    if size and size == schema.get("maxItems"):
        return "[" + ", ".join([item] * size) + "]"
    return f"({item})[]" if " " in item and not item.startswith(("{", "[")) else f"{item}[]"


def object_type(schema):
    if "properties" not in schema:
        return "Record<string, unknown>"
    required = set(schema.get("required", []))
    fields = [f"{name}{'' if name in required else '?'}: {type_of(value)}"
              for name, value in schema["properties"].items()]
    return "{ " + "; ".join(fields) + " }"


def declaration(name, schema):
    comment = f"/** {schema['description']} */\n" if "description" in schema else ""
    if schema.get("type") != "object" or "properties" not in schema:
        return f"{comment}export type {name} = {type_of(schema)};\n"
    required = set(schema.get("required", []))
    lines = []
    for field, value in schema["properties"].items():
        if "description" in value:
            lines.append(f"  /** {value['description']} */")
        lines.append(f"  {field}{'' if field in required else '?'}: {type_of(value)};")
    return f"{comment}export interface {name} {{\n" + "\n".join(lines) + "\n}\n"


class Operation:
    def __init__(self, contract, path, parameters, verb, spec):
        def resolved(node):
            while "$ref" in node:
                node = contract["components"]["parameters"][node["$ref"].rsplit("/", 1)[1]]
            return node

        every = [resolved(one) for one in parameters + spec.get("parameters", [])]
        self.name = spec["operationId"]
        self.summary = spec["summary"]
        self.path = path
        self.verb = verb.upper()
        self.captures = re.findall(r"{(\w+)}", path)
        self.query = [one for one in every if one["in"] == "query"]
        self.captured = {one["name"]: type_of(one["schema"]) for one in every if one["in"] == "path"}
        self.has_body = "requestBody" in spec
        self.content = spec["responses"]["200"].get("content", {})
        names = [one["schema"]["$ref"].rsplit("/", 1)[1] for one in self.content.values()
                 if "$ref" in one["schema"]]
        schema = contract["components"]["schemas"].get(names[0]) if names else None
        # The list of rows in a page.
        self.rows = next((key for key in (schema or {}).get("properties", {}) if key != "next"), None) \
            if schema and "next" in schema["properties"] else None
        self.row_type = type_of(schema["properties"][self.rows]["items"]) if self.rows else None

    def kind(self):
        """The kind of every answer, by its Content-Type; None where it varies."""
        kinds = {"json" if media == "application/json" else "image" if media.startswith("image/") else "text"
                 for media in self.content}
        return kinds.pop() if len(kinds) == 1 else None

    def result(self):
        kinds = []
        for media, content in self.content.items():
            kind = type_of(content["schema"]) if media == "application/json" or media.startswith("image/") \
                else "string"
            kinds += [kind] if kind not in kinds else []
        return " | ".join(kinds)

    def options(self):
        fields = [f"{one['name']}?: {type_of(one['schema'])}" for one in self.query]
        return "{ " + "; ".join(fields) + " }"

    def declared(self):
        arguments = [f"{name}: {self.captured[name]}" for name in self.captures]
        arguments += ["photo: Photo"] if self.has_body else []
        arguments += [f"options?: {self.options()}"] if self.query else []
        return f"  /** {self.summary} */\n  {self.name}({', '.join(arguments)}): Promise<{self.result()}>;\n"

    def declared_rows(self):
        captures = [f"{name}: {self.captured[name]}" for name in self.captures]
        arguments = ", ".join([f'list: "{self.name}"'] + captures)
        return f"  rows({arguments}): AsyncGenerator<{self.row_type}, void>;\n"

    def method(self):
        arguments = self.captures + (["photo"] if self.has_body else [])
        arguments += ["options = {}"] if self.query else []
        target = re.sub(r"{(\w+)}", r"${segment(\1)}", self.path)
        if self.has_body:
            return f"  {self.name}({', '.join(arguments)}) {{\n    return this.query(`{target}`, options, photo);\n  }}\n"
        sent = [f'"{self.verb}"', f"`{target}`", "options" if self.query else "{}"]
        sent += ["undefined", f'"{self.kind()}"'] if self.kind() else []
        return f"  {self.name}({', '.join(arguments)}) {{\n    return this.ask({', '.join(sent)});\n  }}\n"


def operations_of(contract):
    for path, item in contract["paths"].items():
        for verb in ("get", "post"):
            if verb in item and item[verb]["operationId"] not in PAGES:
                yield Operation(contract, path, item.get("parameters", []), verb, item[verb])


def generate(contract):
    operations = list(operations_of(contract))
    shared = (HERE / "js_client/client.js").read_text(encoding="utf-8")
    lists = ", ".join(f'{one.name}: "{one.rows}"' for one in operations if one.rows)
    script = shared.replace("  // OPERATIONS\n", "\n".join(one.method() for one in operations))
    script = script.replace("/* LISTS */", lists)
    types = (HERE / "js_client/client.d.ts").read_text(encoding="utf-8")
    methods = "".join(one.declared() for one in operations)
    rows = "".join(one.declared_rows() for one in operations if one.rows)
    types = types.replace("  // OPERATIONS\n", methods).replace("  // ROWS\n", rows)
    schemas = contract["components"]["schemas"]
    types += "\n" + "\n".join(declaration(name, schema) for name, schema in schemas.items())
    licence = "// SPDX-License-Identifier: Apache-2.0\n"
    return {"waystone.js": licence + NOTE + script, "waystone.d.ts": licence + NOTE + types,
            "package.json": json.dumps(package_of(contract), indent=2) + "\n"}


def package_of(contract):
    """Without "type" Node 18 takes waystone.js for a CommonJS script."""
    return {
        "name": "waystone-client",
        "version": contract["info"]["version"],
        "description": "Asks a Waystone server where photos were taken",
        "license": contract["info"]["license"]["identifier"],
        "type": "module",
        "main": "waystone.js",
        "exports": {".": {"types": "./waystone.d.ts", "default": "./waystone.js"}},
        "types": "waystone.d.ts",
        "engines": {"node": ">=18"},
    }


def main():
    source, folder = sys.argv[1:3]
    with open(source, encoding="utf-8") as file:
        files = generate(yaml.safe_load(file))
    for name, text in files.items():
        path = pathlib.Path(folder) / name
        if "--check" not in sys.argv:
            path.write_text(text, encoding="utf-8")
        elif not path.is_file() or path.read_text(encoding="utf-8") != text:
            print(f"{path} isn't what {source} gives; run {' '.join(sys.argv[:3])}")
            sys.exit(1)


main()
