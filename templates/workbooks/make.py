"""Makes the templates from their Markdown sources: `python templates/workbooks/make.py [FOLDER]`."""

from __future__ import annotations

import sys
from pathlib import Path

from rrp_sheets import api

HERE = Path(__file__).parent


def main(target: Path = HERE) -> None:
    for source in sorted((HERE / "source").glob("*.md")):
        made = api.convert(source, target / f"{source.stem}.xlsx")
        print(made.name)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE)
