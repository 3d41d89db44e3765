"""What the tables of an evaluation are called."""

TITLES = {
    "seas": "All laws in three seas",
    "offdesign": "Off the design, same parameters",
    "information": "The price of information",
    "information_real": "The price of information in real water",
    "robustness": "Devices that differ from the design",
    "physics": "The laws in real water",
    "price": "The price list of real water",
    "faults": "Faults and other devices in real water",
    "gauge": "What a wave gauge up-wave is worth",
    "real": "Laws in real water, each with its set for it",
}
"""By the names of the tables, in their order on a page."""
