"""Codes of obstacles."""

from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {}
