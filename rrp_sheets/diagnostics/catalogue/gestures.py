"""GEST…: the Gestures sheet."""

from rrp_sheets.diagnostics.catalogue.code import Code, Severity

_E, _W = Severity.ERROR, Severity.WARNING
CODES: tuple[Code, ...] = (
    Code("GEST001", _E, "Keyframe's time not understood", "“{text}” is not a time of a gesture.",
         "Write seconds from the gesture's beginning, for example {meant}; at most {longest}."),
    Code("GEST002", _E, "Keyframes not in order", "In “{name}” the time {text} is not later than the one before, {before} s.",
         "Write a later time such as {later}, or move the row to where its time belongs."),
    Code("GEST003", _W, "No such joint", "The robot has no joint “{header}”; what stands in this column is not used.",
         "{remedy}"),
    Code("GEST004", _E, "Angle not understood", "“{text}” cannot be the angle of {joint}.", "Write {wants}."),
    Code("GEST005", _W, "Beyond the joint's limit",
         "{joint} cannot go to {text}: it goes from {low} to {high}{when}.",
         "Write {nearest}; otherwise it stops at its limit."),
    Code("GEST006", _W, "Too fast", "{joint} cannot be there at {text}: it is not fast enough.",
         "Write {needs} or later; otherwise the gesture takes longer by itself."),
    Code("GEST007", _E, "Too many keyframes", "The gesture “{name}” has more than {limit} rows.",
         "Divide it into several gestures."),
)  # fmt: skip
