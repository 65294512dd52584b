"""The command line of a generator: robots by number, one key for all of them."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

Made = Callable[[int, int, Path, bool], dict[str, Any]]


def main(about: str | None, made: Made) -> None:
    """Command line; made(seed, index, out, verbose) : generates a robot and returns its key."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--robots", type=int, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", default="", help="indices, with commas")
    parser.add_argument("--verbose", action="store_true", help="tells what each robot carries")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    chosen = [int(k) for k in args.only.split(",") if k] or list(range(args.robots))
    path = args.out / "keys.json"
    old = json.loads(path.read_text()) if path.exists() and args.only else []
    keys = {key["name"]: key for key in old}
    for index in chosen:
        key = made(args.seed, index, args.out, args.verbose)
        keys[key["name"]] = key
        path.write_text(json.dumps([keys[n] for n in sorted(keys)], indent=1) + "\n")
