"""One HTML file that shows a plan: works offline and asks for nothing."""

from __future__ import annotations

import base64
import html
import json
from importlib.resources import files
from typing import Any

from gm_ompl.plan.model import Plan
from gm_ompl.planners.planner import Status

from . import palette
from .charts import Band, bands
from .scene import scene_messages, viewer_script
from .score import score
from .story import Story, tell


def page(plan: Plan) -> str:
    """Return the whole page of ``plan``, one HTML text.

    Raises:
        ScenarioError: the scenario inside the plan cannot be used.
    """
    story = tell(plan)
    scene = scene_messages(story)
    packed = [base64.b64encode(message).decode("ascii") for message in scene.messages]
    parts = {
        "TITLE": escaped(story.name),
        "DESCRIPTION": escaped(str(plan.scenario.get("description", ""))),
        "SUMMARY": _summary(story),
        "BANDS": "".join(_band(band) for band in bands(story)),
        "FINGERS": "".join(_finger_row(i) for i in range(story.problem.fingers.count)),
        "COLOURS": _colours(),
        "STYLE": _asset("page.css"),
        "SCORE": embedded(score(story, scene)),
        "MESSAGES": embedded(packed),
        "VIEWER": viewer_script(),
        "SCRIPT": _asset("page.js"),
    }
    pieces = _asset("page.html").split("@@")
    # Odd pieces are names; what is filled in is never searched for names again.
    return "".join(parts[p] if k % 2 else p for k, p in enumerate(pieces))


def escaped(text: str) -> str:
    """Return ``text`` so that HTML shows it as it is, whatever it says.

    Control characters, and lone surrogates that UTF-8 cannot hold, become replacement signs.
    """
    visible = "".join(c if c.isprintable() or c in " \n" else _stand_in(c) for c in text)
    return html.escape(visible, quote=True)


def _stand_in(character: str) -> str:
    # Invisible but meaningful in other scripts: joiners and spaces stay.
    category_ok = character in "\u200c\u200d\u00a0\u3000\u00ad"
    return character if category_ok else "\ufffd"


def embedded(value: Any) -> str:
    """Return ``value`` as JSON that is safe inside a script element."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))  # ASCII alone
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _asset(name: str) -> str:
    return (files("gm_ompl.viz") / "pages" / name).read_text(encoding="utf-8")


def _colours() -> str:
    """Return the palette as CSS variables."""
    names = ("position", "force", "lifted", "object", "obstacle", "static", "sliding", "margin")
    pairs = (f"--{name}: {palette.css(getattr(palette, name.upper()))};" for name in names)
    return " ".join(pairs)


def _summary(story: Story) -> str:
    plan = story.plan
    if plan.cost is None:
        facts = [Status(plan.status).sentence]
    else:
        facts = [
            f"cost {plan.cost:.6g}" + (" (proven optimal on the lattice)" if plan.optimal else ""),
            f"{len(plan.steps)} steps",
            f"{plan.regrasps} regrasp" + ("" if plan.regrasps == 1 else "s"),
        ]
    facts.append(f"planner {plan.planner}")
    off = plan.scenario["object"]["shape"].get("deviation")
    if off:
        facts.append(f"shape up to {off:.3g} off its file's surface")
    return "".join(f"<li><bdi>{escaped(fact)}</bdi></li>" for fact in facts)


def _band(band: Band) -> str:
    return (
        f'<div class="band"><div class="label"><span>{escaped(band.label)}</span>'
        f'<span class="top">{escaped(band.top)}</span></div>{band.svg}</div>'
    )


def _finger_row(i: int) -> str:
    return (
        f'<tr id="finger{i}"><th scope="row">{i}</th><td class="place"></td>'
        f'<td class="mode"></td><td class="f"></td></tr>'
    )
