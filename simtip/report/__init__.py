"""Pictures and pages of results. The only place that imports a plotting library."""
