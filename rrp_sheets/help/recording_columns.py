"""Columns and kinds of lines of the tables of recordings, for the help and the tables themselves."""

from __future__ import annotations

from rrp_sheets.texts import N_, translate

COLUMNS = {
    "run": ("", N_("Name of the recording’s folder.")),
    "participant": ("", N_("Code of the participant.")),
    "condition": ("", N_("Condition of the session.")),
    "time_s": ("s", N_("Time since the start of the run.")),
    "kind": ("", N_("What the line is, such as a value of a sensor; see the lines “kind: …”.")),
    "stream": ("", N_("Stream of the value or message. Streams of rows begin with their sheet: Tracking!Near. "
                      "Tracking!#2 comes from row 2 of the sheet Tracking, whose output cell is blank.")),
    "row": ("", N_("Row that the value or message comes from: sheet and number. Sensors have none.")),
    "value": ("", N_("Value on the stream, if it is a number, a text, TRUE or FALSE. The fields of a record have "
                     "columns of their own.")),
    "message": ("", N_("Text of a line that is not a value: what was said or done, an error, a note.")),
    "blank": ("", N_("Names of the columns in which a blank value came. Where another cell is empty, nothing came "
                     "for that column.")),
    "by": ("", N_("Person who did it by hand or sent the value. The column is there if somebody did.")),
    "workbook": ("", N_("File of the workbook that ran.")),
    "workbook_sha256": ("", N_("Fingerprint (SHA-256) of that file. It is the same only for the same file.")),
    "program": ("", N_("Program and version that made the recording.")),
    "mode": ("", N_("simulated: a session on the simulated robot; pilot: a rehearsal, which is never data.")),
    "seed": ("", N_("Seed of everything random in the run.")),
    "operator": ("", N_("Person who operated the session.")),
    "began": ("", N_("Date and time at which the run started, with the time zone.")),
    "ended": ("", N_("How the run ended: time, stopped, end run, killed, broken, cut or going.")),
    "complete": ("", N_("TRUE if the run ended by its time limit, a person or a row; else FALSE.")),
}  # fmt: skip
"""Unit and meaning of each column that does not depend on the workbook."""
MOVEMENTS = {
    "commands": ("", N_("Number of commands that the line stands for. A command less than 0.5 s after the one before, "
                        "on the same stream and from the same row, has no line of its own. A run has at most "
                        "50,000 lines here.")),
    "begin_s": ("s", N_("Time of the first pose in which a joint that the command drives has moved by more than "
                        "0.02 rad, a hand by 0.02 of its opening. Poses are recorded every 0.1 s. Blank if nothing "
                        "moved so far, if a joint still moved when the command came, or if it was not recorded.")),
    "end_s": ("s", N_("Time of the last pose by which one of them had moved by 0.02 rad more. Blank if they moved less "
                      "than 0.3 s before another command took over or the poses end.")),
    "response_s": ("s", N_("Time from the command until begin_s.")),
}  # fmt: skip
"""Unit and meaning of the columns that only the sheet Movements has."""
FIELD = N_("Field of a record on the stream, with its unit at the end of the name if it has one.")
KINDS = {
    "sensor": N_("A value of a sensor."),
    "stream": N_("A value of a row."),
    "anonymous": N_("A value of a row whose output cell is blank."),
    "actuator": N_("A command to an actuator."),
    "done": N_("The end of a command."),
    "sent by hand": N_("A value that a person sent into a stream."),
    "say": N_("What the robot said."),
    "sound": N_("A sound that the robot played."),
    "person": N_("What a person in the scene said."),
    "scene": N_(
        "A change of the scene by hand, such as a touch. What a sensor notices of it is a line of its own, "
        "with the kind sensor and a slightly later time."
    ),
    "press": N_("A button that the operator pressed. Its value is a line of its own, with the kind sensor."),
    "switch": N_("A behaviour that was switched on or off by hand."),
    "mark": N_("A moment that a person marked."),
    "edit": N_("A cell that was changed during the run."),
    "speed": N_("Another speed of the run."),
    "pause": N_("The run was paused."),
    "resume": N_("The run continued."),
    "step": N_("The paused run went on for one frame."),
    "clamp": N_("A command that was cut to a limit of the robot."),
    "error": N_("A formula or a device that failed."),
    "note": N_("Anything else that the program or the robot noted."),
}
"""Meaning of each word in the column `kind`."""


def explained(language: str) -> list[tuple[str, str, str]]:
    """Return name, unit and meaning of the columns in a language, then the kinds of lines."""
    columns = [(name, unit, translate(text, language)) for name, (unit, text) in COLUMNS.items()]
    columns += [(f"Movements: {name}", unit, translate(text, language)) for name, (unit, text) in MOVEMENTS.items()]
    return [*columns, *((f"kind: {kind}", "", translate(text, language)) for kind, text in KINDS.items())]
