"""Studies: from one run to an answer. Designs, tables, maps of classes, sensitivities and cohorts, by one engine."""
