"""From words to a model: the configuration, what it refuses, and what is built of it."""
