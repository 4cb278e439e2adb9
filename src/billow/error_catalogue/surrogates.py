"""Codes of surrogates."""

from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {}
