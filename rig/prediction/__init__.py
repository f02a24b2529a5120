"""W_T, the energy per cycle that the model predicts, and its uncertainty."""
