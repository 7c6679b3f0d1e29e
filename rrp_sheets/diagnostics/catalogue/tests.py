"""TEST…: the rows of test sheets."""

from rrp_sheets.diagnostics.catalogue.code import Code, Severity

_E, _W, _I = Severity.ERROR, Severity.WARNING, Severity.INFO
CODES: tuple[Code, ...] = (
    Code("TEST001", _E, "Not a time of a test", "“{text}” is not a time at which a test can do something.",
         "Write milliseconds from the start, such as 2000, or a time such as {meant}; at most {longest}."),
    Code("TEST002", _E, "Unknown stream in a test", "No stream of this workbook is called “{name}”.", "{remedy}"),
    Code("TEST003", _E, "A stream name of several sheets", "“{name}” is a stream of {sheets}.", "Write {example}."),
    Code("TEST004", _E, "Sent to an actuator",
         "“{name}” is an actuator: it receives what the rows send, and a test can only expect something there.",
         "Move “{text}” to the column Expect, or send to a stream that leads to “{name}”."),
    Code("TEST005", _E, "Send and Expect in one row", "This row sends “{send}” and expects “{expect}”.",
         "Make two rows of it: one sends, the next one expects, at the same time."),
    Code("TEST006", _E, "Neither Send nor Expect",
         "This row neither sends nor expects something, and “{name}” has no example value that could be sent.",
         "Write what is sent into the column Send, or what must come into the column Expect; any means any value."),
    Code("TEST007", _E, "Cannot be sent", "“{text}” cannot be sent: {why}", "{remedy}"),
    Code("TEST008", _E, "Unknown field in a test", "{record} has no field “{field}”.", "{remedy}"),
    Code("TEST009", _E, "Condition cannot be read", "The condition “{text}” cannot be read: {why}", "{remedy}"),
    Code("TEST010", _E, "No number after ≈", "“{text}” means “about”, but no number stands there.",
         "Write for example ≈0.5 (from 0.45 to 0.55), ≈0.50 (from 0.495 to 0.505) or ≈0.5 ± 0.1."),
    Code("TEST011", _W, "Stream that does not run in a test",
         "“{name}” has no part in a run: {why}. So nothing ever comes there, and what is sent there has no effect.",
         "Switch its rows and its behaviour on, or delete this row."),
    Code("TEST012", _W, "Test that expects nothing", "The test “{name}” has no row that expects something, so it cannot fail.",
         "Add a row with a value, any or nothing in the column Expect."),
    Code("TEST013", _E, "A field twice", "The field “{field}” stands twice here.", "Write it once."),
    Code("TEST014", _E, "Number too large in a test", "“{text}” is too large for a number.",
         "Use numbers up to 1e15 (a 1 with 15 zeros), or put it into quotes if it is a text."),
    Code("TEST015", _W, "One value where a record comes",
         "What comes here is a record ({record}), but “{text}” is a single value; rows that ask for a field will fail.",
         "Write fields of it, for example {example}=…; its fields are: {fields}."),
)  # fmt: skip
