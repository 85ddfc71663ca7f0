"""The one exception that stands for a mistake in the user's input."""


class UserError(Exception):
    """Wrong input from the user: one message, exit code 2, no traceback.

    The message names the file or option, the value found, what was expected and what to do about it.
    Everything else that is raised is a fault of the program (exit code 1).
    """
