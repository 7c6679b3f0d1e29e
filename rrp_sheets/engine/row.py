"""A row that is wired: its connector's parts, and what of them may be edited while it runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from reactivex import Observable, never

from rrp_sheets.connectors.wiring import ConnectorContext
from rrp_sheets.engine.builtin_devices import MIN_DELAY_US
from rrp_sheets.engine.clock import FrameClock
from rrp_sheets.engine.streams import LiveStream
from rrp_sheets.formulas import Formula
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.formulas.pick import Picker
from rrp_sheets.graph import Step, Stream
from rrp_sheets.model.values import Failure, Value

_SILENT: Observable[Value] = never()  # an input whose rows are switched off: it keeps its place, and gives nothing
Fail = Callable[[Failure, tuple[Value, ...]], None]


class LiveRow:
    """A row of a run.

    Args:
        step: the row.
        streams: of the run, by id.
        shown: the same streams with their names.
        clock: of the run.
        interpreter: of the engine's thread.
        picker: what its formula draws with.
        fail: told of its errors.
    """

    def __init__(
        self, step: Step, streams: Mapping[str, LiveStream], shown: Mapping[str, Stream], clock: FrameClock,
        interpreter: GuardedInterpreter, picker: Picker, fail: Fail,
    ) -> None:  # fmt: skip
        self._build = step.connector.build
        self._interpreter = interpreter
        self._picker = picker
        self._evaluate: Callable[..., Value] | None = None
        self._wiring = ConnectorContext(
            inputs=[streams.get(i, _SILENT) for i in step.inputs], clock=clock, rank=step.rank, fail=fail,
            names=tuple(shown[i].name for i in step.inputs),
        )  # fmt: skip

    def wire(self, formula: Formula | None, period_us: int | None) -> Observable[Value]:
        """The observable of what the row gives."""
        if formula is not None:
            self._wiring.evaluate = self._work_out
        self._use(formula, period_us)
        return self._build(self._wiring)

    def edit(self, formula: Formula | None, period_us: int | None) -> None:
        """Go on with another formula or period; what the connector remembers stays."""
        self._use(formula, period_us)
        if period_us:
            self._wiring.edited()

    def _use(self, formula: Formula | None, period_us: int | None) -> None:
        self._evaluate = formula.prepare(self._interpreter, self._picker) if formula is not None else None
        self._wiring.period_us = max(period_us, MIN_DELAY_US) if period_us else 0

    def _work_out(self, *values: Value) -> Value:
        """What connectors keep: it goes on with the formula of now."""
        assert self._evaluate is not None
        return self._evaluate(*values)
