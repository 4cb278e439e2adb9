"""`make vendor`: bundle three.js and uPlot into src/billow/pages/web/vendor.js, with their licences at its end.

Needs npm; users and tests do not. The same versions give the same bytes.
"""

from __future__ import annotations

import hashlib
import json
import subprocess
from pathlib import Path

HERE = Path(__file__).parent
WEB = HERE.parent / "src" / "billow" / "pages" / "web"
LICENCES = {"three": "LICENSE", "uplot": "LICENSE"}


def main() -> None:
    modules = HERE / "node_modules"
    subprocess.run(["npm", "ci", "--no-audit", "--no-fund", "--ignore-scripts"], cwd=HERE, check=True)
    bundle = subprocess.run(
        [modules / ".bin" / "esbuild", "entry.mjs", "--bundle", "--minify", "--format=iife", "--global-name=VENDOR",
         "--charset=utf8", "--legal-comments=eof", "--supported:template-literal=false"],
        cwd=HERE, check=True, capture_output=True, text=True,
    ).stdout  # fmt: skip
    notices, versions = [], {}
    for name, file in LICENCES.items():
        told = json.loads((modules / name / "package.json").read_text(encoding="utf-8"))
        versions[name] = {"version": told["version"], "licence": told["license"]}
        notices.append(f"{name} {told['version']}\n\n{(modules / name / file).read_text(encoding='utf-8').strip()}")
    text = bundle.rstrip() + "\n" + "".join(f"/*!\n{notice}\n*/\n" for notice in notices)
    style = (modules / "uplot" / "dist" / "uPlot.min.css").read_text(encoding="utf-8").strip() + "\n"
    (WEB / "vendor.js").write_text(text, encoding="utf-8")
    (WEB / "vendor.css").write_text(style, encoding="utf-8")
    sums = {name: hashlib.sha256((WEB / name).read_bytes()).hexdigest() for name in ("vendor.js", "vendor.css")}
    record = json.dumps({"packages": versions, "sha256": sums}, indent=1) + "\n"
    (WEB / "vendor.json").write_text(record, encoding="utf-8")


if __name__ == "__main__":
    main()
