"""The bounds of formulas (design: 3-formulas, Safety). One place, used by the check and by the evaluator."""

LONGEST_FORMULA = 500  # characters
MOST_NODES = 150
DEEPEST = 30
LARGEST_NUMBER = 10**15
LONGEST_TEXT = 2_000
LONGEST_LIST = 1_000
MOST_LEAVES = 10_000  # of a result, lists within lists counted whole
MOST_LOOPS = 2
MOST_TEXTS_DEEP = 4  # texts with values in texts with values
LONGEST_FIELD = 200  # letters of a field's name that a formula works out
STEPS = 20_000  # per evaluation, shared with the helpers it calls
DEEPEST_HELPERS = 20  # helpers that call helpers that call …
