"""What of a GLSL source is compiled: the lines that the preprocessor's conditions leave (GLSL 4.60, section 3.3)."""
import re

_DIRECTIVE = re.compile(r"^\s*#\s*(\w+)\s*(.*?)\s*$")


def active(source):
    """The source without the lines of conditions that are false. A condition that can't be read counts as true."""
    source = re.sub(r"/\*.*?\*/", lambda found: "\n" * found.group(0).count("\n"), source, flags=re.S)
    source = re.sub(r"//[^\n]*", "", source).replace("\\\n", " ")
    macros, kept, open_ones = {}, [], []  # open_ones: [is taken, one was taken before]
    for line in source.split("\n"):
        found = _DIRECTIVE.match(line)
        name, rest = found.groups() if found else ("", "")
        is_active = all(taken for taken, _ in open_ones)
        if name in ("if", "ifdef", "ifndef"):
            if name == "if":
                taken = is_active and _is_true(rest, macros)
            else:
                taken = is_active and (rest.split()[:1] and rest.split()[0] in macros) == (name == "ifdef")
            open_ones.append([taken, taken])
        elif name in ("elif", "else") and open_ones:
            outside = all(taken for taken, _ in open_ones[:-1])
            had = open_ones[-1][1]
            taken = outside and not had and (name == "else" or _is_true(rest, macros))
            open_ones[-1] = [taken, had or taken]
        elif name == "endif" and open_ones:
            open_ones.pop()
        elif is_active:
            if name == "define":
                parts = rest.split(None, 1)
                if parts:
                    macros[parts[0].split("(")[0]] = parts[1] if len(parts) > 1 and "(" not in parts[0] else ""
            elif name == "undef":
                macros.pop(rest, None)
            kept.append(line)
    return "\n".join(kept)


def _is_true(condition, macros):
    text = re.sub(r"\bdefined\s*\(?\s*(\w+)\s*\)?", lambda found: "1" if found.group(1) in macros else "0", condition)
    for _ in range(8):
        text = re.sub(r"\b[A-Za-z_]\w*", lambda found: macros.get(found.group(0), "0") or "0", text)
    tokens = re.findall(r"0[xX][0-9a-fA-F]+|\d+|&&|\|\||[=!<>]=|[-+*/%<>!()]", text)
    if "".join(tokens) != re.sub(r"\s", "", text):
        return True
    parser = _Condition(tokens)
    try:
        value = parser.binary(0)
    except (IndexError, ValueError, ZeroDivisionError, RecursionError):
        return True
    return value != 0


class _Condition:
    """Integer expressions by precedence."""

    LEVELS = (("||",), ("&&",), ("==", "!="), ("<", ">", "<=", ">="), ("+", "-"), ("*", "/", "%"))
    OPERATIONS = {"||": lambda a, b: a or b, "&&": lambda a, b: a and b, "==": lambda a, b: a == b,
                  "!=": lambda a, b: a != b, "<": lambda a, b: a < b, ">": lambda a, b: a > b,
                  "<=": lambda a, b: a <= b, ">=": lambda a, b: a >= b, "+": lambda a, b: a + b,
                  "-": lambda a, b: a - b, "*": lambda a, b: a * b, "/": lambda a, b: a // b, "%": lambda a, b: a % b}

    def __init__(self, tokens):
        self.tokens, self.at = tokens, 0

    def binary(self, level):
        if level == len(self.LEVELS):
            return self.unary()
        value = self.binary(level + 1)
        while self.at < len(self.tokens) and self.tokens[self.at] in self.LEVELS[level]:
            operation = self.OPERATIONS[self.tokens[self.at]]
            self.at += 1
            value = int(operation(value, self.binary(level + 1)))
        return value

    def unary(self):
        token = self.tokens[self.at]
        self.at += 1
        if token == "!":
            return int(not self.unary())
        if token == "-":
            return -self.unary()
        if token == "(":
            value = self.binary(0)
            if self.tokens[self.at] != ")":
                raise ValueError(token)
            self.at += 1
            return value
        return int(token, 0)
