"""Running a behaviour: the plan, the clock, the engine and the trace. On reactivex."""
