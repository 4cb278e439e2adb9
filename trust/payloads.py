"""Texts that programs have been tricked with, put wherever Billow takes a text: all must stay texts.

An attack succeeds if a canary file appears, if anything is written outside the folder meant for output, if a text is
kept as something else than itself, or if anything shows the product that many of the texts ask for.
"""

from __future__ import annotations

import contextlib
import copy
import dataclasses
import os
import shutil
import tempfile
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from random import Random

import tomli_w

from billow.base.errors import BillowError
from billow.case.schema import Case
from billow.cli import demo
from billow.cli.options import parse_settings
from billow.results.result import Result
from billow.rom.surrogate.prediction import describe_surrogate
from billow.rom.surrogate.surrogate import Surrogate
from billow.run.check import describe
from billow.run.simulate import simulate
from billow.study.study import Study
from trust.generated_cases import EXAMPLE
from trust.mutations import damaged_file
from trust.small_surrogate import small_surrogate

CANARY = "CANARY"
EXPRESSION, PRODUCT = "2897*2981", "8635957"

PAYLOADS = [
    # Python, and what formats and evaluates it
    f"__import__('os').system('touch {CANARY}')",
    f"exec(\"open('{CANARY}','w')\")",
    f"eval('{EXPRESSION}')",
    EXPRESSION,
    f"lambda: {EXPRESSION}",
    "{0.__class__.__mro__}",
    "{self.__init__.__globals__}",
    "%(__class__)s",
    f"{{{EXPRESSION}}}",
    f"f'{{{EXPRESSION}}}'",
    "().__class__.__bases__[0].__subclasses__()",
    f"cos\nsystem\n(S'touch {CANARY}'\ntR.",
    f"!!python/object/apply:os.system ['touch {CANARY}']",
    f"@{CANARY}",
    # templates
    f"{{{{{EXPRESSION}}}}}",
    f"{{% set x = {EXPRESSION} %}}{{{{x}}}}",
    f"${{{EXPRESSION}}}",
    f"#{{{EXPRESSION}}}",
    f"<%= {EXPRESSION} %>",
    "{{ ''.__class__.__mro__[1].__subclasses__() }}",
    "[link=file:///etc/passwd]x[/link]",
    "$\\input{/etc/passwd}$",
    "<script>alert(1)</script>",
    # shells
    f"$(touch {CANARY})",
    f"`touch {CANARY}`",
    f"; touch {CANARY}",
    f"| touch {CANARY}",
    f"&& touch {CANARY}",
    f"x\ntouch {CANARY}",
    f"$(({EXPRESSION}))",
    f"--out={CANARY}",
    f"> {CANARY}",
    "$HOME",
    "~",
    # paths
    f"../{CANARY}",
    f"../../../../../../../../tmp/{CANARY}",
    f"..%2f{CANARY}",
    f"..\\{CANARY}",
    "/etc/passwd",
    "file:///etc/passwd",
    "/dev/zero",
    f"{CANARY}\0.toml",
    # numbers that are programs, terminals, spreadsheets
    "1;2",
    "1 if True else 2",
    "0x10",
    "1e5__import__",
    "\x1b]0;title\x07",
    "\x1b[31mred",
    f"=cmd|' /C touch {CANARY}'!A0",
    f'=HYPERLINK("http://example.com/{CANARY}")',
]


class Broken(Exception):
    """An attack succeeded."""


def kept(value: object, payload: str) -> None:
    """A text that was accepted must be the text that was given."""
    if value != payload:
        raise Broken(f"{payload!r} became {value!r}")


