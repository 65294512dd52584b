"""The catalogue as a page of Markdown (docs/effects.md): equations, units, sources, and what tells effects apart."""

from __future__ import annotations

from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.effects.closure import Closure
from fsm_calib.world2d.effects.effect import Effect
from fsm_calib.world2d.effects.numbered import is_later

HEAD = """# The catalogue of effects

Every piece of physics that a simulation may leave out, one file each in `fsm_calib/world2d/effects/`. This page is
made from those files by `python3 benchmarks/effects_page.py`; `fsm-calib effects` prints the same as a table.

Each picture shows what an effect of typical size does to one drive (straights at several speeds both ways, spins,
arcs, rests): grey the difference in speed to the robot without it, red what remains of it after the base robot has
been re-fitted, which is all that a diagnosis gets to see. *Strength* parameters switch the effect on; the others say
where, when or how.
"""


def parameter_lines(effect: Effect) -> list[str]:
    """Return the rows of the parameters' table."""
    rows = ["| parameter | symbol | unit | null | bounds | typical | |", "|---|---|---|---|---|---|---|"]
    later = [p.name for p in effect.parameters if is_later(p.name)]
    for p in (p for p in effect.parameters if p.name not in later):
        kinds = ["strength" if p.strength else "where, when, how"]
        kinds += ["per recording"] * p.per_recording + ["not fitted"] * (not p.fitted)
        rows.append(
            f"| `{p.name}` | {p.symbol} | {p.unit} | {p.null:g} | {p.low:g} to {p.high:g} | {p.typical:g} "
            f"| {', '.join(kinds)} |"
        )
    if later:
        rows += ["", f"Each later one of the same recording has all of these, `{later[0]}` to `{later[-1]}`."]
    return rows


def closure_lines(effect: Effect) -> list[str]:
    """Return one line with the effect's closures; none where it has but one."""
    if len(effect.closures) < 2:
        return []
    said = [
        f"*{c.name}* ({_freed(c)}): {c.summary}{' (once it is found)' if c.refines else ''}"
        for c in effect.closures
    ]
    return [f"- **Closures**: {'; '.join(said)}."]


def _freed(closure: Closure) -> str:
    """Return the numbers that a closure frees, those of later times told by the last."""
    names = [f"`{name}`" for name in closure.frees if not is_later(name)]
    return ", ".join(names) + (
        f", and so on to `{closure.frees[-1]}`" if len(names) < len(closure.frees) else ""
    )


def section(effect: Effect) -> str:
    """Return one effect's part of the page."""
    lines = [
        f"## {effect.name}",
        "",
        f"{effect.summary[0].upper()}{effect.summary[1:]}.",
        "",
        f"    {effect.equation}",
        "",
        *parameter_lines(effect),
        "",
        f"![what {effect.name} does to the measured speeds](effects/{effect.name}.png)",
        "",
        f"- **Shows** in {', '.join(effect.channels)}; regime: {', '.join(effect.regimes).replace('_', ' ')}.",
        f"- **Taken for** {', '.join(f'`{r}`' for r in effect.rivals)}.",
        *closure_lines(effect),
        f"- **Told apart**: {effect.separates}.",
        f"- **Manoeuvre that shows it**: {effect.manoeuvre}.",
        f"- **Source**: {effect.source}.",
        "",
    ]
    return "\n".join(lines)


def page() -> str:
    """Return the whole page."""
    return "\n".join([HEAD, *(section(effect) for effect in registry().values())]).rstrip() + "\n"
