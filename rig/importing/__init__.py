"""Import of other laboratories' records: mapping files, checks, and the session written from them."""
