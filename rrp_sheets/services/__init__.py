"""What is done with whole files: bundles, printed protocols, drawn changes, edited copies, poses, queries."""
