"""FILE…: the file as a whole cannot be read, or is refused."""

from rrp_sheets.diagnostics.catalogue.code import Code, Severity

_E = Severity.ERROR
_STRANGER = "If the file came from someone else, ask them where it comes from before you go on."
_CLEAN_COPY = "Copy the cells you need into a new workbook (`rrp-sheets new FILE` makes one) and use that."

CODES = (
    Code("FILE001", _E, "File not found", "There is no file “{name}”.", "{hint}"),
    Code(
        "FILE002", _E, "Not a workbook",
        "“{name}” is not a workbook that can be read here.",
        "Open it in Excel or LibreOffice and save it as “Excel workbook (.xlsx)”; a folder of .csv files and a "
        "Markdown file (.md) can be read too.",
    ),
    Code(
        "FILE003", _E, "Old Excel format",
        "“{name}” is in the old Excel format (.xls).",
        "Open it in Excel or LibreOffice and save it as “Excel workbook (.xlsx)”.",
    ),
    Code(
        "FILE004", _E, "Workbook with macros",
        "“{name}” contains macros, which are programs that a workbook can run. Such files are refused.",
        "Save it as “Excel workbook (.xlsx)”, which leaves the macros out. " + _STRANGER,
    ),
    Code(
        "FILE005", _E, "Password",
        "“{name}” is protected with a password, so it cannot be read.",
        "Open it in Excel, remove the password (File, Info, Protect workbook) and save it again.",
    ),
    Code(
        "FILE006", _E, "File too large",
        "“{name}” has {size}; at most {limit} are read.",
        "Remove pictures and sheets that the robot does not need, or split the workbook.",
    ),
    Code(
        "FILE007", _E, "Swollen file",
        "“{name}” would swell up far beyond its size when opened ({what}). Such files can block a computer, so it is "
        "refused.",
        _CLEAN_COPY + " " + _STRANGER,
    ),
    Code(
        "FILE008", _E, "Damaged file",
        "“{name}” is damaged: {what}.",
        "Open it in Excel or LibreOffice, let it be repaired, and save it again; or take an earlier copy.",
    ),
    Code(
        "FILE009", _E, "Unsafe file",
        "“{name}” is not built as Excel or LibreOffice build a workbook ({what}), so it is refused.",
        _CLEAN_COPY + " " + _STRANGER,
    ),
    Code(
        "FILE010", _E, "Links to other files",
        "“{name}” takes contents from other files or from the internet ({what}). Such files are refused, because the "
        "robot could do something else tomorrow.",
        "In Excel, use Data, Edit links, Break link (or Queries and connections), then save it again.",
    ),
    Code(
        "FILE011", _E, "Embedded object",
        "“{name}” has another document or a control embedded in it ({what}). Such files are refused.",
        "Delete the embedded object from the sheet and save the workbook again. Pictures and charts may stay.",
    ),
    Code(
        "FILE012", _E, "Too many sheets",
        "“{name}” has {count} sheets; at most {limit} are read.",
        "Remove sheets that the robot does not need, or split the workbook.",
    ),
    Code(
        "FILE013", _E, "Sheet too large",
        "The sheet “{sheet}” has {what}; at most {limit} are read.",
        "Delete the rows and columns that the robot does not need: select them, right-click, Delete; or split the "
        "sheet.",
    ),
    Code(
        "FILE014", _E, "Unreadable letters",
        "The letters in “{name}” cannot be read: it is not saved as UTF-8 text.",
        "In Excel, use “Save as” and choose “CSV UTF-8”; in a text editor, choose the encoding UTF-8.",
    ),
    Code(
        "FILE015", _E, "Empty file",
        "“{name}” is empty.",
        "Make a new workbook with `rrp-sheets new FILE`, or take an earlier copy.",
    ),
    Code(
        "FILE016", _E, "File cannot be opened",
        "“{name}” cannot be opened: {why}.",
        "Close it in other programs, check that you may read it, and try again.",
    ),
    Code(
        "FILE017", _E, "No sheets",
        "“{name}” contains no sheets.",
        "In a folder, save every sheet as a .csv or .tsv file; in a Markdown file, write “## Name of the sheet” and below it "
        "a table whose lines begin and end with “|”.",
    ),
    Code(
        "FILE018", _E, "Check not finished",
        "“{name}” could not be checked: {why}.",
        "Switch half of the rows off, check again, and so find the row that is to blame; then make it simpler.",
    ),
    Code(
        "FILE019", _E, "Catalogue refused",
        "The robot's catalogue “{name}” beside the workbook is not used: {why}.",
        "Remove that folder, and the program takes its own catalogue; or ask whoever sent it for another copy.",
    ),
    Code(
        "FILE020", _E, "Not a bundle",
        "“{name}” cannot be taken as a bundle: {why}.",
        "Make it again with `rrp-sheets pack WORKBOOK`, or ask whoever sent it for another copy.",
    ),
    Code(
        "FILE021", _E, "Two files for one sheet",
        "In “{name}”, “{one}” and “{other}” are both the sheet “{sheet}”.",
        "Keep one of them. Rename the other, or move it out of the folder.",
    ),
)  # fmt: skip
