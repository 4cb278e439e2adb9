"""Codes of geometry and mesh."""

from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {}
