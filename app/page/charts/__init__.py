"""Draw figures as uPlot charts, SVG and tables."""
