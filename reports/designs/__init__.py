"""Design: which headings, speeds and positions meet what is required, and do best."""
