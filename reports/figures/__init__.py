"""Figures by Matplotlib, which is imported only inside the call that draws."""
