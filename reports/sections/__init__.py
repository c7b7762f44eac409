"""Sections of the derivation report, each built from results into blocks of the document model."""
