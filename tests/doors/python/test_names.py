# SPDX-License-Identifier: MIT
"""The public names of the C++ headers, of the Python package and of scene files are those of a list; C has abi.txt.

python test_names.py writes the lists anew, where names are new or gone on purpose.
"""
import inspect
import pathlib
import re

import dermis
import pytest

TOP = pathlib.Path(__file__).parents[3]
LISTS = TOP / "tests/doors/names"


def plain(text):
    """A header without comments, literals and directives, and with one space between words."""
    text = re.sub(r"//[^\n]*|/\*.*?\*/", " ", text, flags=re.S)
    text = re.sub(r"^\s*#(?:[^\n]*\\\n)*[^\n]*", " ", text, flags=re.M)
    text = re.sub(r'"(?:\\.|[^"\\])*"', '""', text)
    return " ".join(re.sub(r"\[\[.*?\]\]|alignas\([^)]*\)|\bDERMIS_\w+(?:\(\))?", " ", text).split())


def closing(text, at):
    """Where the bracket that opens at `at` closes."""
    depth = 0
    for i in range(at, len(text)):
        depth += (text[i] in "{([") - (text[i] in "})]")
        if not depth:
            return i
    raise AssertionError(text[at:at + 80])


def without_arguments(head):
    """A declaration without what stands in <>, and without the value of a default."""
    head = re.sub(r"\boperator\s*(?:\(\)|[^\s\w(]+)\s*(?=\()", "operator_", head)
    while re.search(r"<[^<>]*>", head):
        head = re.sub(r"<[^<>]*>", " ", head)
    return head


def declared(head):
    """The names that a declaration makes: of a function, of a type's other name, or of each variable."""
    head = without_arguments(re.sub(r"^template ?<.*?> (?=\w)|\brequires [^(]*\(.*\)(?= \w)", "", head)).strip()
    if not head or head.startswith(("friend ", "using namespace", "static_assert", "extern template")) or "= delete" in head:
        return []
    if made := re.match(r"using (\w+) =", head):
        return [made[1]]
    if made := re.match(r"(?:struct|class|enum class|enum) (\w+)$", head):
        return [made[1]]
    if made := re.search(r"\boperator ([\w: &*]+?) ?\(", head):
        return [f"operator {made[1]}"]
    if made := re.match(r"[^=(]*?(~?\w+) ?\(", head):
        return [made[1]]
    parts = re.sub(r"[({\[][^(){}\[\]]*[)}\]]", "", re.sub(r"[({\[][^(){}\[\]]*[)}\]]", "", head)).split(",")
    return [name[-1] for part in parts if (name := re.findall(r"~?\w+", part.split("=")[0]))]


def names_in(text, scope, public=True):
    """The public names of a namespace's or a class's declarations, each with its scope."""
    at = start = 0
    while at < len(text):
        head = text[start:at].strip()
        if made := re.fullmatch(r"(public|private|protected) ?", head) if text[at] == ":" and text[at:at + 2] != "::" else None:
            public, start = made[1] == "public", at + 1
        elif text[at] == ";":
            yield from (f"{scope}{name}" for name in declared(head) if public)
            start = at + 1
        elif text[at] in "([":
            at = closing(text, at)
        elif text[at] == "{":
            end = closing(text, at)
            body, head = text[at + 1:end], without_arguments(head)
            if made := re.fullmatch(r"(?:inline )?namespace ?([\w:]*)", head):
                if "detail" not in made[1]:
                    yield from names_in(body, f"{scope}{made[1]}::")
                start = end + 1
            elif made := re.search(r"\b(enum class|enum|struct|class|union) (\w*)(?: final)?(?: ?: ?[^:].*)?$", head):
                inner = f"{scope}{made[2]}::" if made[2] else scope
                if public and made[2]:
                    yield inner[:-2]
                if public and made[1].startswith("enum"):
                    yield from (inner + value.split("=")[0].strip() for value in body.split(",") if value.strip())
                elif public:
                    yield from names_in(body, inner, made[1] != "class")
                rest = re.match(r" ?([\w ={,}:]*);", text[end + 1:])
                if public and rest and rest[1] and made[1] != "namespace":
                    yield from (f"{scope}{name}" for name in declared(f"type {rest[1]}"))
                start = end + 1 + (rest.end() if rest else 0)
                end = start - 1
            elif re.search(r"\)(?: ?(?:const|noexcept|override|->.*|: .*))*$", head) and "= " not in head.split("(")[0]:
                yield from (f"{scope}{name}" for name in declared(head) if public)
                start = end + 1
            at = end
        at += 1


