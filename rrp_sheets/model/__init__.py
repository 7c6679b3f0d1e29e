"""The model: what a workbook says, as frozen dataclasses, independent of any file format."""
