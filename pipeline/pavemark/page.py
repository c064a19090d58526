"""Reports as one page of HTML, with nothing outside it."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterable
from html import escape

_STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 75em; margin: 2em auto; padding: 0 1em; color: #222; }
figure { margin: 1.5em 0; overflow-x: auto; }
svg, img { max-width: 100%; height: auto; }
table { border-collapse: collapse; margin: 1.5em 0; font-size: 14px; font-variant-numeric: tabular-nums; }
th, td { border-bottom: 1px solid #ddd; padding: 0.2em 0.8em; text-align: left; }
h1 { margin-top: 2em; }
"""


def page(title: str, parts: Iterable[str], style: str = "") -> str:
    """A page.

    Parameters
    ----------
    title : str
        Plain text.
    parts : iterable of str
        HTML of what is on it, one below the other.
    style : str
        CSS that comes after that of all reports.
    """
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f"<title>{escape(title)}</title>\n<style>{_STYLE}{style}</style>\n</head>\n<body>\n"
        + "\n".join(parts)
        + "\n</body>\n</html>\n"
    )


def drawn(svg: str, name: str, words: str) -> str:
    """An SVG as part of a page: without its prologue, and with ids that no other one there has.

    Parameters
    ----------
    svg : str
    name : str
        Of the drawing, which no other one on the page has.
    words : str
        HTML text: what is to be seen, for who cannot see it.
    """
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r'\bid="', f'id="{name}-', svg)
    svg = re.sub(r'(url\(#|href="#)', rf"\g<1>{name}-", svg)
    return f'<figure role="img" aria-label="{words}">{svg}</figure>'


def pictured(data: bytes, words: str, kind: str = "png") -> str:
    """A picture, PNG or "jpeg", as part of a page; `words` as in `drawn`."""
    return f'<img src="data:image/{kind};base64,{base64.b64encode(data).decode()}" alt="{words}">'
