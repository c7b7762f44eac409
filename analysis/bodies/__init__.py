"""A body with an outline on its way: wheels that enter and leave under it, sliding along its edges, tipping."""
