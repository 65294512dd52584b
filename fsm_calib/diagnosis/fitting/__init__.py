"""The fit: Gauss-Newton on whitened innovations, and the base robot that every hypothesis re-fits."""
