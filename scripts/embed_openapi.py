#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""embed_openapi.py YAML CC: writes the contract as JSON in a C++ source file."""
import json
import sys

import yaml

CHUNK = 8000  # characters of one literal; compilers bound them


def main():
    source, target = sys.argv[1:]
    with open(source, encoding="utf-8") as file:
        text = json.dumps(yaml.safe_load(file), separators=(",", ":"))
    chunks = [text[i : i + CHUNK] for i in range(0, len(text), CHUNK)]
    literals = "\n".join('    R"~~(' + chunk + ')~~"' for chunk in chunks)
    with open(target, "w", encoding="utf-8") as file:
        file.write(
            "// Made by scripts/embed_openapi.py; don't edit.\n"
            "namespace waystone {\n"
            "extern const char kOpenApiJson[];\n"
            f"const char kOpenApiJson[] =\n{literals};\n"
            "}  // namespace waystone\n"
        )


main()
