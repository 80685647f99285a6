#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sentences and lines of the documentation: how long they may be, and how many words there are.

Looked at are the pages of docs/ outside code, tables and generated parts. A sentence has at most 40 words, those of a page
18 in the mean, and a line 120 characters. check_docs.py asks; `docs_prose.py --wrap FILE...` breaks long lines.
"""
import os
import re
import sys
import textwrap

SENTENCE = 40  # words
MEAN = 18  # words a sentence, over a page
LINE = 120  # characters

CODE = re.compile(r"```.*?```", re.S)
GENERATED = re.compile(r"<!-- generated:.*?<!-- end of generated -->", re.S)
ITEM = re.compile(r" *(?:[*+-]|\d+\.) +")


def blank(text, *patterns):
    """Without what the patterns find; lines keep their numbers."""
    for pattern in patterns:
        text = pattern.sub(lambda found: "\n" * found.group(0).count("\n"), text)
    return text


def blocks(text):
    """Paragraphs and list items: number of the first line, text in one line."""
    first, lines = 0, []
    for number, line in enumerate(blank(text, CODE, GENERATED).split("\n") + [""], 1):
        plain = line.strip()
        ends = not plain or plain.startswith(("|", "#", "<", "```")) or (line.startswith("    ") and not lines)
        if lines and (ends or ITEM.match(line)):
            yield first, " ".join(lines)
            lines = []
        if not ends:
            first = first if lines else number
            mark = ITEM.match(line)
            lines.append(line[mark.end():].strip() if mark and not lines else plain)


def sentences(text):
    """Line of the paragraph, number of words and text of each sentence. Links count as their text, code in a line as a word."""
    for line, block in blocks(text):
        block = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", block)
        block = re.sub(r"`[^`]*`", "Code", block)
        for sentence in re.split(r"(?<=[.!?])[\"')*_]*\s+(?=[^a-z])", block):
            words = [word for word in sentence.split() if re.search(r"\w", word)]
            if words:
                yield line, len(words), sentence


def words(text):
    """Words of a page with its tables and its code, without generated parts: what has a letter, links by their text."""
    text = re.sub(r"\]\([^)]*\)", "]", blank(text, GENERATED))
    return sum(bool(re.search(r"[^\W\d_]", word)) for word in text.split())


def breaches(text):
    """Line and rule of what does not keep the limits."""
    found = list(sentences(text))
    for line, count, sentence in found:
        if count > SENTENCE:
            yield line, f"a sentence of {count} words, more than {SENTENCE}: {sentence[:50]}…"
    mean = sum(count for _, count, _ in found) / max(1, len(found))
    if mean > MEAN:
        yield 1, f"sentences of {mean:.1f} words in the mean, more than {MEAN}"
    for number, line in enumerate(blank(text, CODE, GENERATED).split("\n"), 1):
        if len(line) > LINE and not line.lstrip().startswith("|"):
            yield number, f"a line of {len(line)} characters, more than {LINE}: scripts/docs_prose.py --wrap breaks it"


def wrap(text):
    """The text with its paragraphs and list items broken at 120 characters; code in a line stays in one."""
    out, lines, code = [], [], ""

    def flush():
        if lines:
            mark = ITEM.match(lines[0])
            head = mark.group(0) if mark else re.match(" *", lines[0]).group(0)
            body = " ".join([lines[0][len(head):].strip()] + [line.strip() for line in lines[1:]])
            body = re.sub(r"`[^`]*`", lambda found: found.group(0).replace(" ", "\0"), body)
            # What would begin an item, a quotation or a table does not begin a line.
            body = re.sub(r" (?=(?:[-+*>#=]+|\d+[.)])(?: |$)|[|<])", "\0", body)
            out.append(textwrap.fill(body, LINE, initial_indent=head, subsequent_indent=" " * len(head),
                                     break_long_words=False, break_on_hyphens=False).replace("\0", " "))
            lines.clear()

    for line in text.split("\n"):
        plain = line.strip()
        ends = not plain or plain.startswith(("|", "#", "<", "```", "[!")) or (line.startswith("    ") and not lines)
        if code or ends:
            flush()
            out.append(line)
            if plain.startswith(code or "```") or plain.startswith(code or "<!-- generated:"):
                code = "" if code else "```" if plain.startswith("```") else "<!-- end of generated"
            continue
        if ITEM.match(line):
            flush()
        lines.append(line)
    flush()
    return "\n".join(out)


def main():
    if len(sys.argv) < 3 or sys.argv[1] != "--wrap":
        sys.exit(__doc__.strip())
    for name in sys.argv[2:]:
        with open(name, encoding="utf-8") as file:
            text = file.read()
        wrapped = wrap(text)
        if wrapped != text:
            with open(name, "w", encoding="utf-8") as file:
                file.write(wrapped)
            print(os.path.relpath(name))


if __name__ == "__main__":
    main()
