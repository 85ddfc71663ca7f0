"""Drive logs in the formats of others, one module a format; `clip` says what part of a drive is exported."""
