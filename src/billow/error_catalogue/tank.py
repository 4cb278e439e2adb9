"""Codes of tank tests."""

from billow.base.errors import InputError
from billow.error_catalogue.entry import Entry

CODES: dict[str, Entry] = {
    "E-TANK-001": Entry(
        InputError,
        "The file of a tank test cannot be read.",
        "A misspelt path, or a file that is not TOML.",
        "Give a TOML file; docs/tank.md has one to start from.",
    ),
    "E-TANK-002": Entry(
        InputError,
        "A key of a tank test is unknown, missing or has a value that cannot be used.",
        "A misspelt key, or a number in another unit.",
        "Correct the key that the message names; docs/tank.md lists them all.",
    ),
    "E-TANK-003": Entry(
        InputError,
        "A gas of a tank test is not known.",
        "A misspelt formula, or a gas without data.",
        "Use one of the gases that the message lists.",
    ),
    "E-TANK-004": Entry(
        InputError,
        "The mole fractions of a gas do not sum to one.",
        "A missing share, or percentages written as numbers.",
        'Correct them; percentages are written as "45 %".',
    ),
    "E-TANK-005": Entry(
        InputError,
        "The file is not a trace.",
        "A misspelt path, text among the numbers, rows of unequal length, or too few rows after ignition.",
        "Give a CSV file with one header row and then numbers only.",
    ),
    "E-TANK-006": Entry(
        InputError,
        "A trace lacks the column of time or pressure.",
        "A header without unit, or with one that is not known.",
        "Head the columns with quantity and unit, for example: time [ms],pressure [kPa].",
    ),
    "E-TANK-007": Entry(
        InputError,
        "The times of a trace do not increase.",
        "Two tests in one file, or times written with too few digits.",
        "Give one test in the order of time, each instant once.",
    ),
    "E-TANK-008": Entry(
        InputError,
        "The absolute pressure of a trace is negative, or its gas is not above 0 K.",
        "Gauge pressure stated as absolute, or degrees Celsius.",
        'State pressure = "gauge" if the file holds gauge pressure; give temperatures in kelvin.',
    ),
    "E-TANK-009": Entry(
        InputError,
        "The trace does not begin at the pressure that the tank is said to hold.",
        "Gauge and absolute pressure confused, or another ambient pressure.",
        'Correct the pressure of [tank], or pressure = "absolute" or "gauge" of [measurement].',
    ),
    "E-TANK-010": Entry(
        InputError,
        "The pressure falls although the tank is said to lose no heat.",
        "Gas cools at the wall, water condenses, or the tank leaks.",
        "Give wall_area and heat_transfer of [tank], or end_time of [measurement] to stop at the peak.",
    ),
    "E-TANK-011": Entry(
        InputError,
        "The pressure of a trace does not rise.",
        "An inflator that did not fire, another channel, or a wrong unit.",
        "Give the trace of a deployment.",
    ),
    "E-TANK-012": Entry(
        InputError,
        "A tank test lacks what its prediction or evaluation needs.",
        "No mass flow or temperature, or not said whether the pressure is absolute.",
        "Add the key that the message names.",
    ),
    "E-TANK-013": Entry(
        InputError,
        "No temperature of the inflow makes the measured pressure with the weighed mass.",
        "A mass in another unit, a wrong volume, or gauge and absolute pressure confused.",
        "Check total_mass, volume and gas.",
    ),
    "W-TANK-001": Entry(
        None,
        "What the flow leaves unexplained of the pressure is not independent noise, so the band is too narrow.",
        "A filtered or ringing signal, or a loss to the wall that the case lacks.",
        "Give every n-th row of a filtered trace, or correct the loss to the wall.",
    ),
    "W-TANK-002": Entry(
        None,
        "The mass found from the pressure is not the mass that was weighed.",
        "A wrong temperature, volume, composition or loss to the wall.",
        "Leave out the temperature to have it found from the weight, or correct what is wrong.",
    ),
}
