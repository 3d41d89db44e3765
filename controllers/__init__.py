"""Semi-active laws, each a folder: design (slow, offline) and law apart."""
