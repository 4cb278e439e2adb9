"""Codes of runs that are stopped."""

from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {}
