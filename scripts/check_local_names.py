#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Finds names that two sources of one CMake target define for themselves.

Sources are compiled several at a time (UNITY_BUILD), so what is in an anonymous namespace or static
in one of them meets that of the others. A name must differ within its target, whatever the order of
the sources. Functions may share a name where their parameters' types differ.

usage: check_local_names.py [ROOT]     prints each clash; exits with 1 if there is one
       check_local_names.py --self-test
"""
import contextlib
import io
import re
import sys
import tempfile
from pathlib import Path

TARGET = re.compile(r"^(waystone_library|waystone_test)\s*\(\s*(\S+)([^)]*)\)",
                    re.MULTILINE)
NOISE = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(?P<tag>[^(\s]*)\(.*?\)(?P=tag)"|"(?:\\.|[^"\\\n])*"|'
    r"(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])+'|^[ \t]*#(?:\\\n|[^\n])*", re.DOTALL | re.MULTILINE)
NAMED = re.compile(r"\b(?:class|struct|union|enum(?:\s+(?:class|struct))?)\s+(?:\[\[.*?\]\]\s*)?(\w+)")


def targets(root):
    """Name and sources of every target that the CMakeLists.txt below `root` list."""
    for lists in sorted(root.rglob("CMakeLists.txt")):
        if "build" in lists.relative_to(root).parts:
            continue
        for _, name, arguments in TARGET.findall(lists.read_text()):
            sources = [lists.parent / word for word in arguments.split() if word.endswith(".cc")]
            sources = [source for source in sources if source.exists()]
            if sources:
                yield f"{lists.parent.relative_to(root)}: {name}", sources


def statements(text):
    """(namespaces, head, is anonymous) of all definitions at namespace scope."""
    scopes, head, i = [], "", 0
    while i < len(text):
        c = text[i]
        if c == "{":
            namespace = re.search(r"\b(?:inline\s+)?namespace\s*([\w:]*)\s*$", head)
            if namespace:
                scopes.append(namespace[1])
                head = ""
            else:
                end = closing(text, i)
                # An initialiser or a body; the head goes on behind an initialiser within parentheses.
                if head.count("(") > head.count(")"):
                    i = end
                    continue
                yield [s for s in scopes if s], head + "{", "" in scopes
                head, i = "", end
                continue
        elif c == "}":
            if scopes:
                scopes.pop()
            head = ""
        elif c == ";":
            yield [s for s in scopes if s], head + ";", "" in scopes
            head = ""
        else:
            head += c
        i += 1


def closing(text, opening):
    """The index after the brace that closes the one at `opening`."""
    depth = 0
    for i in range(opening, len(text)):
        depth += {"{": 1, "}": -1}.get(text[i], 0)
        if depth == 0:
            return i + 1
    return len(text)


def without_templates(head):
    """`head` without template parameters and arguments, that is, without what is between < and >."""
    head = head.replace("<<", "").replace("->", "").replace("<=>", "").replace(">=", "").replace("<=", "")
    before = None
    while before != head:
        before, head = head, re.sub(r"<[^<>]*>", "", head)
    return head


def parameters(head):
    """The types of a function's parameters as text, without their names and defaults."""
    inside = head[head.index("(") + 1:]
    depth, ends = 1, 0
    for ends, c in enumerate(inside):
        depth += {"(": 1, ")": -1}.get(c, 0)
        if depth == 0:
            break
    depth, part, parts = 0, "", []
    for c in inside[:ends] + ",":
        depth += {"(": 1, "<": 1, ")": -1, ">": -1}.get(c, 0)
        if c == "," and depth == 0:
            parts.append(part)
            part = ""
        else:
            part += c
    types = [re.sub(r"\s*=.*$", "", p.strip(), flags=re.DOTALL) for p in parts if p.strip()]
    types = [re.sub(r"(?<=[\w>&*\]])\s*\b\w+(\[\w*\])?$", r"\1", t) if re.search(r"[\s&*>]\w+(\[\w*\])?$", t)
             else t for t in types]
    return ", ".join(re.sub(r"\s+", " ", t).strip() for t in types)


