"""How the compiled step may compute: the options of every function that `kernel` weaves together.

``error_model="numpy"`` gives infinities in place of exceptions. The liberties: a product and a sum may become one
operation with one rounding (``contract``), a division the product with a reciprocal (``arcp``), and the sign of a
zero may change (``nsz``). Each changes a result in its last digit only, and a tenth of the time is saved. NaN and
infinity keep their meaning, and sums their order. Nothing here makes an array, and no references to arrays are counted
(``_nrt``): such a count is an operation that locks memory, a step made dozens, and they took a third of its time.
``EXACT`` takes none of them, where another program's
arithmetic is repeated to the last bit.
"""

from __future__ import annotations

from typing import Any

ARITHMETIC: dict[str, Any] = {
    "error_model": "numpy",
    "fastmath": {"contract", "arcp", "nsz"},
    "_nrt": False,
}
EXACT: dict[str, Any] = {"error_model": "numpy"}
