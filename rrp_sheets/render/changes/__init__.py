"""Drawing what changed in a behaviour: on its diagram, what came, what went and what is another one now."""
