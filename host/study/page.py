# SPDX-License-Identifier: MIT
"""index.html: each figure beside its claims, then the text of claims.md."""
import html
import re

HEAD = """<!DOCTYPE html>
<html lang="en"><meta charset="utf-8"><title>The published study</title>
<style>
body { font: 15px/1.45 sans-serif; max-width: 78em; margin: 2em auto; padding: 0 1em; color: #222 }
table { border-collapse: collapse; margin: 1em 0 } th, td { border: 1px solid #ccc; padding: .3em .5em; text-align: left; vertical-align: top }
section { display: flex; flex-wrap: wrap; gap: 1.5em; border-top: 1px solid #ccc; padding: 1em 0 }
figure { margin: 0; flex: 3 1 30em } img { max-width: 100% } section > div { flex: 2 1 24em }
</style>
"""


def inline(text):
    """Code, bold and slanted words, and links, of a line in Markdown."""
    text = html.escape(text, quote=False)
    text = re.sub(r"\[([^]]*)\]\(([^)]*)\)", r'<a href="\2">\1</a>', text)
    for pattern, tag in (r"`([^`]*)`", "code"), (r"\*\*([^*]+)\*\*", "b"), (r"(?<!\\)\*([A-Z][^*]*)(?<!\\)\*", "i"):
        text = re.sub(pattern, rf"<{tag}>\1</{tag}>", text)
    return re.sub(r"\\([*|])", r"\1", text)


def row_of(line, tag="td"):
    cells = re.split(r"(?<!\\)\|", line.strip().strip("|"))
    return "<tr>" + "".join(f"<{tag}>{inline(cell.strip())}</{tag}>" for cell in cells) + "</tr>\n"


def table_of(lines):
    return f"<table>\n{row_of(lines[0], 'th')}{''.join(map(row_of, lines[2:]))}</table>\n"


def body_of(text):
    """Headings, tables, quotations and paragraphs."""
    parts = []
    for block in re.split(r"\n\n+", text.strip()):
        lines = block.split("\n")
        if heading := re.fullmatch(r"(#+) (.*)", block):
            level = len(heading[1])
            parts.append(f"<h{level}>{inline(heading[2])}</h{level}>\n")
        elif block.startswith("|"):
            parts.append(table_of(lines))
        elif block.startswith("> "):
            parts.append(f"<blockquote>{inline(block[2:])}</blockquote>\n")
        else:
            parts.append(f"<p>{inline(block)}</p>\n")
    return "".join(parts)


def page_of(text, figures):
    """The page, from claims.md and the names of the figures."""
    count, _, text = text.partition("\n\n")
    rows = re.findall(r"^\|.*\|$", text, re.M)
    first = rows[:next(i for i, row in enumerate(rows) if i > 1 and not re.match(r"\| \d", row))]  # the table of claims
    sections = []
    for name in figures:
        of_figure = [row for row in first[2:] if f"figures/{name}.png" in row]
        claims = table_of(first[:2] + of_figure) if of_figure else "<p>The study claims nothing about this figure.</p>"
        heading = name.replace("_0", " ").replace("_", " ").capitalize()
        sections.append(f'<section id="{name}"><figure><img src="figures/{name}.png" alt="{heading}"></figure>\n'
                        f"<div>{claims}</div></section>\n")
    return (f"{HEAD}<h1>{count}</h1>\n<p>The published study, figure by figure; below, all claims and what else was computed, "
            f"which is also in <a href=\"claims.md\">claims.md</a>.</p>\n{''.join(sections)}{body_of(text)}</html>\n")
