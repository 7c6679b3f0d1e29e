"""SHEET…: findings on what stands in the sheets; TEST…: on the rows of test sheets."""

from rrp_sheets.diagnostics.catalogue.code import Code, Severity

_E, _W, _I = Severity.ERROR, Severity.WARNING, Severity.INFO

_SHEETS: tuple[Code, ...] = (
    Code(
        "SHEET001", _E, "No behaviour",
        "No sheet of this workbook is a behaviour: nothing tells the robot what to do.",
        "Give a sheet the headers Input streams, Connector, Formula and Output stream, side by side in one of its "
        "first 20 rows.",
    ),
    Code(
        "SHEET002", _E, "Misspelt header",
        "The header “{header}” is not known here; otherwise the sheet “{sheet}” is {kind}.",
        "Did you mean “{wanted}”? Correct the header.",
    ),
    Code(
        "SHEET003", _W, "Perhaps a misspelt header",
        "The sheet “{sheet}” looks like {kind}, but the header “{wanted}” is missing; it is left alone as a sheet of "
        "your own.",
        "If it is meant to be {kind}, change the header “{header}” to “{wanted}”. If not, nothing needs doing.",
    ),
    Code(
        "SHEET004", _E, "Missing header",
        "The sheet “{sheet}” is {kind} without the column “{wanted}”, so it is not read.",
        "Write the header “{wanted}” beside the other headers in row {row}.",
    ),
    Code(
        "SHEET005", _E, "Column twice",
        "The column “{header}” stands here a second time; it is already in {first}.",
        "Delete one of the two columns, or give this one another header.",
    ),
    Code(
        "SHEET006", _E, "Turned into a date",
        "Excel turned what you typed into a date or a time: this cell now holds {value}.",
        "Format the cell as Text and type it again.",
    ),
    Code(
        "SHEET007", _E, "Error value",
        "This cell holds Excel's error value {value} and no longer what was typed.",
        "Format the cell as Text and type it again.",
    ),
    Code(
        "SHEET008", _W, "Merged cells",
        "The cells {range} are merged. Only the first one, {first}, has a content; the others are read as blank.",
        "Unmerge them (Home, Merge & center) and write the content into every cell that needs it.",
    ),
    Code(
        "SHEET009", _W, "Hidden rows",
        "{rows} of the sheet “{sheet}” cannot be seen (hidden or filtered out), but what stands there is active.",
        "Show the rows; to switch a row off, write FALSE into its column On.",
    ),
    Code(
        "SHEET010", _W, "Hidden sheet",
        "The sheet “{sheet}” is hidden, but what stands there is active.",
        "Show it: right-click on a sheet's tab, Unhide.",
    ),
    Code(
        "SHEET011", _E, "On or off?",
        "“{value}” in the column On means neither on nor off.",
        "Write TRUE or FALSE (yes, no, on, off, 1 and 0 work too, also in other languages); blank means on.",
    ),
    Code(
        "SHEET012", _E, "Priority is no number",
        "The priority “{value}” is not a number.",
        "Write a number such as 1 or 2.5: the larger one wins, and blank is 0.",
    ),
    Code(
        "SHEET013", _E, "Blank cell",
        "This row has no {what}.",
        "Fill this cell in, or delete the row; a row that begins with # is only a comment.",
    ),
    Code(
        "SHEET014", _E, "Two sheets of one name",
        "The sheets “{first}” and “{sheet}” have the same name: capitals, spaces and hyphens make no difference.",
        "Rename one of them.",
    ),
    Code(
        "SHEET015", _E, "Protocol field twice",
        "The field “{field}” stands here a second time; it is already in {first}.",
        "Delete one of the two rows.",
    ),
    Code(
        "SHEET016", _E, "Text too long",
        "This cell holds {count} characters; at most {limit} are read.",
        "Shorten the text, or divide it over several cells.",
    ),
    Code(
        "SHEET017", _E, "Too many cells in a row",
        "This row has more cells than the header has.",
        "A “|” inside a cell must be written as “\\|” in a Markdown file; in a CSV file, put the cell's text between "
        "double quotes.",
    ),
    Code(
        "SHEET018", _W, "Second table",
        "Under the heading “{sheet}” there is more than one table; only the first one is read.",
        "Give the second table a heading of its own: “## Name of the sheet”.",
    ),
    Code(
        "SHEET019", _E, "Table too large",
        "The sheet “{sheet}” is used by formulas as a table, but has more than {limit} {what}; the rest is not read.",
        "Shorten the table, or divide it over several sheets.",
    ),
    Code(
        "SHEET020", _E, "Table without contents",
        "The sheet “{sheet}” is used by a formula as a table, but its header row or its rows are missing.",
        "Write the names of the columns into the sheet's first row and the entries below, without a blank row between.",
    ),
    Code(
        "SHEET021", _E, "Too many names",
        "This cell lists {count} names; at most {limit} are read.",
        "Merge some of the streams in a row of their own before.",
    ),
    Code(
        "SHEET022", _W, "Row inside a comment",
        "Row {row} begins with #, so it is a comment: the robot does nothing with what stands beside it.",
        "Put the row's contents into a row of their own.",
    ),
)  # fmt: skip
_TESTS: tuple[Code, ...] = (
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
CODES = (*_SHEETS, *_TESTS)
