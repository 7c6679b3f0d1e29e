"""Run panel: a run that everyone with the workbook open sees, and the actions that users have on it."""