def names_of_headers():
    """Without those of a detail, and of the headers that contact.hpp is made of."""
    found = set()
    for header in sorted((TOP / "include/dermis").glob("*.hpp")):
        found.update(names_in(plain(header.read_text()), ""))
    return sorted(name for name in found if "~" not in name)


def arguments_of(thing):
    """The names of the arguments of a callable; several signatures are several lines."""
    if inspect.isfunction(thing) or inspect.ismethod(thing):
        return [", ".join(str(p).split(":")[0].split("=")[0].strip() for p in inspect.signature(thing).parameters.values())]
    found = []
    for line in (thing.__doc__ or "").splitlines():
        if re.match(r"\w+\(", line) and (" -> " in line or line.endswith(")")):  # of nanobind, above the sentences
            inside, depth, names = line[line.index("(") + 1:closing(line, line.index("("))], 0, ""
            for c in inside:
                depth += (c in "([{") - (c in ")]}")
                names += c if not depth else ""
            found.append(", ".join(re.split("[:=]", each)[0].strip() for each in names.split(",")))
    return found


def names_of_python():
    for module in (dermis, dermis.contact):
        for name in module.__all__:
            thing, full = getattr(module, name), f"{module.__name__}.{name}"
            if inspect.isclass(thing):
                yield from (f"{full}({args})" for args in arguments_of(thing.__init__) or [""])
                members = {m: k for kind in reversed(thing.__mro__) if kind.__module__.startswith("dermis") for m, k in vars(kind).items()}
                for member, value in members.items():
                    if not member.startswith("_") or member == "__getitem__":
                        value = getattr(thing, member) if not isinstance(value, property) else value
                        yield from (f"{full}.{member}({args})" for args in (arguments_of(value) if callable(value) else []) or [])
                        if not callable(value):
                            yield f"{full}.{member}"
            elif callable(thing):
                yield from (f"{full}({args})" for args in arguments_of(thing))
            else:
                yield full


FOUND = {"cpp": names_of_headers, "python": lambda: sorted(set(names_of_python())),
         "toml": lambda: sorted(row[0] + row[1] for row in dermis._core.key_rows())}


@pytest.mark.parametrize("door", FOUND)
def test_the_public_names_are_those_of_the_list(door):
    listed = (LISTS / f"{door}.txt").read_text().splitlines()
    found = FOUND[door]()
    new, gone = set(found) - set(listed), set(listed) - set(found)
    assert not new and not gone, f"new: {sorted(new)}; gone: {sorted(gone)}; on purpose: python {__file__} writes the lists"


def test_names_are_found_in_every_kind_of_declaration():
    text = plain("""
namespace dermis {
enum class Kind { flat, wave = 3 }; // not_this
struct DERMIS_API A : B { enum class In { a } kind = In::a; double x = f(1, 2), y{0}; std::optional<std::pair<int, int>> z; static int of(double q = 1);
  A(int n) : x(n) {} bool operator==(const A&) const; explicit operator bool() const { return x > 0; } };
class C { int hidden_; public: template <class T> void press(T, int) const; const int& at(size_t i) const { return i; } private: int also_hidden_ = 0; };
template <class T> inline constexpr T one = 1; using Row = std::vector<double>; DERMIS_API std::vector<int> made(const A& = {}, double b = 2);
namespace detail { int no; } } // namespace""")
    assert set(names_in(text, "")) == {f"dermis::{name}" for name in (
        "Kind", "Kind::flat", "Kind::wave", "A", "A::In", "A::In::a", "A::kind", "A::x", "A::y", "A::z", "A::of", "A::A", "A::operator_",
        "A::operator bool", "C", "C::press", "C::at", "one", "Row", "made")}


if __name__ == "__main__":
    LISTS.mkdir(exist_ok=True)
    for door, found in FOUND.items():
        (LISTS / f"{door}.txt").write_text("\n".join(found()) + "\n")
