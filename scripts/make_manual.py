#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""make_manual.py PROGRAM FOLDER: manual pages and a bash completion, of the program's own --help.

Writes FOLDER/man1/*.1.gz, a page for the program and one for every subcommand, and FOLDER/completion.
"""
import gzip
import pathlib
import re
import subprocess
import sys


def helped(program, *names):
    done = subprocess.run([program, *names, "--help"], capture_output=True, text=True, check=True)
    return done.stdout


class Help:
    """The parts of a --help as CLI11 writes it."""

    def __init__(self, text):
        lines = text.rstrip("\n").split("\n")
        start = next(i for i, line in enumerate(lines) if line.startswith("Usage: "))
        self.description = " ".join(line.strip() for line in lines[:start]).strip()
        self.usage = lines[start].removeprefix("Usage: ")
        self.sections = {}
        self.footer = []
        section = None
        for line in lines[start + 1:]:
            heading = re.fullmatch(r"(Positionals|Options|Subcommands):", line)
            if heading:
                section = self.sections.setdefault(heading[1], [])
            elif section is not None and line.startswith("  "):
                self.add_row(section, line)
            elif line or self.footer:
                section = None
                self.footer.append(line)

    @staticmethod
    def add_row(section, line):
        row = re.fullmatch(r"  (\S.*?)(?:\s{2,}(\S.*))?", line)
        if row and not line.startswith(" " * 10):
            section.append([row[1], row[2] or ""])
        else:
            section[-1][1] = (section[-1][1] + " " + line.strip()).strip()

    def words(self):
        """Options and subcommands, for completion."""
        found = re.findall(r"--[a-z][a-z0-9-]*", " ".join(row[0] for row in self.sections.get("Options", [])))
        return found + [row[0] for row in self.sections.get("Subcommands", [])]


def roff(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text.startswith((".", "'")) else text


def page(name, version, help_, also):
    title = name.replace(" ", "-")
    what = help_.description.split(".")[0].split(":")[0]
    out = [f'.TH {title.upper()} 1 "" "{version}"', ".SH NAME", f"{roff(title)} \\- {roff(what)}", ".SH SYNOPSIS",
           f".B {roff(help_.usage)}", ".SH DESCRIPTION", roff(help_.description)]
    for section, rows in help_.sections.items():
        out.append(f".SH {'ARGUMENTS' if section == 'Positionals' else section.upper()}")
        for row, text in rows:
            out += [".TP", f".B {roff(row)}", roff(text)]
    if help_.footer:
        out += [".SH NOTES", ".nf", *[roff(line) for line in help_.footer], ".fi"]
    out += [".SH SEE ALSO", ",\n".join(f".BR {roff(one)} (1)" for one in also if one != title).replace("(1),", "(1),")]
    return "\n".join(out) + "\n"


COMPLETION = """# bash completion of waystone; made by scripts/make_manual.py
_waystone() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} command=${{COMP_WORDS[1]}} words
  case $COMP_CWORD:$command in
    1:*) words="{top}" ;;
{cases}
  esac
  COMPREPLY=()
  if [[ $COMP_CWORD -eq 1 || $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
  else
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word"; compgen -f -- "$word")
  fi
}}
complete -o filenames -F _waystone waystone
"""


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    version = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    top = Help(helped(program))
    commands = [row[0] for row in top.sections["Subcommands"]]
    pages = {"waystone": top} | {f"waystone {name}": Help(helped(program, name)) for name in commands}
    for name in commands:
        for row in pages[f"waystone {name}"].sections.get("Subcommands", []):
            pages[f"waystone {name} {row[0]}"] = Help(helped(program, name, row[0]))
    (folder / "man1").mkdir(parents=True)
    also = [name.replace(" ", "-") for name in pages]
    for name, help_ in pages.items():
        text = page(name, version, help_, also if name == "waystone" else ["waystone"])
        (folder / "man1" / f"{name.replace(' ', '-')}.1.gz").write_bytes(gzip.compress(text.encode(), 9, mtime=0))
    cases = "\n".join(f'    *:{name}) words="{" ".join(pages["waystone " + name].words())}" ;;' for name in commands)
    (folder / "completion").write_text(COMPLETION.format(top=" ".join(top.words()), cases=cases), encoding="utf-8")


main()
