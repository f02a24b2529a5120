"""The compiled bed of one mass: its flights, a cycle, many cycles."""
