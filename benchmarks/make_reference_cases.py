"""Compute the reference cases that accuracy is measured against.

Draws designs uniformly on the simplex r1 + r2 + r3 = 3, some from the assemblable space
(r3 <= 1.5) and some from the surrounded space (r1 >= r3 and r2 >= r3), each with a mode pair
uniform over all eight and an LCI threshold uniform in (0.1, 0.9), and evaluates each with
``tests/reference.py``. The cases are a function of the seed and the two numbers alone, so a run can
be stopped at any time: the next one reads what the file has and goes on from there.

The file is JSON, one case a line, with the recipe in front. Lengths and values are written with all
their digits; a mean over an empty region is ``null``.
"""

import argparse
import json
import math
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

from reference import reference  # noqa: E402

FORMAT_VERSION = 1


def draw_designs(rng: np.random.Generator, number: int, surrounded: bool) -> list[list[float]]:
    """Designs uniform on the simplex, restricted to a design space by rejection."""
    designs: list[list[float]] = []
    while len(designs) < number:
        r1, r2, r3 = (3 * rng.dirichlet([1.0, 1.0, 1.0])).tolist()
        if r3 <= 1.5 and not (surrounded and (r1 < r3 or r2 < r3)):
            designs.append([r1, r2, r3])
    return designs


def draw_cases(seed: int, assemblable: int, surrounded: int) -> list[dict[str, Any]]:
    """All cases without their values, in a shuffled order, so that any beginning is a sample."""
    rng = np.random.default_rng(seed)
    cases = [
        {"design_space": space, "r1": r1, "r2": r2, "r3": r3}
        for space, number in (("assemblable", assemblable), ("surrounded", surrounded))
        for r1, r2, r3 in draw_designs(rng, number, space == "surrounded")
    ]
    for case in cases:
        s1, s2, assembly = (1 - 2 * rng.integers(0, 2, 3)).tolist()
        case.update(s1=s1, s2=s2, assembly=assembly, threshold=rng.uniform(0.1, 0.9))
    return [{"case": i, **cases[k]} for i, k in enumerate(rng.permutation(len(cases)))]


def evaluate_case(case: dict[str, Any], rtol: float) -> dict[str, Any]:
    """Add to a case its reference values, their errors and the seconds they took."""
    start = time.perf_counter()
    t = case["threshold"]
    values = reference(
        case["r1"], case["r2"], case["r3"], case["s1"], case["s2"], case["assembly"], (t,), rtol
    )
    flat = {key: value[t] if isinstance(value, dict) else value for key, value in values.items()}
    seconds = round(time.perf_counter() - start, 2)
    return {
        **case,
        **{k: None if math.isnan(v) else v for k, v in flat.items()},
        "seconds": seconds,
    }


def write(path: Path, recipe: dict[str, Any], cases: list[dict[str, Any]]) -> None:
    """Write the file under another name, then rename it: never half a file."""
    head = ",\n".join(f"{json.dumps(key)}: {json.dumps(value)}" for key, value in recipe.items())
    body = ",\n".join(json.dumps(case, allow_nan=False) for case in cases)
    part = path.with_suffix(".part")
    part.write_text(f'{{\n{head},\n"cases": [\n{body}\n]\n}}\n', encoding="utf-8")
    part.replace(path)


def main() -> int:
    """Parse the command line, go on where the file ends, report progress."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "-o", "--output", type=Path, default=ROOT / "tests" / "published" / "reference_cases.json"
    )
    parser.add_argument("--seed", type=int, default=20060323)
    parser.add_argument("--assemblable", type=int, default=700, help="designs of that space")
    parser.add_argument("--surrounded", type=int, default=300, help="designs of that space")
    parser.add_argument("--rtol", type=float, default=1e-8, help="tolerance of the reference")
    parser.add_argument("--limit", type=int, help="stop when the file has this many cases")
    options = parser.parse_args()

    recipe = {
        "description": "Five-bar reference values for accuracy checks. Made by "
        "benchmarks/make_reference_cases.py with tests/reference.py: designs uniform on the "
        "simplex r1 + r2 + r3 = 3, mode pair uniform over all eight, threshold uniform in "
        "(0.1, 0.9). s1, s2: working mode; assembly: sign of det B; *_error: absolute error "
        "estimate; null: mean over an empty region; runner_up_area: second largest component.",
        "format_version": FORMAT_VERSION,
        "seed": options.seed,
        "assemblable": options.assemblable,
        "surrounded": options.surrounded,
        "rtol": options.rtol,
    }
    drawn = draw_cases(options.seed, options.assemblable, options.surrounded)
    done: list[dict[str, Any]] = []
    if options.output.exists():
        stored = json.loads(options.output.read_text(encoding="utf-8"))
        done = stored.pop("cases")
        if stored != recipe:
            parser.error(f"{options.output} was made by another recipe; remove it or name another")

    total = min(len(drawn), options.limit or len(drawn))
    start, before = time.perf_counter(), len(done)
    while len(done) < total:
        done.append(evaluate_case(drawn[len(done)], options.rtol))
        if len(done) % 10 == 0 or len(done) == total:
            write(options.output, recipe, done)
            pace = (time.perf_counter() - start) / (len(done) - before)
            left = pace * (total - len(done))
            print(
                f"{len(done)}/{total} cases, {pace:.2f} s a case, {left:.0f} s left",
                file=sys.stderr,
                flush=True,
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
