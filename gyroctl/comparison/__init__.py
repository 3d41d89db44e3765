"""The fair comparison: several laws on identical realisations, from an experiment file to a labelled dataset."""
