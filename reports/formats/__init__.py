"""Renderers of the document model, one format each."""
