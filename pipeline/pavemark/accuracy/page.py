"""The report as one page: what each stage says, with its figures in it and nothing outside it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from html import escape

from markdown_it import MarkdownIt

from pavemark.accuracy.report import Report
from pavemark.page import drawn, pictured
from pavemark.page import page as document

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
    return document("Pavemark: what accuracy costs", parts)


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
        return drawn(data, name.removesuffix(".svg"), words)
    return pictured(data, words)
