"""Diagrams of the changes in a behaviour: added, removed and changed rows and streams."""
