"""FORM…: formulas and helpers. Below 100: found before evaluation; from 101: found by evaluating."""

from rrp_sheets.diagnostics.catalogue.code import Code, Severity

_E, _W, _I = Severity.ERROR, Severity.WARNING, Severity.INFO
CODES = (
    Code("FORM001", _E, "Not a formula", "This formula cannot be read: {reason}.", "{remedy}"),
    Code("FORM002", _E, "Formula too large", "This formula is too large: {reason}.",
         "Split it: put a part of it into a row of its own or into a helper."),
    Code("FORM003", _E, "Not allowed in formulas", "{what} cannot be used in a formula.", "{remedy}"),
    Code("FORM004", _E, "Unknown name", "“{name}” is not an input of this row.", "{remedy}"),
    Code("FORM005", _E, "Unknown function", "There is no function “{name}”.", "{remedy}"),
    Code("FORM006", _E, "Wrong number of arguments", "{name} takes {takes}, but here it gets {gets}.",
         "Write {usage}."),
    Code("FORM007", _E, "Unknown field", "{record} has no field “{field}”.", "{remedy}"),
    Code("FORM008", _E, "Number too large", "{number} is too large for a formula.",
         "Use numbers up to 1e15 (a 1 with 15 zeros)."),
    Code("FORM009", _E, "Two inputs with one name", "The inputs “{first}” and “{second}” are both called {name} in the "
         "formula.", "Rename one of the two streams."),
    Code("FORM010", _E, "Format not allowed", "“{spec}” is not a format that can be used here.",
         "Use for example {{distance:.1f}} for one decimal place."),
    Code("FORM011", _E, "Circle of helpers", "These helpers need each other in a circle: {path}.",
         "Write one of them without the others."),
    Code("FORM012", _W, "Helper hides a function", "The helper {name} has the name of a library function and hides it.",
         "Give the helper another name unless that is what you want."),
    Code("FORM013", _E, "Two helpers with one name", "The helper {name} is there already, in {other}.",
         "Rename one of the two."),
    Code("FORM014", _E, "Helper does not fit", "The helper {name} takes {takes}, but this row has {gets}.",
         "Give the row as many input streams as the helper has inputs, or write {name}(…) with the values it needs."),
    Code("FORM015", _E, "Helper without formula", "The helper {name} has no formula.",
         "Write its formula, or delete the row."),
    Code("FORM016", _E, "Helper without name", "This helper has no name.", "Write a name in the first column."),
    Code("FORM101", _W, "Division by zero", "This divides by zero.", "Filter out the zeros before, or use IF."),
    Code("FORM102", _W, "Blank where a value is needed", "There is a blank where {needed} is needed.",
         "Filter blanks out before, or test with ISBLANK."),
    Code("FORM103", _W, "Wrong kind of value", "{what}.", "Check what the inputs give."),
    Code("FORM104", _W, "No such field", "{record} has no field “{field}”.", "{remedy}"),
    Code("FORM105", _W, "Result too large", "The result is too large: {reason}.", "Make the formula's values smaller."),
    Code("FORM106", _W, "Outside the list", "There is no place {index} in a list of {count}.",
         "The first place is [0], the last [-1]."),
    Code("FORM107", _W, "Outside the function", "{what}.", "Check the value before, for example with IF or CLAMP."),
    Code("FORM108", _W, "Neither TRUE nor FALSE", "A condition must be TRUE or FALSE (or a number), but this is {what}.",
         "Compare it with something, for example {example}."),
)  # fmt: skip