def defined(head):
    """(name, parameters or None) of what `head` defines, or None for what defines nothing."""
    if match := re.match(r"using (\w+)\s*=\s*(.*)", re.sub(r"^\s*template\s*<.*?>\s*|\s+", " ", head).strip()):
        return match[1], "= " + match[2]  # the same one may occur twice
    head = re.sub(r"__attribute__\s*\(\(.*?\)\)|\[\[.*?\]\]", " ", head)
    head = re.sub(r"\s+", " ", head).strip()
    plain = re.sub(r"^\s*template\s+", "", without_templates(head)).strip()
    if re.match(r"(namespace|using namespace|static_assert|extern|friend|typedef)\b", plain) or plain in "{;":
        return None
    if re.match(r"using\b", plain):
        return None
    if re.match(r"(class|struct|union|enum)\b", plain):
        match = NAMED.match(plain)
        return (match[1], None) if match and plain.endswith("{") else None
    value = re.match(r"[^=(]*?\b(\w+)\s*(?:\[[^\]]*\]\s*)*(?:=|\{|;)", plain)
    function = re.match(r"[^=(]*?\b(\w+|operator\s*\S+?)\s*\(", plain)
    if function and not (value and value.end() < function.end()):
        if re.match(r"k[A-Z]", function[1]):
            return function[1], None
        if "::" + function[1] in plain.split("(")[0].split()[-1]:
            return None  # a member defined outside of its class
        if plain.endswith(";"):
            return None  # a declaration
        if function[1].startswith("TEST"):
            return f"{function[1]}({parameters(head)})", None
        return function[1], parameters(head[head.index(function[1]):])
    return (value[1], None) if value else None


def local_names(text):
    """{(namespace, name): set of parameter texts, or {None}} of what a source keeps to itself."""
    names = {}
    for scopes, head, anonymous in statements(NOISE.sub(lambda m: '""' if '"' in m[0][:2] else " ", text)):
        if not anonymous and not re.match(r"\s*(template\s*<.*>\s*)?static\b", head):
            continue
        found = defined(head)
        if found:
            names.setdefault(("::".join(scopes), found[0]), set()).add(found[1])
    return names


def clashes(sources):
    """(name, first source, second source) of each name that two of the sources define."""
    seen = {}
    for path, text in sources:
        for key, signatures in local_names(text).items():
            for other, others in seen.get(key, []):
                both = signatures | others
                aliases = [s for s in both if s and s.startswith("= ")]
                if None in both or (len(both) > 1 if aliases else signatures & others):
                    yield key[1], other, path
                    break
            seen.setdefault(key, []).append((path, signatures))


def check(root):
    count = 0
    for target, sources in targets(root):
        for name, first, second in clashes((s.relative_to(root), s.read_text()) for s in sources):
            print(f"{target}: {name} is defined in {first} and in {second}")
            count += 1
    return count


def self_test():
    local = "namespace waystone {\nnamespace {\n%s\n}  // namespace\n}\n"
    cases = [  # two sources, and whether they clash
        ("constexpr int kGap = 3;", "constexpr double kGap{3};", True),
        ("constexpr int kGap = 3;", "constexpr int kGaps = 3;", False),
        ('const std::regex kWord("a{2}");', "constexpr char kWord[] = \"}\";", True),
        ("double Mean(const std::vector<int>& v) { return 0; }",
         "double Mean(const std::vector<int>& values) { return 1; }", True),
        ("double Mean(const std::vector<int>& v) { return 0; }",
         "double Mean(const Rows& v, int n = 3) { return 1; }", False),
        ("class Reader { int a; };", "struct Reader final : Base { int b; };", True),
        ("class Reader { int Find() { return 0; } };", "int Find() { return 1; }", False),
        ("class A { void Find(); };\nvoid A::Find() {}", "class B { void Find(); };\nvoid B::Find() {}",
         False),
        ("template <class T>\nT Twice(T a) { return a; }", "template <class U>\nU Twice(T b) { return b; }",
         True),
        ("using Json = int;", "enum class Json { kA };", True),
        ("using Json = int;", "using Json = int;", False),
        ("using Json = std::map<int, int>;", "using Json = std::map<int, double>;", True),
        ("int Find(int a);", "int Find(int a);", False),
        ("namespace fs = std::filesystem;", "namespace fs = std::filesystem;", False),
        ("// int Find() {}\nint A() { return 0; }", "int Find() { return 0; }", False),
        ("const std::map<std::string, int> kAll = {{\"a\", 1}};", "const auto kAll = Make();", True),
        ("TEST(Tables, Fit) {}", "TEST(Tables, Read) {}", False),
    ]
    wrong = [(a, b) for a, b, clash in cases
             if clash != bool(list(clashes([("a.cc", local % a), ("b.cc", local % b)])))]
    if not list(clashes([("a.cc", "static int Count() { return 0; }"),
                         ("b.cc", "static int Count() { return 1; }")])):
        wrong.append("static functions")
    if list(clashes([("a.cc", "int Count() { return 0; }"), ("b.cc", local % "int Count() { return 1; }")])):
        wrong.append("a function that others see")
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        (root / "CMakeLists.txt").write_text("waystone_library(x SOURCES a.cc\n  b.cc DEPS y)\n")
        for name in ("a.cc", "b.cc"):
            (root / name).write_text(local % "constexpr int kGap = 3;")
        with contextlib.redirect_stdout(io.StringIO()):
            found = check(root)
        if found != 1:
            wrong.append("a target's sources")
    for case in wrong:
        print("wrong:", case)
    return len(wrong)


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test() > 0
    return check(Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()) > 0


if __name__ == "__main__":
    sys.exit(main())
