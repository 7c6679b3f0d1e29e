"""DEV…: the Devices sheet; SCENE…: the Scene sheet; GEST…: the Gestures sheet."""

from rrp_sheets.diagnostics.catalogue.code import Code, Severity

_E, _W, _I = Severity.ERROR, Severity.WARNING, Severity.INFO
_DEVICES: tuple[Code, ...] = (
    Code("DEV001", _E, "Unknown device", "The robot has no device “{name}”.", "{remedy}"),
    Code("DEV002", _E, "Stream declared twice", "The stream “{name}” is declared already, in {other}.",
         "Give one of the two another name."),
    Code("DEV003", _E, "Setting missing", "{device} needs the setting {setting}.", "Fill it in: {help}."),
    Code("DEV004", _E, "Setting not understood", "“{text}” cannot be the setting {setting}.", "Write {wants}."),
    Code("DEV005", _E, "Device without stream", "This device has no stream name.", "Write a name in the first column."),
    Code("DEV006", _E, "Stream without device", "The stream “{stream}” has no device.",
         "Choose one in the column Device."),
    Code("DEV007", _W, "Setting not used", "{device} has no setting “{setting}”.", "{remedy}"),
    Code("DEV008", _E, "Device needs a setting", "{device} needs the setting {setting}.",
         "Declare it in the Devices sheet: Stream “{stream}”, Device “{device}”, and the column {setting}."),
    Code("DEV009", _I, "Not simulated yet", "The simulated robot does not carry out {device} yet ({streams}). {then}",
         "Nothing needs to be changed: the rows are checked, drawn and tested like any others."),
    Code("DEV010", _E, "No such behaviour", "There is no behaviour “{name}” in this workbook.", "Write {wants}."),
    Code("DEV011", _W, "Word that cannot be heard", "The robot cannot hear “{word}”: it recognises English only.",
         "Leave out this word, or write an English one. Words of other languages are typed by the operator: Send a value."),
    Code("DEV012", _W, "Sound cannot be played", "The file “{name}” {problem}.", "{remedy}"),
    Code("DEV013", _W, "Comma in a phrase", "Semicolons or line breaks divide this list, so “{phrase}” is one phrase.",
         "If it is one phrase, put it in quotation marks. If not, write the same sign between all words."),
    Code("DEV014", _I, "Phrase divided at a comma", "Commas divide this list: “{phrase}” is {count} words or phrases.",
         "If it is one phrase, put it in quotation marks. If not, write semicolons between the words."),
)  # fmt: skip
_SCENE: tuple[Code, ...] = (
    Code(
        "SCENE001",
        _E,
        "Time not understood",
        "“{text}” is not a time of the scene.",
        "{remedy}",
    ),
    Code("SCENE002", _E, "Unknown thing", "The scene has no thing “{text}”.", "{remedy}"),
    Code("SCENE003", _E, "Unknown verb", "A thing of this kind ({kind}) does not know how to do “{text}”.", "{remedy}"),
    Code("SCENE004", _E, "Value not understood", "“{text}” does not go with “{does}”.", "{remedy}"),
    Code(
        "SCENE005",
        _W,
        "Not there yet",
        "{thing} is told to do something at a time when {are} not there.",
        "Add a row before it, in which {come}.",
    ),
    Code("SCENE006", _W, "No such button", "This workbook has no button “{label}”.", "{remedy}"),
    Code("SCENE007", _E, "No such stream to wait for", "This workbook has no stream “{name}”.", "{remedy}"),
    Code("SCENE008", _E, "Picture not found", "The picture “{name}” cannot be used: {problem}", "{remedy}"),
    Code(
        "SCENE009",
        _W,
        "There already",
        "{thing} comes at a time when {are} there already.",
        "Write “moves” and “to …” in this row, or let {leave} in a row before it.",
    ),
    Code(
        "SCENE010",
        _W,
        "No table",
        "{thing} shall stand on a table, but there is none at that time.",
        "Add a row before it, in which the Table appears, or leave out “on table”.",
    ),
    Code(
        "SCENE011",
        _E,
        "Too many things",
        "More than {most} things are in the room at once.",
        "Let some disappear in rows before this one.",
    ),
)
_GESTURES: tuple[Code, ...] = (
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
CODES = (*_DEVICES, *_SCENE, *_GESTURES)
