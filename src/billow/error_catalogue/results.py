"""Codes of results, datasets and interrupted runs."""

from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {}
