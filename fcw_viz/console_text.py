"""Words on a terminal: counts, and text of others, in which nothing is an order to it or to rich."""


def printable(text: str) -> str:
    """A text in which control characters and halves of characters are shown as what they are."""
    return "".join(
        character if character.isprintable() or character == "\n" else ascii(character)[1:-1]
        for character in text
    )


def one_line(text: str) -> str:
    """As `printable`, with line breaks shown as what they are too: the name of a file may hold them."""
    return printable(text).replace("\n", "\\n")


def counted(count: int, one: str, many: str = "") -> str:
    """A number of things, e.g. `1 frame` or `3 boxes`; `many` is for a plural that has no s alone."""
    return f"{count} {one if count == 1 else many or one + 's'}"
