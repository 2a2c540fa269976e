"""``gm-ompl explain``: never more than a screen, what matters most first."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from shlex import quote

import gm_ompl
from gm_ompl import limits
from gm_ompl.app.commands import Exit
from gm_ompl.app.output import say, say_json, show_warnings
from gm_ompl.app.verbs import ExplainVerb
from gm_ompl.diagnosis.free_values import DeedLine, Explored
from gm_ompl.diagnosis.values import (
    ContactLine,
    Explanation,
    InstantLine,
    ModeLine,
    SetLine,
    Stretch,
    Survey,
)
from gm_ompl.errors import InputError

_PLACEMENT = r"([^:,\s]+):(?:(\d+)\.(\d+)|\[\s*(\d+)\s*,\s*(\d+)\s*\])"


def explain_command(request: ExplainVerb) -> Exit:
    """Explain a scenario and show it."""
    at = None if request.at is None else read_coordinates(request.at)
    places = None if request.placements is None else read_placements(request.placements)
    with limits.holding(request.time_limit or None, request.memory_limit):
        scenario = gm_ompl.load(request.scenario, request.overrides or ())
        show_warnings(scenario)
        explanation = gm_ompl.explain(
            scenario, at, places, samples=request.samples, seed=request.seed,
            time_limit=request.time_limit, memory_limit=request.memory_limit,
        )  # fmt: skip
    if request.as_json:
        say_json(explanation.to_dict())
    else:
        for line in lines(explanation):
            say(line)
    return Exit.OK


def read_placements(text: str) -> list[tuple[str, tuple[int, int]]]:
    """Return (face, cell) per finger from "FACE:i.j,FACE:[i,j]".

    Raises:
        InputError: the text is something else.
    """
    if not re.fullmatch(f"{_PLACEMENT}(,{_PLACEMENT})*", text.strip()):
        raise InputError(
            f"--placements {text!r}: must be FACE:CELL per finger, separated by commas, CELL as "
            "i.j or [i,j]; for example -x:3.2,+z:[0,1]"
        )
    found = re.finditer(_PLACEMENT, text)
    return [(one[1], (int(one[2] or one[4]), int(one[3] or one[5]))) for one in found]


def read_coordinates(text: str, option: str = "--at") -> list[float]:
    """Return object coordinates from "S", or "X,Y,YAW" in the plane (yaw in rad, or "90 deg").

    Raises:
        InputError: the text is something else.
    """
    values = []
    for part in text.split(","):
        number, unit = part.strip(), 1.0
        if number.endswith("deg"):
            number, unit = number[:-3], math.pi / 180.0
        elif number.endswith("rad"):
            number = number[:-3]
        try:
            values.append(float(number) * unit)
        except ValueError:
            raise InputError(
                f"{option} {text!r}: must be a number (along a path), or X,Y,YAW"
            ) from None
    return values


MOST_LINES = 39  # what an explanation has at most; ``--json`` has all of it
FACES_SHOWN = 4
DEEDS_SHOWN = 5
CONTACTS_SHOWN = 8
STRETCHES_SHOWN = 6
MODES_SHOWN = 4
WIDEST = 240  # characters of a line at most


def lines(explanation: Explanation) -> list[str]:
    """Return the explanation as at most ``MOST_LINES`` lines for people."""
    every = [
        line if len(line) <= WIDEST else line[: WIDEST - 3] + "..." for line in _all(explanation)
    ]
    if len(every) <= MOST_LINES:
        return every
    kept = MOST_LINES - 1
    return [*every[:kept], f"... and {len(every) - kept} lines more: --json has all of it"]


def _all(explanation: Explanation) -> Iterator[str]:
    yield f"{explanation.scenario}: {explanation.verdict}"
    for attempt in explanation.attempts:
        yield f"  {attempt.sentence}"
    if explanation.remedies:
        yield "tried, each change alone:"
    for remedy in sorted(explanation.remedies, key=lambda remedy: not remedy.helps):
        sign = "helps" if remedy.helps else "no help"
        yield f"  {sign:8s} --set {quote(remedy.change)}  ({remedy.evidence})"
    if explanation.contacts:
        yield "contacts with the environment (all stick at rest):"
    yield from _shown(map(_contact, explanation.contacts), CONTACTS_SHOWN, "contacts")
    for instant in explanation.instants:
        yield from _instant(instant)
    if explanation.placements is not None:
        yield from _set(explanation.placements)
    for explored in explanation.explored:
        yield from _explored(explored)
    for survey in explanation.surveys:
        yield from _survey(survey)


def _shown(texts: Iterable[str], count: int, what: str) -> Iterator[str]:
    """Yield the first ``count`` texts, and how many more there are."""
    every = list(texts)
    yield from every[:count]
    if len(every) > count:
        yield f"  ... and {len(every) - count} more {what}"


def _contact(line: ContactLine) -> str:
    moving = {name: word for name, word in line.motion.items() if name != "rest"}
    usual, _ = Counter(moving.values()).most_common(1)[0]
    others = [f"{word} along {name}" for name, word in moving.items() if word != usual]
    aside = f" ({', '.join(others)})" if others else ""
    return (
        f"  {line.against} at ({_numbers(line.point)}), normal ({_numbers(line.normal)}): "
        f"{usual}{aside}"
    )


def _explored(found: Explored) -> Iterator[str]:
    who = "the object by itself"
    if found.fingers:
        who = f"held by any of {found.sets} sets of placements, fingers changed at will"
    seen = "all of them" if found.whole else "not all of them"
    yield f"{who}: {found.nodes:,} poses, {found.arcs:,} arcs ({seen} seen)"
    near, reached = found.nearest, "the goal" if found.arrived else "nearest to the goal"
    angle = f" and {round(near.angle, 9):.3g} deg" if not found.arrived else ""
    off = "" if found.arrived else f", off by {round(near.distance, 9):.3g}{angle}"
    yield f"  {reached}: {near.place.words}, after {near.arcs} arcs{off}"
    rows = (f"  {line.deed}: {_deed(line, found.fingers)}" for line in found.deeds)
    yield from _shown(rows, DEEDS_SHOWN, "kinds of arcs")
    if not found.fingers:
        touching = [f"{words} ({count:,})" for words, count in found.contacts.items()]
        yield f"  contacts: {'; '.join(touching[:CONTACTS_SHOWN])}"
    if found.borders:
        yield f"  it comes to the region's end at {', '.join(found.borders)}"


def _deed(line: DeedLine, fingers: bool) -> str:
    if not fingers:
        return f"{line.arcs:,} arcs"
    blocked = "".join(f"; {n:,} {_words(name)}" for name, n in line.findings.items())
    return f"held on {line.holding:,} of {line.arcs:,} arcs{blocked}"


def _where(line: InstantLine) -> str:
    if line.place is None:
        return f"at {_numbers(line.q)}"
    moving = "at rest" if line.moving is None else f"where it {line.moving}"
    return f"at {line.place.words}, {moving}"


def _survey(survey: Survey) -> Iterator[str]:
    where = {"start": "going forward from the start", "goal": "coming back from the goal"}
    possible = "too many to list" if survey.possible is None else f"{survey.possible:,}"
    drawn = f"a random {survey.judged:,}" if survey.sampled else "all"
    yield (
        f"{where.get(survey.where, 'at this point')}: sets of placements that are "
        f"geometrically possible there: {possible}; {drawn} judged"
    )
    if survey.judged:
        counts = [f"{survey.holding} hold"]
        counts += [f"{number} {_words(name)}" for name, number in survey.findings.items()]
        yield "  first blocked by: " + ", ".join(counts)
    rows = (
        f"  {', '.join(row.faces) or 'no fingers':12s} {row.holding} of {row.sets} hold"
        + "".join(f"; {n} {_words(name)}" for name, n in row.findings.items())
        + _ratio(row.ratio)
        for row in survey.faces
    )
    yield from _shown(rows, FACES_SHOWN, "combinations of faces")
    for line in survey.closest[:1]:
        yield "  the one that came furthest:"
        yield from _set(line)


def _set(line: SetLine) -> Iterator[str]:
    places = " ".join(line.placements) or "no fingers"
    yield f"  {places}:{' holds' if line.holds else ''}{_ratio(line.ratio)}"
    ends = []
    if line.nodes_from_start is not None:
        ends.append(f"{line.nodes_from_start:,} nodes reached from the start")
    if line.nodes_to_goal is not None:
        ends.append(f"the goal reached from {line.nodes_to_goal:,}")
    if ends:
        yield f"    without regrasping: {', '.join(ends)}"
    for going, failed in (("going forward", line.forward), ("coming back", line.backward)):
        if failed is not None:
            yield f"    {going} it first fails {_where(failed)}: {_why(failed)}"
    parts = (
        f"    from {part.first:.4g} to {part.last:.4g}: {_why(part)}" for part in line.stretches
    )
    yield from _shown(parts, STRETCHES_SHOWN, "stretches that fail")


def _instant(line: InstantLine) -> Iterator[str]:
    moving = "at rest" if line.direction is None else f"moving along {_numbers(line.direction)}"
    yield f"  at {_numbers(line.q)}, {moving}: {_why(line)}"
    if line.limit is not None and line.z is not None:
        yield f"    the disturbance that limits z: {line.limit}"
    if line.gives_way:
        yield f"    gives way: {', '.join(line.gives_way)}"
    best = sorted(line.modes, key=lambda row: -1.0 if row.z is None else row.z, reverse=True)
    texts = (f"    {' '.join(row.modes):20s} {_mode(row)}" for row in best)
    yield from _shown(texts, MODES_SHOWN, "combinations of modes, none better")


def _mode(row: ModeLine) -> str:
    if row.internal_force:
        return "fingers could squeeze without bound: excessive internal force (5)"
    if row.z is None:
        return "no equilibrium (3)"
    commands = [f"{f:.4g}" for f in row.f_com if f is not None]
    return f"z = {row.z:.4g}" + (f" with f_com {', '.join(commands)}" if commands else "")


def _why(line: InstantLine | Stretch) -> str:
    return f"{'; '.join(line.blocked_by) or line.finding.value}{_ratio(line.ratio)}"


def _numbers(values: Sequence[float]) -> str:
    return ", ".join(f"{value + 0.0:.4g}" for value in values)


def _words(name: str) -> str:
    return name.replace("_", " ")


def _ratio(ratio: float | None) -> str:
    return "" if ratio is None else f" (z / z_min = {ratio:.3g})"
