"""What `./hotbed validate fuzz` does to an input: text that is cut, doubled, swapped, flipped; numbers at and beyond every limit."""

import math
import re

PLAIN = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")  # a number in anybody's reading
WORDS = ["0", "-0", "1", "-1", "2.5", "+2", ".5", "5.", "1e-300", "1e-320", "1e-400", "1e300", "1e309", "-1e309", "9" * 400, "nan", "-nan",
         "NaN", "inf", "-inf", "infinity", "1e", "e5", "1e+", "--2", "1.2.3", "1,5", "1d3", "0x10", "2147483647", "2147483648", "-2147483649",
         "1e99999", "true", "on", "yes", "none", "%s%n%d", "x" * 3000, "\u00fc", "\\", "~", "*", "v_x", "c_1", "f_cg"]
MARKS = ["", ";", "{", "}", "(", ")", "[", "]", "\"", "'", "$", "${", "#", "//", "/*", "*/", "&", "\n", "\t", "\0", "\x7f", "\x80", "\xff", "\r\n"]


def number(dice, key):
    """A word to stand where a key wants a number."""
    limits = [float(limit) for limit in re.findall(r"[<>]=? (-?[\d.e+-]+\d)", key.range.replace(",", ""))]
    near = [repr(value) for limit in limits for value in (limit, math.nextafter(limit, math.inf), math.nextafter(limit, -math.inf), -limit)]
    if dice.random() < 0.3:
        return f"{dice.choice(['', '-'])}{10 ** dice.uniform(-12, 13):.{dice.randrange(1, 17)}g}"
    return dice.choice(WORDS + near)


def allowed(key, word):
    """Whether a word is a number in the range of a key: True, False, or None where readers of numbers may differ."""
    if PLAIN.fullmatch(word):
        right = key.holds(float(word)) and math.isfinite(float(word))
        simple = re.fullmatch(r"-?\d+(\.\d+)?(e[+-]?\d+)?", word) and (float(word) == 0 or abs(float(word)) > 1e-300)
        return (True if simple else None) if right else False
    if re.fullmatch(r"[+-]?(nan|inf|infinity)", word, re.I):
        return False
    return None


def text(dice, content, most=3):
    """A text with up to `most` things wrong; bytes, for not all of it is UTF-8."""
    data = content.encode()
    for _ in range(dice.randint(1, most)):
        lines = data.split(b"\n")
        at = dice.randrange(len(data) + 1)
        kind = dice.randrange(9)
        if kind == 0:
            data = data[:at]
        elif kind == 1:
            data = data[:at] + bytes([dice.randrange(256)]) + data[at + dice.randrange(2):]
        elif kind == 2:
            data = data[:at] + dice.choice(MARKS).encode("latin-1") + data[at:]
        elif kind == 3:
            end = min(len(data), at + dice.randrange(1, 40))
            data = data[:at] + data[end:]
        elif kind == 4:
            lines.insert(dice.randrange(len(lines) + 1), dice.choice(lines))
            data = b"\n".join(lines)
        elif kind == 5:
            del lines[dice.randrange(len(lines))]
            data = b"\n".join(lines)
        elif kind == 6:
            a, b = dice.randrange(len(lines)), dice.randrange(len(lines))
            lines[a], lines[b] = lines[b], lines[a]
            data = b"\n".join(lines)
        else:
            words = list(re.finditer(rb"[^\s;]+", data))
            if words:
                word = dice.choice(words)
                data = data[:word.start()] + dice.choice(WORDS).encode() + data[word.end():]
    return data


def words(dice, line, first):
    """A line of words of which those from number `first` on have one thing wrong."""
    parts = line.split()
    at = dice.randrange(first, len(parts)) if len(parts) > first else len(parts)
    kind = dice.randrange(6)
    if kind == 0:
        del parts[at:at + 1]
    elif kind == 1:
        parts.insert(at, parts[min(at, len(parts) - 1)])
    elif kind == 2:
        parts.insert(at, dice.choice(WORDS))
    elif kind == 3:
        other = dice.randrange(first, len(parts)) if len(parts) > first else at
        if max(at, other) < len(parts):
            parts[at], parts[other] = parts[other], parts[at]
    elif kind == 4:
        del parts[at:]
    elif at < len(parts):
        parts[at] = text(dice, parts[at], 1).decode("latin-1").replace("\n", " ")
    return " ".join(parts)
