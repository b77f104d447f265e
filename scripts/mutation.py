"""Mutants of C++ text: one small fault each, found by pattern in what is neither comment nor string. For mutants.py.

The patterns lean on clang-format: a binary operator has a space on either side, the bracket of a template has none."""
import dataclasses
import re


@dataclasses.dataclass(frozen=True)
class Mutant:
    path: str
    line: int  # from 1
    column: int
    operator: str
    before: str  # the whole line
    after: str

    @property
    def id(self):
        return f"{self.path}:{self.line}:{self.column} {self.operator}"

    @property
    def key(self):
        """What stays when lines above come and go."""
        return self.path, self.before.strip(), self.after.strip()


HIDDEN = re.compile(r"""//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9A-Fa-f])'(?:\\.|[^'\\\n])+'"""
                    r"|^[ \t]*\#[^\n]*|\bstatic_assert\(.*?\);|^[ \t]*(?:using|template|namespace)\b[^\n]*", re.S | re.M)
TEMPLATE = re.compile(r"\w<[^<>;\n]*(?:<[^<>;\n]*(?:<[^<>;\n]*>[^<>;\n]*)*>[^<>;\n]*)*>")
NUMBER = re.compile(r"(?<![\w.\['])(?:\d[\d']*\.\d*(?:e[+-]?\d+)?|\d+e[+-]?\d+|\d[\d']*)(?:LL|ULL|U|u)?(?![\w.\]'])")
OPPOSITE = {"<": ">=", ">=": "<", ">": "<=", "<=": ">", "==": "!=", "!=": "=="}
NEIGHBOUR = {"<": "<=", "<=": "<", ">": ">=", ">=": ">"}
AXIS = {"x": "y", "y": "z", "z": "x"}
NO_STATEMENT = re.compile(r"(return|using|const|constexpr|static|auto|if|else|for|while|do|switch|case|default|break|continue|throw|"
                          r"class|struct|enum|friend|public|private|protected|goto|explicit|virtual|inline|SP_EXPECTS|operator)\b")


def blank(match):
    return re.sub(r"[^\n]", " ", match[0])


def without_field_lists(text):
    """Field lists state ranges and words of the configuration; they are no algorithm."""
    out, at = [], 0
    for start in re.finditer(r"static constexpr auto fields\(\) \{", text):
        if start.start() < at:
            continue
        depth, end = 1, start.end()
        while depth and end < len(text):
            depth += {"{": 1, "}": -1}.get(text[end], 0)
            end += 1
        out += [text[at:start.start()], re.sub(r"[^\n]", " ", text[start.start():end])]
        at = end
    return "".join(out) + text[at:]


def code_of(text):
    """The same text, line for line and column for column, with blanks for what is not code."""
    return without_field_lists(HIDDEN.sub(blank, text))


def signs(code):
    for m in re.finditer(r" ([+-])(=?) ", code):
        yield m.start(1), m.end(1), "-" if m[1] == "+" else "+"
    for m in re.finditer(r"(?<=[(,={] )-(?=[\w(])|(?<=[({])-(?=[\w(])|(?<=return )-(?=[\w(])", code):
        yield m.start(), m.end(), ""


def bounds(code):
    for m in re.finditer(r" (<=|>=|<|>|==|!=) (\S*)", code):
        yield m.start(1), m.end(1), OPPOSITE[m[1]]
        # Between real numbers "<" and "<=" are the same but for a chance of none: only integers have a boundary.
        if m[1] in NEIGHBOUR and re.match(r"\d+\b(?![.e])|\S*size\(\)", m[2]):
            yield m.start(1), m.end(1), NEIGHBOUR[m[1]]


def logic(code):
    for m in re.finditer(r" (&&|\|\|) ", code):
        yield m.start(1), m.end(1), "||" if m[1] == "&&" else "&&"
    for m in re.finditer(r"(?<=[( ])!(?=[\w(])", code):
        yield m.start(), m.end(), ""


def indices(code):
    for m in re.finditer(r"\[([012])\]", code):
        yield m.start(1), m.end(1), str((int(m[1]) + 1) % 3)
    for m in re.finditer(r"\.([xyz])\(\)", code):
        yield m.start(1), m.end(1), AXIS[m[1]]
    for m in re.finditer(r"\(([0-9ijk]), ([0-9ijk])\)", code):
        if m[1] != m[2]:
            yield m.start(1), m.end(2), f"{m[2]}, {m[1]}"


def constants(code):
    inside = [m.span() for m in TEMPLATE.finditer(code)]
    for m in NUMBER.finditer(code):
        if any(a < m.start() < b for a, b in inside):
            continue
        zero = not re.search(r"[1-9]", m[0].split("e")[0])
        yield m.start(), m.end(), m[0].replace("0", "1", 1) if zero else f"(2 * {m[0]})"


def statements(code, before=";"):
    """A line that is one whole assignment or call, after `before`, the end of the line above."""
    text = code.strip()
    head = re.match(r"(\+\+|--)?[A-Za-z_][^=(]*", text)
    if not head or not text.endswith(";") or NO_STATEMENT.match(text) or not re.search(r"[;{}:)]$", before):
        return
    declares = re.search(r"[\w>&*] [\w&*]", head[0].strip())
    if declares or text.count("(") != text.count(")") or text.count("{") != text.count("}"):
        return
    if re.search(r"[^=!<>]=|\(|\+\+|--", text):
        start = len(code) - len(code.lstrip())
        yield start, len(code.rstrip()), "{}"


OPERATORS = {"sign": signs, "bound": bounds, "logic": logic, "index": indices, "constant": constants, "statement": statements}


def mutants_of(path, text):
    """Every mutant of one file, in the order of its lines."""
    out = []
    before = ";"
    for number, (line, code) in enumerate(zip(text.splitlines(), code_of(text).splitlines()), 1):
        for operator, find in OPERATORS.items():
            found = find(code, before) if operator == "statement" else find(code)
            for start, end, new in found:
                out.append(Mutant(path, number, start + 1, operator, line, line[:start] + new + line[end:]))
        before = code.strip() or before
    return out


def applied(text, mutant):
    lines = text.split("\n")
    if lines[mutant.line - 1] != mutant.before:
        raise ValueError(f"{mutant.id}: the line is another one")
    lines[mutant.line - 1] = mutant.after
    return "\n".join(lines)
