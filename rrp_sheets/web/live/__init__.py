"""The run panel: a run that everyone at the workbook sees, and what they can do to it."""
