"""Pages to look at and to keep: `report` makes that of a run, `index` that of many."""
