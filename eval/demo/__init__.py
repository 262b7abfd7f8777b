"""The whole pipeline in a row, and its report."""
