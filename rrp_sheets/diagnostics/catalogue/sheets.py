"""SHEET…: what stands in the sheets cannot be understood as it is, or is probably not meant."""

from rrp_sheets.diagnostics.catalogue.code import Code, Severity

_E, _W, _I = Severity.ERROR, Severity.WARNING, Severity.INFO

CODES: tuple[Code, ...] = (
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
