"""Compares Stiction with MuJoCo, Pinocchio, Drake and Exudyn. `python run.py --help` says how."""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from dataclasses import asdict
from pathlib import Path

# Small dense systems: threads only get in each other's way.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import drive_trains  # noqa: E402
import forward  # noqa: E402
import variants  # noqa: E402
from closed_loop import ClosedLoop  # noqa: E402
from compare import LIMIT, Agreement, compare  # noqa: E402
from counts import Count, count, gallery  # noqa: E402
from creep import Creep, measure  # noqa: E402
from engines.drake_tree import Drake  # noqa: E402
from engines.exudyn_bodies import Exudyn  # noqa: E402
from engines.mujoco_tree import Mujoco  # noqa: E402
from engines.pinocchio_tree import Pinocchio  # noqa: E402
from forward_report import (  # noqa: E402
    COLUMNS,
    CREEP_COLUMNS,
    ForwardLine,
    creep_cells,
    creep_differs,
    forward_beyond,
    forward_cells,
    forward_terminal,
    sections,
    sections_differ,
    write_sections,
    write_table,
)
from program import Case, Program, Refused  # noqa: E402
from report import (  # noqa: E402
    Line,
    beyond_bounds,
    page_differs,
    read_bounds,
    terminal_table,
    write_bounds,
    write_page,
)
from selftest import Maker, unnoticed  # noqa: E402

HERE = Path(__file__).resolve().parent
BOUNDS = HERE / "agreement.csv"
FORWARD, CREEP = HERE / "forward.csv", HERE / "creep.csv"
PAGE = HERE.parent / "docs" / "src" / "engines.md"
SEED, VARIANTS = 20180909, 3
CREEP_PROVENANCE = "Rates in rad/s, to two digits, by validation/run.py; columns are explained in validation/README.md"

#: time between samples, s: a dozen samples of the default motion, none at a reversal but a motion's beginning
STEPS = {
    "3rps": 0.0879,
    "zhang2018-regular": 0.0879,
    "gough": 0.3517,
    "delta": 0.0439,
    "3rrr": 0.0879,
    "five-bar": 0.0439,
    "slider-crank": 0.0553,
}

ENGINES = {
    "MuJoCo": (lambda case: ClosedLoop(Mujoco(case.mjcf, case.mechanism), case.mechanism), Mujoco.version),
    "Pinocchio": (lambda case: ClosedLoop(Pinocchio(case.mjcf, case.mechanism), case.mechanism), Pinocchio.version),
    "Drake": (lambda case: ClosedLoop(Drake(case.mjcf, case.mechanism), case.mechanism), Drake.version),
    "Exudyn": (lambda case: Exudyn(case.mechanism), Exudyn.version),
}