def fields(place: Path) -> dict[str, Callable[[str], str | None]]:
    """Everywhere a text is taken: name -> use of a payload, which returns what Billow then says of it."""

    def case(*path: str | int) -> Callable[[str], str]:
        def use(payload: str) -> str:
            data = copy.deepcopy(EXAMPLE)
            table = data
            for part in path[:-1]:
                table = table[part]
            table[path[-1]] = payload
            made = Case.from_dict(data).to_dict()
            for part in path:
                made = made[part]
            kept(made, payload)
            return describe(Case.from_dict(data))

        return use

    def new_key(payload: str) -> None:
        Case.from_dict({**EXAMPLE, payload: 1})

    def gas_name(payload: str) -> str:
        return describe(Case.from_dict({**EXAMPLE, "inflator": {"gas": {payload: 1.0}}}))

    def assigned_key(payload: str) -> None:
        Case.from_dict(EXAMPLE).vary(parse_settings([f"{payload}=1"]))

    def assigned_value(payload: str) -> None:
        Case.from_dict(EXAMPLE).vary(parse_settings([f"fabric.permeability={payload}"]))
        raise Broken(f"{payload!r} was taken for a number")

    def case_file(payload: str) -> None:
        (place / "payload.toml").write_bytes(f"title = {payload}\n".encode())
        Case.load(place / "payload.toml")
        raise Broken(f"{payload!r} was taken for TOML")

    def case_path(payload: str) -> None:
        Case.load(payload)

    def study(name: str) -> Callable[[str], None]:
        def use(payload: str) -> None:
            content = tomllib.loads(demo.STUDY.format(train=2, test=1))
            table = content if name in content else content["parameters"][0]
            table[name] = [payload] if name == "keys" else payload
            (place / "study.toml").write_text(tomli_w.dumps(content))
            made = Study.create(place / "study.toml", place / "out").definition
            if name != "case":
                kept(getattr(made, name, None) or getattr(made.parameters[0], name), payload)

        return use

    def run_name(payload: str) -> None:
        (place / "study.toml").write_text(demo.STUDY.format(train=2, test=1))
        made = Study.create(place / "study.toml", place / "out")
        path = made.folder / "design.csv"
        path.write_text(path.read_text().replace("0000", '"' + payload.replace('"', '""') + '"'))
        (made.folder / "split.toml").write_text(tomli_w.dumps({"train": [payload, "0001"], "test": ["0002"]}))
        opened = Study.open(made.folder)
        for run in opened.runs:
            if (opened.store.runs / run).resolve().parent != opened.store.runs.resolve():
                raise Broken(f"run {run!r} leads out of the study")

    def surrogate(**changes) -> str:
        made = dataclasses.replace(small_surrogate(), **changes)
        loaded = Surrogate.load(made.save(place / "out.safetensors"))
        return describe_surrogate(loaded)

    def surrogate_title(payload: str) -> str:
        return surrogate(title=payload)

    def surrogate_label(payload: str) -> str:
        first, second = small_surrogate().parameters
        return surrogate(parameters=(dataclasses.replace(first, label=payload), second))

    return {
        "case title": case("title"),
        "obstacle name": case("obstacles", 1, "name"),
        "obstacle shape": case("obstacles", 1, "shape"),
        "kind of bag": case("bag", "shape"),
        "gas model": case("gas", "model"),
        "fabric law": case("fabric", "law"),
        "quantity": case("fabric", "thickness"),
        "time of a curve": case("inflator", "mass_flow", "time"),
        "unknown key": new_key,
        "name of a gas": gas_name,
        "assigned key": assigned_key,
        "assigned value": assigned_value,
        "case file": case_file,
        "path of a case": case_path,
        "study title": study("title"),
        "case of a study": study("case"),
        "parameter name": study("name"),
        "parameter label": study("label"),
        "parameter unit": study("unit"),
        "parameter keys": study("keys"),
        "name of a run": run_name,
        "surrogate title": surrogate_title,
        "label in a surrogate": surrogate_label,
    }


def escapes() -> tuple[list[str], int]:
    """Attacks that succeeded, and how many were tried."""
    succeeded, tried = [], 0
    with tempfile.TemporaryDirectory(prefix="billow-escapes-") as folder, contextlib.chdir(folder):
        place = Path(folder) / "place"
        place.mkdir()
        (place / "case.toml").write_text(
            tomli_w.dumps({**EXAMPLE, "obstacles": [{"shape": "plate"}, {"shape": "super-ellipsoid"}]})
        )
        for name, use in fields(place).items():
            for payload in PAYLOADS:
                tried += 1
                problem = _attack(use, payload)
                problem = problem or _outside(Path(folder))
                if problem:
                    succeeded.append(f"{name}: {payload!r}: {problem}")
    return succeeded, tried


def _attack(use: Callable[[str], str | None], payload: str) -> str | None:
    """How an attack succeeded, or None."""
    try:
        said = use(payload) or ""
    except BillowError as error:
        said = str(error)
    except Exception as problem:
        return f"{type(problem).__name__}: {problem}"
    if PRODUCT in said and PRODUCT not in payload:
        return "it was evaluated"
    if "\x1b" in said:
        return "control characters reach the terminal"
    return None


def _outside(folder: Path) -> str | None:
    """What lies outside the folder meant for output, or None; the place is then cleaned for the next attack."""
    found = [path for path in folder.iterdir() if path.name != "place"]
    found += [Path("/tmp", CANARY)] if Path("/tmp", CANARY).exists() else []
    found += folder.rglob(f"*{CANARY}*")
    out = folder / "place" / "out"
    if out.exists():
        shutil.rmtree(out)
    for path in found:
        with contextlib.suppress(OSError):
            path.unlink()
    return f"it wrote {', '.join(path.name for path in found)}" if found else None


def security(surrogates: int = 10_000, runs: int = 1_000) -> Iterator[tuple[str, str, int, int]]:
    """(goal, promise, attacks that succeeded, attacks tried) for each goal."""
    random = Random(1)
    with tempfile.TemporaryDirectory(prefix="billow-security-") as folder:
        bundle = small_surrogate().save(Path(folder, "surrogate.safetensors"))
        loaded = _loaded(bundle, lambda: Surrogate.load(bundle), surrogates, random)
        yield "SEC-1", "surrogates changed after signing: none loads", loaded, surrogates
        run = simulate(Case.from_dict({**EXAMPLE, "run": {"end_time": 1e-4, "frames": 1}}), Path(folder, "run")).folder
        names = sorted(os.listdir(run))
        opened = sum(_loaded(run / name, lambda: Result.open(run), runs // len(names), random) for name in names)
        yield "SEC-1", "runs changed after publication: none opens", opened, runs // len(names) * len(names)
    succeeded, tried = escapes()
    yield "SEC-2", "escape payloads: none is executed or interpreted", len(succeeded), tried


def _loaded(path: Path, load: Callable[[], object], count: int, random: Random) -> int:
    """How many of so many damaged versions of a file are accepted."""
    sound, accepted = path.read_bytes(), 0
    for _ in range(count):
        path.write_bytes(damaged_file(path.name, sound, random))
        with contextlib.suppress(BillowError):
            load()
            accepted += 1
    path.write_bytes(sound)
    return accepted
