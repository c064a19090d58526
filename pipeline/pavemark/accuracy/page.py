"""The report as one page: what each stage says, with its figures in it and nothing outside it."""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping, Sequence
from html import escape

from markdown_it import MarkdownIt

from pavemark.accuracy.report import Report

_STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 75em; margin: 2em auto; padding: 0 1em; color: #222; }
figure { margin: 1.5em 0; overflow-x: auto; }
svg, img { max-width: 100%; height: auto; }
table { border-collapse: collapse; margin: 1.5em 0; font-size: 14px; font-variant-numeric: tabular-nums; }
th, td { border-bottom: 1px solid #ddd; padding: 0.2em 0.8em; text-align: left; }
h1 { margin-top: 2em; }
"""

_PICTURE = re.compile(r'<img src="([^"]+)" alt="([^"]*)"\s*/?>')


def page(reports: Mapping[str, Report], left_out: Sequence[str]) -> str:
    """A page of HTML that refers to nothing outside itself.

    Parameters
    ----------
    reports : mapping of str to Report
        By stage. What they say is Markdown; pictures that it names are among their files.
    left_out : sequence of str
        A line for each stage that was asked for and not run.
    """
    parts = [f"<p><strong>{escape(line)}</strong></p>" for line in left_out]
    parts += [_section(stage, report) for stage, report in reports.items()]
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"<title>Pavemark: what accuracy costs</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        + "\n".join(parts)
        + "\n</body>\n</html>\n"
    )


def _section(stage: str, report: Report) -> str:
    # What images are called is in the text, so no HTML is taken from it.
    text = MarkdownIt("commonmark", {"html": False}).enable("table").render(report.told)
    shown = [name for name in report.files if name.endswith((".png", ".svg")) and f"]({name})" not in report.told]
    text += "".join(f'<p><img src="{escape(name)}" alt="{escape(name)}"></p>\n' for name in shown)
    text = _PICTURE.sub(lambda found: _inline(found[1], found[2], report), text)
    return f'<section id="{escape(stage)}">\n{text}</section>'


def _inline(name: str, words: str, report: Report) -> str:
    data = report.files[name]
    if name.endswith(".svg"):
        return f'<figure role="img" aria-label="{words}">{_within(data, name.removesuffix(".svg"))}</figure>'
    return f'<img src="data:image/png;base64,{base64.b64encode(data).decode()}" alt="{words}">'


def _within(svg: str, name: str) -> str:
    """An SVG as part of a page: without its prologue, and with ids that no other one there has."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r'\bid="', f'id="{name}-', svg)
    return re.sub(r'(url\(#|href="#)', rf"\g<1>{name}-", svg)
