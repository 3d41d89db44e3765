"""How far a lock is from breaking in nonlinear runs: basins, shocks, headroom."""
