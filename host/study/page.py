# SPDX-License-Identifier: MIT
"""index.html: each figure beside its claims, then the text of claims.md."""
import html
import re

HEAD = """<!DOCTYPE html>
<html lang="en"><meta charset="utf-8"><title>The published study</title>
<style>
body { font: 15px/1.45 sans-serif; max-width: 80em; margin: 2em auto; padding: 0 1em; color: #222 }
table { border-collapse: collapse } th, td { border: 1px solid #ccc; padding: .3em .5em; text-align: left; vertical-align: top }
section { display: flex; flex-wrap: wrap; gap: 2em; border-top: 1px solid #ccc; padding: 1em 0 }
section > img { flex: 3 1 30em; min-width: 0; max-width: 48em; align-self: flex-start } section > div { flex: 2 1 22em }
h3 { font-size: 1em; margin: 1.2em 0 .3em } section p { margin: .3em 0 }
</style>
"""


def inline(text):
    """Code, bold words and links of a line in Markdown."""
    text = html.escape(text, quote=False)
    text = re.sub(r"\[([^]]*)\]\(([^)]*)\)", r'<a href="\2">\1</a>', text)
    text = re.sub(r"\*\*([^*]+)\*\*", r"<b>\1</b>", re.sub(r"`([^`]*)`", r"<code>\1</code>", text))
    return re.sub(r"\\([*|])", r"\1", text)


def cells_of(line):
    return [inline(cell.strip()) for cell in re.split(r"(?<!\\)\|", line.strip().strip("|"))]


def body_of(text):
    """Headings, tables, quotations and paragraphs."""
    parts = []
    for block in re.split(r"\n\n+", text.strip()):
        if heading := re.fullmatch(r"(#+) (.*)", block):
            parts.append(f"<h{len(heading[1])}>{inline(heading[2])}</h{len(heading[1])}>")
        elif block.startswith("|"):
            first, _, *lines = block.split("\n")
            rows = ["<th>".join(["<tr>", *cells_of(first)])] + ["<td>".join(["<tr>", *cells_of(line)]) for line in lines]
            parts.append("\n".join(["<table>", *rows, "</table>"]))
        elif block.startswith("> "):
            parts.append(f"<blockquote>{inline(block[2:])}</blockquote>")
        else:
            parts.append(f"<p>{inline(block)}</p>")
    return "\n".join(parts)


def page_of(text, figures):
    """The page, from claims.md and the names of the figures."""
    count, _, text = text.partition("\n\n")
    rows = re.findall(r"^\| \d.*\*\*.*\|$", text, re.M)  # the table of claims, which have a verdict in bold
    sections = []
    for name in figures:
        of_figure = [cells_of(row) for row in rows if f"figures/{name}.png" in row]
        claims = [f"<h3>{number}. {claim}</h3>\n<p>{verdict}</p>\n<p>Computed: {computed}</p>\n"
                  for number, claim, computed, verdict in of_figure]
        heading = name.replace("_0", " ").replace("_", " ").capitalize()
        sections.append(f'<section id="{name}"><img src="figures/{name}.png" alt="{heading}">\n<div>'
                        f"{''.join(claims) or '<p>The study claims nothing about this picture.</p>'}</div></section>\n")
    return (f"{HEAD}<h1>{count}</h1>\n<p>The published study, figure by figure. Below stand all claims in a table, and what else "
            f"was computed, as in <a href=\"claims.md\">claims.md</a>.</p>\n{''.join(sections)}{body_of(text)}\n</html>\n")
