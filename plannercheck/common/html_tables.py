"""Tables as notebooks show them.

In: a line of words, a header, rows of texts. Out: HTML, in which every text is escaped.
"""

from __future__ import annotations

import html
from collections.abc import Sequence

# More rows than these are counted instead.
_MOST_ROWS = 40


def html_table(title: str, header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A table under a line of words; the line alone if there are no rows."""
    line = f"<p>{html.escape(title)}</p>"
    if not rows:
        return line
    shown = [_row(row) for row in rows[:_MOST_ROWS]]
    if len(rows) > _MOST_ROWS:
        shown.append(_row([f"… and {len(rows) - _MOST_ROWS} more"]))
    return f"{line}<table>{_row(header, 'th')}{''.join(shown)}</table>"


def _row(cells: Sequence[object], tag: str = "td") -> str:
    return f"<tr>{''.join(f'<{tag}>{html.escape(str(cell))}</{tag}>' for cell in cells)}</tr>"
