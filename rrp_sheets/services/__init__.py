"""Services on whole files: bundles, printed protocols, drawn changes, edited copies, poses, queries."""
