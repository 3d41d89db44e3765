"""Studies: questions put to the device, each answered with pictures, data and intervals."""
