"""LINT003 and LINT004: rows that can drive one part of the robot at one time.

Two rows conflict when they use one resource at equal Priority, their conditions can hold together, and

- a value that comes from one event reaches both at the same instant; or
- one of them drives its actuator again and again, so that the other is cut off at once; or
- they stand in different behaviours, whose authors need not know of each other.

Within one behaviour, rows that different events drive are left alone: the newer one replaces the older one, which is
what a therapist who presses another button means. So are rows that follow each other through a done stream.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rrp_sheets.checks.dataflow import Route
from rrp_sheets.checks.facts import BLANK, CAMERA, CHANGE, TIMER, Fact
from rrp_sheets.checks.lints.context import LintContext, row_key, row_of
from rrp_sheets.graph import Step
from rrp_sheets.texts import N_

MOST_PAIRS = 5_000
STEADY_HZ = 0.5  # what comes at least so often leaves no time for anything else
VOICE, BRIGHTNESS = "voice", N_("brightness of the eyes")
_SHARED = frozenset({"memory", "all"})  # remembering a face, and ending the run, are in nobody's way


@dataclass(frozen=True, slots=True)
class _Driver:
    """A subscribe row with all that it uses; `joints` is empty unless the setting Joint names them."""

    step: Step
    behaviour: str
    uses: frozenset[str]
    fact: Fact
    routes: tuple[Route, ...] | None
    joints: frozenset[str]

    @property
    def steady(self) -> bool:
        rate = self.fact.rate
        return rate.kind in (CAMERA, CHANGE, TIMER) and rate.hz >= STEADY_HZ


def lint_conflicts(context: LintContext) -> None:
    """Report, at each row, the first row before it with which it conflicts."""
    drivers: list[_Driver] = []
    left = MOST_PAIRS
    told: set[tuple[str, ...]] = set()
    for driver in _drivers(context):
        for other in drivers:
            left -= 1
            if left < 0:
                return
            if _tell_conflict(driver, other, told, context):
                break
        drivers.append(driver)


def _tell_conflict(driver: _Driver, other: _Driver, told: set[tuple[str, ...]], context: LintContext) -> bool:
    """Report the first resource over which two rows conflict, for two behaviours once, and return whether one is."""
    for resource in sorted(driver.uses & other.uses):
        how = _in_the_way(driver, other, resource, context)
        pair = (*sorted((driver.behaviour, other.behaviour)), resource)
        if not how or (driver.behaviour != other.behaviour and pair in told):
            continue
        told.add(pair)
        address, where = driver.step.row.output.address, row_of(other.step, driver.step)
        if resource == VOICE and driver.behaviour == other.behaviour:
            context.report.add("LINT004", address, other=where)
        else:
            context.report.add("LINT003", address, other=where, resource=N_(resource), how=how)
        return True
    return False


def _drivers(context: LintContext) -> Iterator[_Driver]:
    for behaviour in context.behaviours():
        for step in behaviour.steps:
            if not step.active or not step.connector.is_sink or row_key(step.row.output.address) in context.unclear:
                continue
            fact = context.fact(step.ref)
            uses = _uses(step, fact, context)
            if uses and fact.known.kind != BLANK:  # blank alone starts nothing
                joints = frozenset(context.joints(context.graph.streams[step.output]))
                yield _Driver(step, behaviour.key, uses, fact, context.routes.of.get(step.ref), joints)


def _uses(step: Step, fact: Fact, context: LintContext) -> frozenset[str]:
    """Return the resources that a row's actuator uses; for a gesture named by the value, those of all possible ones."""
    stream = context.graph.streams[step.output]
    if stream.device is None:
        return frozenset()
    kind = stream.device.type
    if kind.name == "EyeBrightness" and not stream.settings.get("colour"):
        return frozenset({BRIGHTNESS})  # how bright, in whichever colour
    uses = kind.resources_for(stream.settings) - _SHARED
    choices = fact.known.choices
    if kind.name == "Gesture" and not stream.settings.get("name") and choices:
        named = [kind.resources_for({"name": c}) for c in choices if isinstance(c, str) and c]
        return frozenset().union(*named) if named else uses
    return uses


def _in_the_way(one: _Driver, other: _Driver, resource: str, context: LintContext) -> str:
    """Return in words why two rows conflict over a resource; empty when they do not."""
    if one.step.row.priority != other.step.row.priority or one.routes is None or other.routes is None:
        return ""
    if one.joints and other.joints and not one.joints & other.joints:
        return ""  # the one turns the head, the other lets it nod
    same_behaviour = one.behaviour == other.behaviour
    routes = context.routes
    if routes.together(one.routes, other.routes, same_origin=True):
        choices = one.fact.known.choices
        same_value = choices is not None and len(choices) == 1 and choices == other.fact.known.choices
        if same_value and one.step.output == other.step.output:
            return ""
        origin = next(a.origin for a in one.routes for b in other.routes if a.origin == b.origin)
        return N_("{named} can reach both", named=_named(origin, context))
    steady = one if one.steady else other if other.steady else None
    if same_behaviour and (resource == VOICE or steady is None):
        return ""
    if not routes.together(one.routes, other.routes, same_origin=False):
        return ""
    if _follow(one, other, context) or _follow(other, one, context):
        return ""
    if steady is None:
        return N_("they belong to two behaviours that do not know each other")
    return N_("{row} does so repeatedly", row=row_of(steady.step, one.step))


def _follow(one: _Driver, other: _Driver, context: LintContext) -> bool:
    """Return whether one row acts only when a command of the other has ended."""
    origins = {r.origin for r in one.routes or ()}
    done = {k for k in origins if k in context.graph.streams and context.graph.streams[k].done_of == other.step.output}
    return bool(origins) and origins == done


def _named(origin: str, context: LintContext) -> str:
    if origin in context.graph.streams:
        return N_("one value of “{name}”", name=context.graph.streams[origin].name)
    sheet, _, row = origin.removeprefix("clock ").rpartition("!")
    return N_("one value of {sheet} row {row}", sheet=sheet, row=row)
