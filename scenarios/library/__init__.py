"""Objects by the dozen: parametric kinds, the library drawn from them, and the format that any library has."""
