"""A collection of made shapes to train on: families of things that people model, every one different."""
