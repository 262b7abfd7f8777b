"""The whole road in a row, and its report."""
