#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""check_doc_paths.py DOCUMENT...: whether the files and folders that they name are there.

A name is what stands in `backquotes` and has a slash or a suffix of a source; `core/a/b` may name
b.h, b.cc or both. Names with <, {, * or a blank are patterns, not files.
"""
import re
import sys
from pathlib import Path

NAME = re.compile(r"`([\w.][\w./+-]*)`")
TOP = {path.name for path in Path(".").iterdir() if path.name != "build"}


def names(text):
    for name in NAME.findall(re.sub(r"```.*?```", "", text, flags=re.DOTALL)):
        if "/" in name and name.split("/")[0] in TOP:
            yield name


def main(documents):
    missing = [f"{document}: there is no {name}"
               for document in documents for name in names(Path(document).read_text(encoding="utf-8"))
               if not any(Path(name + suffix).exists() for suffix in ("", ".h", ".cc"))]
    print("\n".join(missing) if missing else f"{len(documents)} documents name what is there")
    return 1 if missing or not documents else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
