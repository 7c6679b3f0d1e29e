"""Diagrams and sentences made from a workbook's model and graph. Imports no runtime and no simulator."""
