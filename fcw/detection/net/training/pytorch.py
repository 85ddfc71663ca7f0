"""PyTorch, which only training needs, or a word on how to install it."""

import importlib
from typing import Any

from fcw.errors import UserError

try:
    torch: Any = importlib.import_module("torch")
except ImportError as error:
    raise UserError(
        "training the net needs PyTorch and onnx; install them with: pip install 'fcw[train]'"
    ) from error

nn: Any = torch.nn
functional: Any = torch.nn.functional
