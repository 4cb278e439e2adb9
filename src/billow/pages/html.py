"""One HTML file that needs nothing else: styles, scripts and data inside, and a policy that lets it load nothing.

The policy (Content-Security-Policy) names the SHA-256 of each script and style of the page, so that nothing else in it
can run, whatever a title or name holds. Our scripts are ES modules, one idea a file; browsers load no modules from a
disk, so they are joined into one classic script in the order of `load`.
"""

from __future__ import annotations

import base64
import hashlib
import html
import re
from collections.abc import Iterable
from importlib import resources

from billow import __version__

SIGN = b'name="generator" content="Billow'
"""What every page has near its beginning."""
_IMPORT = re.compile(r'^import \{[^}]*\} from "\./[\w]+\.js";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export ", re.MULTILINE)
LIBRARIES = "vendor.js"


def web_file(name: str) -> str:
    """The text of a file of `pages/web`."""
    return resources.files("billow.pages").joinpath("web", name).read_text(encoding="utf-8")


def page(title: str, body: str, modules: Iterable[str], data: bytes) -> str:
    """A page.

    title: any text; body: markup of ours; modules: files of `pages/web` in an order in which each comes after those it
    imports; data: from `packed.pack`, which the scripts find in the element "data"
    """
    script = joined(modules)
    libraries, style = _in_script(web_file(LIBRARIES)), web_file("vendor.css") + web_file("page.css")
    policy = "; ".join((
        "default-src 'none'", f"script-src {_hash(libraries)} {_hash(script)}", f"style-src {_hash(style)}",
        "img-src data: blob:", "base-uri 'none'", "form-action 'none'",
    ))  # fmt: skip
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8">
<meta name="generator" content="Billow {__version__}">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{html.escape(title)}</title>
<style>{style}</style></head>
<body>
{body}
<script type="text/plain" id="data">{base64.b64encode(data).decode()}</script>
<script>{libraries}</script>
<script>{script}</script>
</body></html>
"""


def joined(modules: Iterable[str]) -> str:
    """ES modules as one script, whose names stay inside it."""
    text = "".join(f"// {name}\n{_EXPORT.sub('', _IMPORT.sub('', web_file(name)))}" for name in modules)
    return _in_script(f'"use strict";\n(() => {{\n{text}}})();\n')


def _in_script(text: str) -> str:
    """A script whose text cannot end its element. ValueError if it would have to change to be one."""
    if re.search(r"</script|<!--", text, re.IGNORECASE):
        raise ValueError("a script holds the end of a script")
    return text


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