def main() -> int:
    options = arguments()
    say = lambda text: print(text, file=sys.stderr, flush=True)  # noqa: E731
    program = Program(options.stiction)
    started = time.monotonic()
    complaints: list[str] = []
    lines: list[Line] = []
    forward_lines: list[ForwardLine] = []
    creeping: list[Creep] = []
    agreeing = 0
    originals: dict[str, Case] = {}
    makers: dict[str, Maker] = {name: ENGINES[name][0] for name in options.engines}
    with tempfile.TemporaryDirectory(prefix="stiction-validation-") as temporary:
        folder = options.keep or Path(temporary)
        for model in options.models:
            begun = time.monotonic()
            cases, refused = draw(program, model, options.variants, options.seed, folder)
            originals[model] = cases[0]
            for engine, maker in makers.items():
                line, trouble = over_variants(model, engine, maker, cases)
                lines.append(line)
                agreeing += not trouble
                complaints += trouble
            drawn = f"{len(cases) - 1} variants" + (f" ({refused} refused)" if refused else "")
            say(f"validation: {model}, {drawn}, {time.monotonic() - begun:.1f} s")
        counted = counts(program, folder) if "Exudyn" in options.engines else []
        say(f"validation: {len(counted)} counts of freedoms")
        if {"MuJoCo", "Pinocchio"} <= set(options.engines):
            geared = drive_trains.measure(program, folder)
            complaints += [words for one in geared for words in one.complaints()]
            worst = max(one.difference for one in geared)
            say(f"validation: torques of {len(geared)} geared motors, differences up to {worst:.1e}")
        if options.self_test:
            for model in ("3rps", "five-bar"):
                if model in originals:
                    complaints += unnoticed(originals[model], makers)
            say("validation: self-test")
        for model in options.forward:
            begun = time.monotonic()
            lines_of_model, trouble = over_runs(program, model, options, folder)
            forward_lines += lines_of_model
            complaints += trouble
            say(f"validation: {model}, forward, {time.monotonic() - begun:.1f} s")
        if options.forward:
            creeping = measure(program, folder)
            complaints += [words for one in creeping for words in one.complaints()]

    complaints += [
        f"{c.model}: freedoms and redundant constraints {c.ours}, by Exudyn {c.exudyn}"
        for c in counted
        if not c.agrees()
    ]
    print(terminal_table(lines))
    if options.forward:
        print(forward_terminal(forward_lines, creeping))
    is_whole = (
        list(options.models) == list(STEPS)
        and list(options.engines) == list(ENGINES)
        and list(options.forward) == list(forward.SETTINGS)
    )
    if options.write and not is_whole:
        complaints.append("--write needs all models and engines: a part would replace the whole")
    elif options.write and not complaints:
        write_bounds(BOUNDS, lines, provenance(options))
        write_page(PAGE, read_bounds(BOUNDS))
        write_table(FORWARD, COLUMNS, [forward_cells(line) for line in forward_lines], provenance(options))
        write_table(CREEP, CREEP_COLUMNS, [creep_cells(one) for one in creeping], CREEP_PROVENANCE)
        write_sections(PAGE, sections(FORWARD, CREEP))
    elif is_standard(options):
        complaints += beyond_bounds(lines, read_bounds(BOUNDS))
        complaints += forward_beyond(forward_lines, read_bounds(FORWARD))
        complaints += creep_differs(creeping, read_bounds(CREEP))
        if page_differs(PAGE, read_bounds(BOUNDS)):
            complaints.append(f"the table in {PAGE.name} is not that of {BOUNDS.name}: run with --write")
        if sections_differ(PAGE, sections(FORWARD, CREEP)):
            complaints.append(f"tables in {PAGE.name} are not those of {FORWARD.name}, {CREEP.name}: run with --write")
    if options.json:
        write_json(options.json, lines, counted, forward_lines, creeping, complaints)
    for complaint in complaints:
        print(f"validation: {complaint}")
    print(
        f"validation: {len(lines)} comparisons, {agreeing} agree; "
        f"{len(counted)} counts, {sum(c.agrees() for c in counted)} agree; "
        f"{len(forward_lines)} forward; {time.monotonic() - started:.0f} s"
    )
    return 1 if complaints else 0


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--stiction", type=Path, required=True, metavar="PATH", help="the program to validate")
    parser.add_argument("--variants", type=int, default=VARIANTS, help="random variations of each model")
    parser.add_argument("--seed", type=int, default=SEED, help="of the random variations")
    parser.add_argument("--models", nargs="+", choices=STEPS, default=list(STEPS), metavar="MODEL")
    parser.add_argument("--engines", nargs="+", choices=ENGINES, default=list(ENGINES), metavar="ENGINE")
    parser.add_argument(
        "--forward",
        nargs="*",
        choices=forward.SETTINGS,
        default=list(forward.SETTINGS),
        metavar="MODEL",
        help="models of which the forward dynamics is compared; without a name, none",
    )
    parser.add_argument("--self-test", action="store_true", help="also show that each comparison can fail")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all numbers into this file")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keep models, exports and tables in this folder")
    parser.add_argument("--write", action="store_true", help="write agreement.csv and the table of the book's page")
    return parser.parse_args()


