"""What every output is written from and by: documents, facts, tables, files, options, progress, refusals."""
