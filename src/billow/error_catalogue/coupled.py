"""Codes of force inputs and of coupled models."""

from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {}