def is_standard(options: argparse.Namespace) -> bool:
    """Whether the numbers are those for which agreement.csv has bounds."""
    return (options.seed, options.variants) == (SEED, VARIANTS)


def provenance(options: argparse.Namespace) -> str:
    return (
        f"Largest relative differences, rounded up, by validation/run.py --seed {options.seed} "
        f"--variants {options.variants}; columns are explained in validation/README.md"
    )


def draw(program: Program, model: str, wanted: int, seed: int, folder: Path) -> tuple[list[Case], int]:
    """The model as it is and its variations, and how many variations the program refused."""
    original = program.text(model)
    text = variants.physical(original)
    cases = [program.case(model, 0, original, STEPS[model], folder / model / "0")]
    refused = 0
    while len(cases) <= wanted:
        number = len(cases) + refused
        varied = variants.vary(model, text, seed + number)
        try:
            cases.append(program.case(model, number, varied, STEPS[model], folder / model / str(number)))
        except Refused as reason:
            refused += 1
            if refused > 5 * wanted:
                raise RuntimeError(f"{model}: too many variations are refused; the last: {reason}") from reason
    return cases, refused


def over_variants(model: str, engine: str, maker: Maker, cases: list[Case]) -> tuple[Line, list[str]]:
    """The largest differences of an engine over a model's variations, and where it does not agree."""
    worst = [0.0] * 5
    samples, trouble = 0, []
    for case in cases:
        solver = maker(case)
        without = compare(solver, case, with_friction=False)
        rubbing = compare(solver, case, with_friction=True)
        samples += without.samples
        numbers = (
            without.drives(),
            without.reactions(),
            rubbing.drives(),
            rubbing.reactions(),
            rubbing.contact_loads(),
        )
        worst = [max(pair) for pair in zip(worst, numbers)]
        trouble += [
            f"{model}, {engine}: variant {case.variant}, {words}: {in_words(found)}"
            for words, found in (("frictionless", without), ("with friction", rubbing))
            if not found.agrees()
        ]
    return Line(model, engine, ENGINES[engine][1], samples, len(cases) - 1, *worst), trouble


def over_runs(
    program: Program, model: str, options: argparse.Namespace, folder: Path
) -> tuple[list[ForwardLine], list[str]]:
    """The largest differences of a model's forward dynamics, and where it does not agree."""
    found: dict[bool, list[forward.Agreement]] = {False: [], True: []}
    trouble = []
    for case in forward.draw(program, model, options.variants, options.seed, folder):
        agreement = forward.compare(case)
        found[case.viscous].append(agreement)
        if not agreement.agrees():
            kind = "viscous" if case.viscous else "frictionless"
            trouble.append(f"{model}, forward, variant {case.variant}, {kind}: {agreement.in_words()}")
        if options.self_test and case.variant == 0:
            trouble += forward.unnoticed(case)
    versions = Exudyn.version, Pinocchio.version
    return [ForwardLine.of(model, viscous, versions, runs) for viscous, runs in found.items()], trouble


def in_words(found: Agreement) -> str:
    words = f"drives {found.drives():.1e}, reactions {found.reactions():.1e}, loads {found.contact_loads():.1e}"
    words += f" (limit {LIMIT:.0e}); places {found.place:.1e} m, balance {found.balance:.1e}"
    return words + (f"; no reaction of {', '.join(sorted(found.missing))}" if found.missing else "")


def counts(program: Program, folder: Path) -> list[Count]:
    return [count(program, model, folder / model / "count") for model in gallery(program)]


def write_json(
    path: Path,
    lines: list[Line],
    counted: list[Count],
    forward_lines: list[ForwardLine],
    creeping: list[Creep],
    complaints: list[str],
) -> None:
    data = {
        "comparisons": [asdict(line) for line in lines],
        "counts": [asdict(c) for c in counted],
        "forward": [asdict(line) for line in forward_lines],
        "creep": [asdict(one) for one in creeping],
        "complaints": complaints,
    }
    path.write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
