"""From an atlas to a machine: conditions on designs and what follows from them."""
