"""Plants, poles, conversion, noise and sampling: what every other room of the engine stands on."""
