"""What all pages have in common, and how they look in a real browser on a phone and on a desk."""

import functools
import http.server
import re
import subprocess
import threading

import pytest
from browser import faults, needs_browser, page_after_scripts

from fsm_calib.report.pages import environment, finished, page

SIZES = (390, 1280)
PROBE = """<!doctype html><body><iframe id=f src="page.html" width="{width}" height="900"></iframe><script>
document.getElementById("f").onload = e => {{
  const root = e.target.contentDocument.documentElement;
  document.body.dataset.wide = root.scrollWidth;
}};</script></body>"""


def sample() -> str:
    figure = '<svg role="img" aria-label="wide" viewBox="0 0 1100 300"><text x="5" y="20">a wide figure</text></svg>'
    table = "<table><tr>" + "<td>a cell of some width</td>" * 12 + "</tr></table>"
    body = "".join(
        f"<section><h2>Part {n}</h2>{figure}{table}<pre>{'long ' * 60}</pre></section>" for n in range(4)
    )
    style = environment().from_string('<style>{% include "page.css" %}</style>').render()
    head = '<meta name="viewport" content="width=device-width"><title>t</title>'
    return finished(
        f"<!doctype html><html><head>{head}{style}</head><body><header><h1>x</h1></header><main>{body}</main>"
    )


def test_wide_figures_and_tables_scroll_inside_the_page() -> None:
    html = sample()
    assert html.count('<div class="wide" style="--width: 1100px"><svg') == 4
    assert html.count('<div class="scroll"><table') == 4


def test_contents_name_every_section_once() -> None:
    html = sample()
    assert [f'href="#part-{n}"' in html for n in range(4)] == [True] * 4


def test_short_pages_have_no_contents() -> None:
    assert "nav" not in finished("<header></header><section><h2>One</h2></section>")


def test_missing_value_of_a_template_is_an_error() -> None:
    from jinja2 import UndefinedError

    with pytest.raises(UndefinedError):
        page("study.html.j2")


@needs_browser
def test_what_is_wrong_with_a_page_is_told(tmp_path) -> None:
    figure = '<svg width="200" height="40"><text x="150" y="20">beyond the edge</text></svg>'
    body = '<p style="color: #bbb; background: #fff">faint</p><p style="width: 2000px; color: CanvasText">wide</p>'
    html = f"<!doctype html><body>{body}{figure}<script>nothing.here()</script></body>"
    found = " ".join(faults({"bad": html}, tmp_path))
    for fault in ("faint: faint 1.92:1", "scrolls sideways", "cut by its figure: beyond", "console: "):
        assert fault in found


@needs_browser
@pytest.mark.parametrize("width", SIZES)
def test_page_never_scrolls_sideways(tmp_path, width) -> None:
    (tmp_path / "page.html").write_text(sample())
    (tmp_path / "probe.html").write_text(PROBE.format(width=width))
    handler = functools.partial(_Quiet, directory=str(tmp_path))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        html = page_after_scripts(f"http://127.0.0.1:{server.server_address[1]}/probe.html", tmp_path)
    except subprocess.TimeoutExpired:
        pytest.skip("the browser did not answer in time")
    finally:
        server.shutdown()
        server.server_close()
    told = re.search(r'data-wide="(\d+)"', html)
    assert told is not None
    assert int(told[1]) <= width


class _Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, format, *args) -> None:
        pass
