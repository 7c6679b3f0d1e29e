"""LINT…: rows that work, but probably not as they are meant."""

from rrp_sheets.diagnostics.catalogue.code import Code, Severity

_W, _I = Severity.WARNING, Severity.INFO
CODES: tuple[Code, ...] = (
    Code("LINT001", _W, "Old values are joined with new ones",
         "“{rare}” comes only now and then ({why}), “{steady}” again and again. combineLatest remembers the last "
         "“{rare}” for ever: row {row} goes on as if it were still so, long after it has ended.",
         "Let “{rare}” be forgotten (forgetAfter) and give nothing while it is blank, or give both a timestamp and let "
         "only pass what is close in time."),
    Code("LINT002", _W, "Too many words",
         "“{stream}” comes up to {hz} times a second, and every value makes the robot speak: it would talk without end.",
         "Put a row before: throttle with a period such as {period}, changes, sample or once."),
    Code("LINT003", _W, "Two rows want one thing",
         "This row and {other} can both drive the {resource} at one time: {how}.",
         "Let their filters exclude each other, or give one of the two a larger number in a column Priority."),
    Code("LINT004", _I, "Two things to say at one time",
         "This row and {other} can speak at the same moment: the robot says one after the other, and keeps no more than "
         "one waiting.",
         "Nothing to do if that is what you want. Otherwise let one follow the other's done stream, or set a Priority."),
    Code("LINT005", _W, "Never passes", "No value can pass this filter: {why}.", "Check the condition, and {remedy}."),
    Code("LINT006", _W, "Different kinds of values are joined",
         "“{output}” is {first} when it comes from “{one}”, but {second} when it comes from “{two}”{use}.",
         "Bring them into one form with a map row each, before they are joined."),
    Code("LINT007", _W, "Never done", "“{name}” has no values: no row that is on drives “{actuator}”.",
         "Switch a row on that drives it, or drive it with subscribe."),
    Code("LINT008", _I, "Helper not used", "No formula uses the helper {name}.", "Delete it, or use it in a row."),
    Code("LINT009", _I, "Input of a helper not used", "The formula of the helper {name} does not use its input {input}.",
         "Use it in the formula, or leave it out of the helper and of its calls."),
    Code("LINT010", _W, "Fails on the example", "With the example ({values}) this formula fails: {reason}",
         "{remedy}"),
    Code("LINT011", _W, "Not a condition", "A filter needs TRUE or FALSE, but this formula gives {what}.",
         "Compare it with something, for example {example}."),
    Code("LINT012", _W, "Value that cannot be used", "{device} takes {takes}, but this row sends {what}.",
         "{remedy}"),
    Code("LINT013", _W, "Beyond the limit", "{value} is beyond what {what} can do ({low} to {high}{unit}): the robot will go "
         "to its limit only.", "Use a value within the limits, or CLAMP(…; {low}; {high})."),
    Code("LINT014", _W, "Nothing to follow",
         "{device} follows what a sensor sees, but nothing on the way to this row comes from a sensor that sees something.",
         "Start from a sensor such as Red ball or Face."),
    Code("LINT015", _W, "Always passes", "Every value passes this filter: {why}.",
         "Write a condition, for example {example}, or leave the row out."),
    Code("LINT016", _W, "Never comes",
         "What stands in the column {column} of the sheet {sheet} never comes: {texts}. It is compared here with what can "
         "only be {can}.",
         "{remedy}"),
    Code("LINT017", _W, "Waits for itself", "“{done}” comes only after this row has acted, so this row never acts.",
         "Let another row start “{actuator}” first, or take “{done}” out of this row."),
)  # fmt: skip
