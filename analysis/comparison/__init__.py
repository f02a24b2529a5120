"""A session against its prediction: agreement, null tests, claims, verdict."""
