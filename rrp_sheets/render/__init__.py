"""Model and graph in, diagrams and sentences out. Imports no runtime and no simulator."""
