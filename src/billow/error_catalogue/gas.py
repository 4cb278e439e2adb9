"""Codes of the gas."""

from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {}
