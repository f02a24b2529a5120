"""W_T, the energy per cycle predicted by the model, and its uncertainty."""
