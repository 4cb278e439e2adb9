"""Codes of the command line."""

from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {}
